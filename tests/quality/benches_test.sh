#!/usr/bin/env bash
# Runs every benchmark program for a moment, on maps of 16 x 16 texels and the smallest picture: benches_test.sh BUILD_FOLDER
set -euo pipefail

build=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# run PROGRAM ARGUMENT...: it must end well and print a table.
run() {
    "$build/$1" "${@:2}" >"$folder/log" 2>&1 || { cat "$folder/log"; echo "failed: $*"; exit 1; }
    grep -q '^| ' "$folder/log" || { cat "$folder/log"; echo "no table: $*"; exit 1; }
}

"$build/lightcook_verify_bench" --write "$folder" --kinds room --size 16
mkdir "$folder/scenes"
mv "$folder/room.exr" "$folder/scenes/room_lightmap.exr"
run lightcook_bench --data "$folder" --layouts ratio
run lightcook_bench --data "$folder" --layouts ratio --copies 3 --period 2 --scan-lines
run lightcook_verify_bench --kinds even --layouts flat --size 16 --beside "$folder/scenes/room_lightmap.exr"
run lightcook_verify_bench --kinds even --layouts flat --size 16 --unity --beside "$folder/scenes/room_lightmap.exr"
run lightcook_peers --data "$folder" --layouts ratio,l1-truncation --effort 0
run lightcook_fit_bench --data "$folder" --samples 1 --runs 1
run lightcook_encoder_bench --own --formats bc1 --efforts 0 --seconds 0.01
if "$build/lightcook_verify_bench" --kinds dusk >"$folder/log" 2>&1 || ! grep -q "no kind of light is called 'dusk'" "$folder/log"; then
    cat "$folder/log"
    echo "a kind of light that there is not was not refused"
    exit 1
fi
