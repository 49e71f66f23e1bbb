#!/usr/bin/env bash
# Usage: demo.sh SAMARA QUERY FOLDER
# Builds the codebook of a falling plate, and asks it from C++.
set -euo pipefail
mkdir -p "$3"
"$1" build "$(dirname "$0")/plate.toml" -o "$3/plate.h5" >/dev/null 2>&1
"$2" "$3/plate.h5" | tee "$3/answers.txt"
# The three ways to the same place agree.
y=$(sed -n 's/^y = \([^,]*\),.*/\1/p' "$3/answers.txt")
[ -n "$y" ]
grep -q "at y = $y\$" "$3/answers.txt"
grep -q "^y at the end $y," "$3/answers.txt"
