#!/usr/bin/env bash
# Tests the README's promise on a machine that has nothing: a bare Debian 12 in a folder, a fresh clone in it, and then ./dev demo,
# ./dev setup twice, a picture of the report by headless Chromium, and ./dev test. Needs root, debootstrap, git and a Debian mirror.
#   tests/fresh_machine.sh [--out DIR] [--keep] [--only setup|demo|test]
#     --out DIR   where logs, the demo's output and the picture of its report go (default: build/fresh_machine)
#     --keep      leave the root in place (its mounts are taken down all the same)
#     --only STEP only the setups, only these and the demo with its picture, or only these and the tests
# Environment: see tests/bare_root.sh. The clone holds the last commit, without uncommitted changes.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
name=fresh_machine
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
. "$repository/tests/bare_root.sh"
[[ $only =~ ^(all|setup|demo|test)$ ]] || die "--only takes setup, demo or test, not '$only'"
reason=$(why_no_root)
[[ -z $reason ]] || die "$reason"
mkdir -p "$out"
out=$(cd "$out" && pwd)

make_root
git clone --quiet --no-hardlinks "$repository" "$root/root/lightcook/main"
# Tests that use the shared scenes find them beside the clone, as on a developer's machine.
if [[ -d $repository/../shared ]]; then bind "$repository/../shared" root/lightcook/shared ro; fi
folder=/root/lightcook/main

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
