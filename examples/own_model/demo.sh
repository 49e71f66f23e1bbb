#!/usr/bin/env bash
# Usage: demo.sh SAMARA LIBRARY [OUTPUT_DIR]
# A model as text, from its equations to a fit; then the same law compiled, from a library that the command loads. Fails
# if the two answer differently by more than their tolerances.
set -euo pipefail
samara=$(realpath "$1")
library=$(realpath "$2")
mkdir -p "${3:-build/demo}"
books=$(realpath "${3:-build/demo}")
cd "$(dirname "$0")"

"$samara" models predator_prey.toml
"$samara" build plan.toml -o "$books/text.h5"
"$samara" fit "$books/text.h5" counts.toml --config fit.toml

sed 's/predator_prey.toml/predator_prey_law/' plan.toml >"$books/compiled.toml"
"$samara" --model-library "$library" build "$books/compiled.toml" -o "$books/compiled.h5"
ask() { "$samara" query "$1" --set growth=1.03 --set hunt=0.093 --at "7 s" | tail -1; }
echo "growth, hunt, t, prey, predator of the text: $(ask "$books/text.h5")"
echo "                          of the library: $(ask "$books/compiled.h5")"
python3 -c "
import sys
text, compiled = ([float(cell) for cell in row.split(',')[-2:]] for row in sys.argv[1:])
sys.exit(any(abs(a - b) > 2e-4 * 40 for a, b in zip(text, compiled)))" "$(ask "$books/text.h5")" "$(ask "$books/compiled.h5")"
