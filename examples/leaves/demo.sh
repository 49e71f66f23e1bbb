#!/usr/bin/env bash
# demo.sh SAMARA LEAVES LEAVES_GLB FOLDER: from the sweep of one leaf to a thousand that land, and to a film of them.
set -euo pipefail
samara=$1 leaves=$2 leaves_glb=$3 folder=$4
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$folder"
"$samara" sweep "$here/leaf.toml" -o "$folder/sweep.h5"
"$samara" database "$folder/sweep.h5" -o "$folder/leaf.h5"
"$leaves" "$folder/leaf.h5"
"$leaves_glb" "$folder/leaf.h5" "$folder/leaves.glb"
[ "$(head -c 4 "$folder/leaves.glb")" = glTF ]
if "$leaves" "$here/leaf.toml" 2>"$folder/refusal"; then exit 1; fi
grep -q "leaf.toml" "$folder/refusal"
