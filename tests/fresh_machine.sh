#!/usr/bin/env bash
# The promise of the README, kept on a machine that has nothing: a bare Debian 12 in a folder, a fresh clone in it, and then ./dev demo,
# ./dev setup twice, a picture of the report by headless Chromium, and ./dev test. Needs root, debootstrap, git and a Debian mirror.
#   tests/fresh_machine.sh [--out DIR] [--keep] [--only setup|demo|test]
#     --out DIR   where logs, the demo's output and the picture of its report go (default: build/fresh_machine)
#     --keep      leave the root where it is (its mounts are taken down all the same)
#     --only STEP only the setups, only these and the demo with its picture, or only these and the tests
# Environment: LIGHTCOOK_FRESH_CACHE keeps the bare root and the .deb files between runs (default: /tmp/lightcook-fresh-cache);
# DEBIAN_MIRROR names another mirror than http://deb.debian.org.
# What is committed is what is tried: changes that are not committed are not in the clone.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cache=${LIGHTCOOK_FRESH_CACHE:-/tmp/lightcook-fresh-cache}
mirror=${DEBIAN_MIRROR:-http://deb.debian.org}
out=$repository/build/fresh_machine
keep=false
only=all
while [[ $# -gt 0 ]]; do
    case $1 in
        --out) out=$2; shift ;;
        --keep) keep=true ;;
        --only) only=$2; shift ;;
        *) echo "fresh_machine: unknown argument '$1'" >&2; exit 2 ;;
    esac
    shift
done
die() { echo "fresh_machine: $*" >&2; exit 1; }
[[ $only =~ ^(all|setup|demo|test)$ ]] || die "--only takes setup, demo or test, not '$only'"
[[ $EUID == 0 ]] || die "must run as root (chroot, mount)"
command -v debootstrap >/dev/null || die "debootstrap is missing: apt-get install debootstrap"
mkdir -p "$out" "$cache/archives/partial"
out=$(cd "$out" && pwd)

# --- the bare root ----------------------------------------------------------------------------------------------------------------------

root=$(mktemp -d /tmp/lightcook-fresh-root.XXXXXX)
mounted=()
leave() {
    local index
    for ((index = ${#mounted[@]} - 1; index >= 0; --index)); do
        umount "${mounted[index]}" || umount --lazy "${mounted[index]}"
    done
    if $keep; then
        echo "fresh_machine: the root stays in $root"
    else
        rm -rf --one-file-system "$root"
    fi
}
trap leave EXIT

bind() {  # SOURCE PLACE-IN-ROOT [OPTIONS]
    mkdir -p "$root/$2"
    mount --bind "$1" "$root/$2"
    mounted+=("$root/$2")
    if [[ -n ${3:-} ]]; then mount -o "remount,bind,$3" "$root/$2"; fi
}

if [[ ! -f $cache/bookworm.tar ]]; then
    debootstrap --variant=minbase bookworm "$root" "$mirror/debian" >"$out/debootstrap.log" 2>&1 || die "debootstrap failed: $out/debootstrap.log"
    cat >"$root/etc/apt/sources.list" <<SOURCES
deb $mirror/debian bookworm main
deb $mirror/debian bookworm-updates main
deb $mirror/debian-security bookworm-security main
SOURCES
    tar -C "$root" -cf "$cache/bookworm.tar.part" .
    mv "$cache/bookworm.tar.part" "$cache/bookworm.tar"
else
    tar -C "$root" -xf "$cache/bookworm.tar"
fi

# This machine's way to the network: names, a proxy if apt has one, certificates that its administrator trusts.
cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
apt-config dump 2>/dev/null | grep -E '^Acquire::(http|https)::Proxy|^Acquire::Check-' >"$root/etc/apt/apt.conf.d/90host" || true
mkdir -p "$root/usr/local/share/ca-certificates"
find /usr/local/share/ca-certificates -name '*.crt' -exec cp {} "$root/usr/local/share/ca-certificates/" \; 2>/dev/null || true

mkdir -p "$root/proc" "$root/sys"
mount -t proc proc "$root/proc" && mounted+=("$root/proc")
bind /dev dev
bind /dev/shm dev/shm
bind "$cache/archives" var/cache/apt/archives
git clone --quiet --no-hardlinks "$repository" "$root/root/lightcook/main"
# Tests that use the shared scenes find them beside the clone, as on a developer's machine.
if [[ -d $repository/../shared ]]; then bind "$repository/../shared" root/lightcook/shared ro; fi

inside() {  # LOG COMMAND...: runs in the clone, in a bare environment, with nobody at the keyboard; prints how long it took
    local log=$out/$1.log start=$SECONDS
    shift
    if ! chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin CI=true LANG=C.UTF-8 \
        NODE_EXTRA_CA_CERTS=/etc/ssl/certs/ca-certificates.crt bash -c 'cd /root/lightcook/main && exec "$@"' - "$@" </dev/null >"$log" 2>&1; then
        tail -n 30 "$log"
        die "'$*' failed after $((SECONDS - start)) s: $log"
    fi
    echo "fresh_machine: '$*' took $((SECONDS - start)) s"
    tail -n 4 "$log" | sed 's/^/    /'
}

# --- the promise ------------------------------------------------------------------------------------------------------------------------

if [[ $only == all || $only == demo ]]; then
    inside demo ./dev demo -o /root/lightcook/demo
    rm -rf "$out/demo"
    cp -r "$root/root/lightcook/demo" "$out/demo"
fi

inside setup ./dev setup
start=${EPOCHREALTIME/./}
inside setup_again ./dev setup
took=$((${EPOCHREALTIME/./} - start))
grep -q 'nothing to install' "$out/setup_again.log" || die "the second ./dev setup installed something: $out/setup_again.log"
((took < 2000000)) || die "the second ./dev setup took $((took / 1000)) ms, expected under 2000"
echo "fresh_machine: the second ./dev setup took $((took / 1000)) ms"

if [[ $only == all || $only == demo ]]; then
    inside screenshot chromium --headless --no-sandbox --disable-gpu --disable-background-networking --disable-component-update --disable-sync \
        --hide-scrollbars --window-size=1280,5000 --screenshot=/root/lightcook/report.png file:///root/lightcook/demo/report.html
    cp "$root/root/lightcook/report.png" "$out/report.png"
    echo "fresh_machine: the report as a picture: $out/report.png"
fi

if [[ $only == all || $only == test ]]; then
    inside test ./dev test
    grep -E 'tests passed|tests failed' "$out/test.log" | tail -n 1
fi
