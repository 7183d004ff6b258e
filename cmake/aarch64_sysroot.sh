#!/usr/bin/env bash
# aarch64_sysroot.sh FOLDER PACKAGE...
# Unpacks Debian's arm64 packages, and what they depend on, into FOLDER. Nothing is installed on this machine, and no script of a package runs.
# A folder that was made for the same packages is left as it is.
set -euo pipefail
folder=$(realpath -m "$1")
shift
stamp=$folder/packages
[[ -f $stamp && $(<"$stamp") == "$*" ]] && exit 0
rm -rf "$folder"
mkdir -p "$(dirname "$folder")"
mmdebstrap --architectures=arm64 --variant=extract --include="libc6-dev $*" bookworm "$folder" >"$folder.log" 2>&1 || {
    tail -n 5 "$folder.log" >&2
    exit 1
}
cd "$folder/usr/lib/aarch64-linux-gnu"
# The scripts of the packages would have chosen one BLAS and LAPACK among several.
ln -sf atlas/lib{blas,lapack}.so{,.3} .
# Draco's CMake files name files of the machine that it was built for.
sed -i 's#"/usr#"${CMAKE_SYSROOT}/usr#' cmake/draco/draco-targets*.cmake
echo "$*" >"$stamp"
