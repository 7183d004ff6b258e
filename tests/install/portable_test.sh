#!/usr/bin/env bash
# Makes the portable tar and tries it where nothing of Debian 12 is installed: a bare Debian 13, whose glibc is newer. Every library comes from
# the tar or is glibc's; demo, verify, view --export and an image of OpenImageIO work as a user without rights. Needs root, debootstrap,
# patchelf and a Debian mirror; otherwise exits with 77, which ctest reports as skipped.
#   portable_test.sh BUILD_DIR
set -euo pipefail
build=$1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
name=portable_test
out=$build/portable_test
suite=trixie
. "$here/../bare_root.sh"

skip() { echo "skipped: the portable tar was not tried on another distribution: $*"; exit 77; }
reason=$(why_no_root)
[[ -z $reason ]] || skip "$reason"
command -v patchelf >/dev/null || skip "patchelf is missing: ./dev setup package"
rm -rf "$out"
mkdir -p "$out"
[[ -f $cache/$suite.tar ]] || debootstrap --print-debs "$suite" "$out/probe" "$mirror/debian" >"$out/mirror.log" 2>&1 ||
    skip "debootstrap reaches no mirror at $mirror ($out/mirror.log)"

"$here/../../cmake/portable.sh" "$build" "$out" >"$out/portable.log" 2>&1 || { tail "$out/portable.log"; die "no tar was made"; }
make_root
mkdir "$root/opt/lightcook"
tar -C "$root/opt/lightcook" --strip-components=1 -xf "$out"/lightcook-*.tar.xz
chown -R nobody "$root/opt/lightcook"
program=/opt/lightcook/bin/lightcook

foreign='=> /(lib|usr)/'
glibc='(libc|libm|libdl|libpthread|librt|libresolv|libutil|libmvec)\.so'
inside libraries bash -c "ldd $program $program-read /opt/lightcook/lib/lightcook/lightcook_images.so"
if grep 'not found' "$out/libraries.log"; then die "libraries are missing"; fi
if grep -E "$foreign" "$out/libraries.log" | grep -vE "$glibc"; then die "libraries of the system are used"; fi
[[ -s $root/opt/lightcook/share/doc/lightcook/licences/THIRD-PARTY.md ]] || die "the licences are not listed"

as_user() { inside "$1" runuser -u nobody -- env HOME=/tmp bash -c "cd /tmp && $2"; }
as_user demo "$program demo -o /tmp/demo"
as_user verify "$program verify /tmp/demo"
as_user view "$program view /tmp/demo --export /tmp/view"
printf 'P6 4 4 255\n%048d' 0 >"$root/tmp/picture.ppm"
as_user picture "$program encode /tmp/picture.ppm /tmp/picture.ktx2 --format bc7"  # read by OpenImageIO
[[ -s $root/tmp/demo/report.html && -s $root/tmp/view/index.html ]] || die "the demo left no report, or view no page"
echo "portable_test: $(du -h "$out"/lightcook-*.tar.xz | cut -f 1) of tar, $(find "$root/opt/lightcook/lib/lightcook/libraries" -type f | wc -l) libraries"
