#!/usr/bin/env bash
# Makes the Debian packages and installs them with apt in a bare Debian 12: `lightcook demo` runs there as a user without rights, and a
# project that calls find_package(lightcook) builds against the development package. Needs root, debootstrap and a Debian mirror;
# otherwise exits with 77, which ctest reports as skipped.
#   package_test.sh BUILD_DIR
set -euo pipefail
build=$1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
name=package_test
out=$build/package_test
. "$here/../bare_root.sh"

skip() { echo "skipped: the Debian packages were not installed in a clean root: $*"; exit 77; }
reason=$(why_no_root)
[[ -z $reason ]] || skip "$reason"
command -v dpkg-shlibdeps >/dev/null || skip "dpkg-shlibdeps is missing: apt-get install dpkg-dev"
rm -rf "$out"
mkdir -p "$out"
[[ -f $cache/bookworm.tar ]] || debootstrap --print-debs bookworm "$out/probe" "$mirror/debian" >"$out/mirror.log" 2>&1 ||
    skip "debootstrap reaches no mirror at $mirror ($out/mirror.log)"

(cd "$build" && cpack -G DEB -B "$out/packages") >"$out/cpack.log" 2>&1 || { tail "$out/cpack.log"; die "cpack failed: $out/cpack.log"; }
make_root
mkdir "$root/root/packages"
cp "$out"/packages/*.deb "$root/root/packages/"
cp -r "$here/consumer" "$root/root/consumer"
inside update apt-get -q update
inside install bash -c 'apt-get -q -y --no-install-recommends install /root/packages/lightcook_*.deb'
inside demo runuser -u nobody -- env HOME=/tmp bash -c 'cd /tmp && lightcook demo -o /tmp/demo'
[[ -s $root/tmp/demo/report.html ]] || die "the packaged 'lightcook demo' left no report"
inside install_dev bash -c 'apt-get -q -y --no-install-recommends install g++ cmake ninja-build /root/packages/liblightcook-dev_*.deb'
inside consumer bash -c 'cmake -S consumer -B build -G Ninja && cmake --build build && build/consumer texture.ktx2'
inside remove apt-get -q -y remove lightcook liblightcook-dev
[[ ! -e $root/usr/share/lightcook && ! -e $root/usr/lib/lightcook ]] || die "removing the packages left files behind"
