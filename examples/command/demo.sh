#!/usr/bin/env bash
# Usage: demo.sh SAMARA [OUTPUT_DIR]
# A program becomes a codebook: build it, ask the codebook and the program for the same sphere. Fails if they differ by
# more than the tolerance, 1e-4 of the range. Then a NumPy program that is started once, and validated by its plan.
set -euo pipefail
samara=$(realpath "$1")
mkdir -p "${2:-build/demo}"
book=$(realpath "${2:-build/demo}")/settling.h5
cd "$(dirname "$0")"

"$samara" build settling.toml -o "$book"
told=$("$samara" query "$book" --set "diameter=0.5 mm" --set density=2650 | tail -1)
asked=$(echo "0.5e-3 2650 1.002e-3" | python3 settling.py)
echo "diameter, density, speed, Reynolds number of the codebook: $told"
echo "speed, Reynolds number of the program: $asked"
python3 -c "
import sys
told, asked = float(sys.argv[1].split(',')[2]), float(sys.argv[2].split()[0])
sys.exit(abs(told - asked) > 1e-4 * 0.17)" "$told" "$asked"

books=$(dirname "$book")
"$samara" build suspension.toml -o "$books/suspension.h5"
"$samara" validate "$books/suspension.h5" --plan suspension.toml --points 1000 --seed 7
