#!/usr/bin/env bash
# Usage: demo.sh SAMARA [OUTPUT_DIR]
# The whole way on measured drops of a coin in water: codebook, certificate, query, fit, and the same fit by direct
# integration. Fails if the codebook misses 1e-4 or the two fits differ by more than 0.5 %.
set -euo pipefail
samara=$(realpath "$1")
output=${2:-build/demo}
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$output"
book=$output/coin.h5

echo "== 1. Build the codebook of the coin: x and v over time, drag coefficient and initial speed"
"$samara" build "$here/plan.toml" -o "$book"
echo
echo "== 2. Ask it: depth and speed at C_D = 1.15, released with 0.1 m/s, and how they change with each"
"$samara" query "$book" --set C_D=1.15 --set "v(0)=0.1" --at 0.1 0.3 0.5 --gradient
echo
echo "== 3. Fit C_D to all ten tracks of the five drops; every track has its own start and offset"
for span in 0.3 0.4 0.5; do
  "$samara" fit "$book" "$here/coin.toml" --config "$here/fit.toml" --span "$span" \
    -o "$output/fit_$span.json" >"$output/fit_$span.txt"
  "$samara" fit "$book" "$here/coin.toml" --config "$here/fit.toml" --span "$span" --reference \
    -o "$output/reference_$span.json" >"$output/reference_$span.txt"
done
/usr/bin/python3 "$here/table.py" "$output" 0.3 0.4 0.5
