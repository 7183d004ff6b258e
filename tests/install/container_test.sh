#!/usr/bin/env bash
# Builds the image of Dockerfile with podman, docker or buildah, whichever works here, and cooks in it: the program runs as a user without
# rights and as one that has no name, writes into a mounted folder, and the image holds no compiler. The base is a bare Debian 12 made
# here, so that nothing is pulled. Needs root, debootstrap, a Debian mirror and a registry of npm; otherwise exits with 77, which ctest
# reports as skipped.
#   container_test.sh BUILD_DIR
set -euo pipefail
build=$1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
repository=$(cd "$here/../.." && pwd)
name=container_test
out=$build/container_test
. "$here/../bare_root.sh"

skip() { echo "skipped: the container image was not built: $*"; exit 77; }
reason=$(why_no_root)
[[ -z $reason ]] || skip "$reason"
rm -rf "$out"
mkdir -p "$out"
out=$(cd "$out" && pwd)
[[ -f $cache/bookworm.tar ]] || debootstrap --print-debs bookworm "$out/probe" "$mirror/debian" >"$out/mirror.log" 2>&1 ||
    skip "debootstrap reaches no mirror at $mirror ($out/mirror.log)"

# The base image: the bare root with this machine's way to the network.
make_root
mkdir "$out/base"
tar -C "$root" --exclude='./proc/*' --exclude='./sys/*' --exclude='./dev/*' --exclude='./var/cache/apt/archives/*' -cf "$out/base/root.tar" .
cat >"$out/base/Dockerfile" <<BASE
FROM scratch
ADD root.tar /
ENV NODE_EXTRA_CA_CERTS=/etc/ssl/certs/ca-certificates.crt
BASE

base=localhost/lightcook-test-base image=localhost/lightcook-test
storage=(--root "$out/storage" --runroot "$out/run")
# build_image TAG CONTEXT [OPTION]...
build_image() {
    local tag=$1 context=$2
    shift 2
    case $tool in
        podman) podman "${storage[@]}" build --network host "$@" -t "$tag" "$context" ;;
        docker) docker build --network host "$@" -t "$tag" "$context" ;;
        buildah) buildah "${storage[@]}" bud --isolation "$isolation" "$@" -t "$tag" "$context" ;;
    esac
}
# run_image IMAGE USER COMMAND...: with $out/work as /work; the command takes the place of the entry point. USER "" is that of the image.
run_image() {
    local from=$1 user=$2 container status=0
    shift 2
    local options=(-v "$out/work:/work" ${user:+--user "$user"})
    case $tool in
        podman) podman "${storage[@]}" run --rm --network none "${options[@]}" --entrypoint '[]' "$from" "$@" ;;
        docker) docker run --rm --network none "${options[@]}" --entrypoint "$1" "$from" "${@:2}" ;;
        buildah)
            container=$(buildah "${storage[@]}" from "$from")
            buildah "${storage[@]}" run --isolation "$isolation" "${options[@]}" "$container" -- "$@" || status=$?
            buildah "${storage[@]}" rm "$container" >/dev/null
            return $status
            ;;
    esac
}
forget_images() {
    case ${tool:-} in
        podman) podman "${storage[@]}" rmi --all --force ;;
        buildah) buildah "${storage[@]}" rmi --all --force ;;
        docker) docker rmi --force "$image" "$base" ;;
    esac >/dev/null 2>&1 || true
    # What a builder that failed left mounted.
    awk -v folder="$out/" 'index($2, folder) == 1 { print $2 }' /proc/mounts | sort -r | xargs -r -n 1 umount --lazy || true
    rm -rf --one-file-system "$out/storage" "$out/run" "$out/base"
    leave_root
}
trap forget_images EXIT

mkdir -m 1777 "$out/work"
for choice in podman: docker: buildah:oci buildah:chroot none:; do
    tool=${choice%:*} isolation=${choice#*:}
    [[ $tool != none ]] || skip "none of podman, docker and buildah makes and runs an image here: see $out/probe-*.log"
    command -v "$tool" >/dev/null || continue
    if (build_image "$base" "$out/base" && run_image "$base" "" true) >"$out/probe-$tool$isolation.log" 2>&1; then break; fi
done
echo "container_test: $tool $isolation"

start=$SECONDS
build_image "$image" "$repository" --build-arg "BASE=$base" >"$out/build.log" 2>&1 || { tail -n 30 "$out/build.log"; die "no image: $out/build.log"; }
echo "container_test: the image took $((SECONDS - start)) s"

# in_image LOG USER COMMAND...
in_image() {
    local log=$out/$1.log
    shift
    run_image "$image" "$@" >"$log" 2>&1 || { tail -n 20 "$log"; die "'${*:2}' failed in the image: $log"; }
}
in_image user "" id -u
[[ $(cat "$out/user.log") == 10001 ]] || die "found user $(cat "$out/user.log"), expected 10001"
in_image compiler "" bash -c '! command -v g++ && ! command -v cmake && ! command -v node'
in_image demo "" lightcook demo -o /work/demo
[[ -s $out/work/demo/report.html ]] || die "the demo left no report in the mounted folder"
[[ $(stat -c %u "$out/work/demo/report.html") == 10001 ]] || die "the report belongs to user $(stat -c %u "$out/work/demo/report.html"), expected 10001"
in_image verify 4321:4321 lightcook verify /work/demo
mkdir "$out/work/own"
chown 4321:4321 "$out/work/own"
in_image init 4321:4321 bash -c 'cp /usr/share/lightcook/examples/cornell/cornell.glb /usr/share/lightcook/examples/cornell/cornell_lightmap.exr own/ && lightcook init own'
in_image cook 4321:4321 lightcook cook own/scene.toml -o own/cooked
in_image view 4321:4321 lightcook view own/cooked --export own/page
[[ $(stat -c %u "$out/work/own/page/index.html") == 4321 ]] || die "the exported page does not belong to the user that -u names"
echo "container_test: the image runs as user 10001 and as user 4321"
