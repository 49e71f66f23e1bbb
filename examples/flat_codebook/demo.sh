#!/usr/bin/env bash
# Usage: demo.sh SAMARA CC INCLUDE FOLDER
# Builds a small codebook, u = (10/k - 1) t, makes a flat file of it, and asks that from a program in C that knows no library of ours.
set -euo pipefail
mkdir -p "$4"
"$1" build "$(dirname "$0")/../c_interface/rate.toml" -o "$4/rate.h5" 2>/dev/null
"$1" export "$4/rate.h5" --to flat -o "$4/rate.flat"
"$2" -std=c99 -Wall -Wextra -Wpedantic -Werror -O3 -I "$3" "$(dirname "$0")/fall.c" -lm -o "$4/fall"
"$4/fall" "$4/rate.flat"
"$4/fall" "$4/rate.flat" 7 4 | tee "$4/answer.txt"
grep -q "u = 10.5 " "$4/answer.txt"
# The loader, the C library and libm, and at most what the kernel lends.
if command -v ldd >/dev/null; then
  if ldd "$4/fall" | grep -vE 'linux-vdso|libm\.|libc\.|ld-linux'; then exit 1; fi
fi
status=0
"$4/fall" "$4/rate.flat" 7 40 2>"$4/error.txt" || status=$?
[ "$status" -eq 5 ] && grep -q "k is outside" "$4/error.txt"
head -c 1000 "$4/rate.flat" >"$4/cut.flat"
status=0
"$4/fall" "$4/cut.flat" 2>"$4/error.txt" || status=$?
cat "$4/error.txt"
[ "$status" -eq 3 ] && grep -q "cut off" "$4/error.txt"
status=0
"$4/fall" "$4/rate.h5" 2>"$4/error.txt" || status=$?
[ "$status" -eq 3 ]
status=0
"$1" export "$4/rate.h5" --to flat --set k=4 -o "$4/no.flat" 2>"$4/error.txt" || status=$?
[ "$status" -eq 2 ] && grep -q "whole codebook" "$4/error.txt"
