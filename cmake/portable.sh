#!/usr/bin/env bash
# Makes a tar of the program and of every library that it needs but those of glibc: it runs on any x86-64 Linux whose glibc is at least as
# new as that of the machine that built it. `./dev package tar` calls it.
#   portable.sh BUILD_DIR OUT_DIR     writes OUT_DIR/lightcook-VERSION-linux-x86_64.tar.xz and prints its path
#
# The libraries lie in lib/lightcook/libraries, and a relative RUNPATH in every file names that folder, so the tree can be moved. Licences of
# what is included are in share/doc/lightcook/licences, and THIRD-PARTY.md beside them is the list.
set -euo pipefail
build=$1 out=$2
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
die() { echo "portable: $*" >&2; exit 1; }
for tool in patchelf dpkg-query xz; do
    command -v $tool >/dev/null || die "$tool is missing: ./dev setup package"
done

# What the loader and the C library bring along: these must be those of the machine that runs the program.
glibc='^(linux-vdso|ld-linux-x86-64|libc|libm|libdl|libpthread|librt|libresolv|libutil|libanl|libmvec|libnss_[a-z]+|libBrokenLocale)\.so'
# Packages whose code is compiled into the program: headers, static libraries, and the npm packages of the viewer's page.
compiled_in=(libglm-dev libexpected-dev nlohmann-json3-dev libeigen3-dev libtomlplusplus-dev libcli11-dev libcpp-httplib-dev
    libdraco-dev libhwy-dev)
page_packages=(three ktx-parse zstddec)

version=$(sed -n 's/^project(lightcook VERSION \([0-9.]*\).*/\1/p' "$source/CMakeLists.txt")
name=lightcook-$version-linux-x86_64
mkdir -p "$out"
work=$(mktemp -d "$out/portable.XXXXXX")
trap 'rm -rf "$work"' EXIT
tree=$work/$name
cmake --install "$build" --component runtime --strip --prefix "$tree" >"$work/install.log" || die "cmake --install failed"
libraries=$tree/lib/lightcook/libraries licences=$tree/share/doc/lightcook/licences
mkdir -p "$libraries" "$licences"

# "NAME PATH" of every library of a file, those of libraries included.
libraries_of() { ldd "$1" | sed -nE 's/^\s*(\S+) => (\/\S+) .*/\1 \2/p'; }

# "PATH PACKAGE" of the files whose paths are read. dpkg knows some by the path before /lib became a link to /usr/lib: all forms are asked for.
packages_of() {
    local file files=()
    while read -r file; do
        file=$(readlink -f "$file")
        files+=("$file" "${file#/usr}" "/usr$file")
    done
    dpkg-query -S "${files[@]}" 2>/dev/null | sed -nE 's/^([^ ,]+): (\/.*)$/\2 \1/p' | sed -E 's#^/lib/#/usr/lib/#' || true
}

# add_licence PACKAGE CONTENT: copies the copyright file and adds a row to the list.
add_licence() {
    local package=${1%%:*}
    cp "/usr/share/doc/$package/copyright" "$licences/$package.txt" || die "the licence of $package is missing"
    echo "| $2 | $package $(dpkg-query -W -f '${Version}' "$1") | [$package.txt]($package.txt) |" >>"$work/rows"
}

program=$tree/bin/lightcook reader=$tree/bin/lightcook-read images=$tree/lib/lightcook/lightcook_images.so
for file in "$program" "$reader" "$images"; do libraries_of "$file"; done | sort -u | grep -vE "$glibc" >"$work/needed"
if { ldd "$program"; ldd "$reader"; ldd "$images"; } | grep 'not found'; then die "libraries are missing on this machine"; fi
cut -d ' ' -f 2 "$work/needed" | packages_of >"$work/owners"
while read -r library path; do
    cp -L "$path" "$libraries/$library"
    # shellcheck disable=SC2016  # the loader replaces $ORIGIN
    patchelf --set-rpath '$ORIGIN' "$libraries/$library"
    package=$(awk -v file="$(readlink -f "$path")" '$1 == file { print $2; exit }' "$work/owners")
    [[ -n $package ]] || die "$path belongs to no package, so its licence is not known"
    echo "$package $library" >>"$work/packages"
done <"$work/needed"
# shellcheck disable=SC2016
for file in "$program" "$reader"; do patchelf --set-rpath '$ORIGIN/../lib/lightcook/libraries' "$file"; done
# shellcheck disable=SC2016
patchelf --set-rpath '$ORIGIN/libraries' "$images"

while read -r package; do
    add_licence "$package" "$(sed -n "s/^$package //p" "$work/packages" | paste -sd ' ')"
done < <(cut -d ' ' -f 1 "$work/packages" | sort -u)
for package in "${compiled_in[@]}"; do add_licence "$package" "compiled into the program"; done
for package in "${page_packages[@]}"; do
    cp "$source/viewer/node_modules/$package/LICENSE"* "$licences/npm-$package.txt" 2>/dev/null ||
        sed -n 's/.*"license": "\(.*\)".*/Licence: \1/p' "$source/viewer/node_modules/$package/package.json" >"$licences/npm-$package.txt"
    echo "| page of \`lightcook view\` | npm $package | [npm-$package.txt](npm-$package.txt) |" >>"$work/rows"
done
{
    echo "# Software of others in this folder"
    echo
    echo "| content | package of Debian 12 | licence |"
    echo "| --- | --- | --- |"
    sort "$work/rows"
} >"$licences/THIRD-PARTY.md"

# The same build gives the same tar. A low level of xz, since most of the 400 MiB is code of others that every run would pack anew.
tar -C "$work" --sort=name --owner=0 --group=0 --numeric-owner --mtime='2026-01-01 00:00Z' -cf - "$name" | xz -2 -T0 >"$work/$name.tar.xz"
mv "$work/$name.tar.xz" "$out/"
echo "$out/$name.tar.xz"
