# A bare Debian 12, or another release, in a folder. Sourced by tests that need a machine on which nothing is installed; those set
#   name    prefix of messages
#   out     an existing folder for logs
#   suite   release of Debian (default: bookworm)
#   keep    true: leave the root in place (its mounts are taken down all the same)
# Environment: LIGHTCOOK_FRESH_CACHE keeps the bare root and the .deb files between runs (default: /tmp/lightcook-fresh-cache);
# DEBIAN_MIRROR names another mirror than http://deb.debian.org.
cache=${LIGHTCOOK_FRESH_CACHE:-/tmp/lightcook-fresh-cache}
suite=${suite:-bookworm}
mirror=${DEBIAN_MIRROR:-http://deb.debian.org}
die() { echo "$name: $*" >&2; exit 1; }

# Prints why a root cannot be made here; prints nothing where it can.
why_no_root() {
    [[ $EUID == 0 ]] || { echo "must run as root (chroot, mount)"; return; }
    command -v debootstrap >/dev/null || { echo "debootstrap is missing: apt-get install debootstrap"; return; }
}

mounted=()
leave_root() {
    local index
    for ((index = ${#mounted[@]} - 1; index >= 0; --index)); do
        umount "${mounted[index]}" || umount --lazy "${mounted[index]}"
    done
    if ${keep:-false}; then
        echo "$name: the root stays in $root"
    else
        rm -rf --one-file-system "$root"
    fi
}

bind() {  # SOURCE PLACE-IN-ROOT [OPTIONS]
    mkdir -p "$root/$2"
    mount --bind "$1" "$root/$2"
    mounted+=("$root/$2")
    if [[ -n ${3:-} ]]; then mount -o "remount,bind,$3" "$root/$2"; fi
}

# Sets `root`, and removes it when the script ends.
make_root() {
    mkdir -p "$cache/archives/partial"
    root=$(mktemp -d /tmp/lightcook-fresh-root.XXXXXX)
    trap leave_root EXIT
    if [[ ! -f $cache/$suite.tar ]]; then
        debootstrap --variant=minbase "$suite" "$root" "$mirror/debian" >"$out/debootstrap.log" 2>&1 ||
            die "debootstrap failed: $out/debootstrap.log"
        cat >"$root/etc/apt/sources.list" <<SOURCES
deb $mirror/debian $suite main
deb $mirror/debian $suite-updates main
deb $mirror/debian-security $suite-security main
SOURCES
        tar -C "$root" -cf "$cache/$suite.tar.part" .
        mv "$cache/$suite.tar.part" "$cache/$suite.tar"
    else
        tar -C "$root" -xf "$cache/$suite.tar"
    fi

    chmod 755 "$root"  # mktemp closes it to everybody but root, also to users inside

    # This machine's network access: names, apt's proxy if it has one, certificates that its administrator trusts.
    cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
    apt-config dump 2>/dev/null | grep -E '^Acquire::(http|https)::Proxy|^Acquire::Check-' >"$root/etc/apt/apt.conf.d/90host" || true
    mkdir -p "$root/usr/local/share/ca-certificates"
    find /usr/local/share/ca-certificates -name '*.crt' -exec cp {} "$root/usr/local/share/ca-certificates/" \; 2>/dev/null || true

    mkdir -p "$root/proc" "$root/sys"
    mount -t proc proc "$root/proc" && mounted+=("$root/proc")
    bind /dev dev
    bind /dev/shm dev/shm
    bind "$cache/archives" var/cache/apt/archives
}

folder=/root  # where inside() runs commands
inside() {  # LOG COMMAND...: runs in the root, with a bare environment and no terminal; prints how long it took
    local log=$out/$1.log start=$SECONDS
    shift
    if ! chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin CI=true LANG=C.UTF-8 \
        DEBIAN_FRONTEND=noninteractive NODE_EXTRA_CA_CERTS=/etc/ssl/certs/ca-certificates.crt \
        bash -c 'cd "$1" && shift && exec "$@"' - "$folder" "$@" </dev/null >"$log" 2>&1; then
        tail -n 30 "$log"
        die "'$*' failed after $((SECONDS - start)) s: $log"
    fi
    echo "$name: '$*' took $((SECONDS - start)) s"
    tail -n 4 "$log" | sed 's/^/    /'
}
