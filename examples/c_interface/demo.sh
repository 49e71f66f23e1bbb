#!/usr/bin/env bash
# Usage: demo.sh SAMARA ASK FOLDER
# Builds a small codebook, and asks it from C: u = (10/k - 1) t.
set -euo pipefail
mkdir -p "$3"
"$1" build "$(dirname "$0")/rate.toml" -o "$3/rate.h5" 2>/dev/null
"$2" "$3/rate.h5" | tee "$3/holds.txt"
grep -q "tolerance 1e-09 met" "$3/holds.txt"
"$2" "$3/rate.h5" 7 4 | tee "$3/answer.txt"
grep -q "u = 10.5 " "$3/answer.txt"
status=0
"$2" "$3/rate.h5" 7 40 2>"$3/error.txt" || status=$?
cat "$3/error.txt"
[ "$status" -eq 5 ] && grep -q "k = 40 is outside" "$3/error.txt"
status=0
"$2" "$(dirname "$0")/rate.toml" 2>"$3/error.txt" || status=$?
[ "$status" -eq 3 ] && grep -q "is not an HDF5 file" "$3/error.txt"
