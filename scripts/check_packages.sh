#!/bin/bash
# What package.sh has made, as strangers get it: check_packages.sh [deb|develop|wheel|tarball|older|image]... (default: all)
#   deb      a minimal Debian 12 root without compiler: install strake, the wing's case to convergence, python3-strake, removal
#            without a trace
#   develop  a root with a compiler: a plug-in and a program with find_package(Strake) by libstrake-dev alone
#   wheel    a virtual environment with numpy alone: pip install, import, the ten minutes of docs/index.md
#   tarball  a root of one static program and no library: moved, called by a link, the wing's case
#   older    the same in Debian 11
#   image    the wing's case as the image's user, who has no rights
# Needs root, chroot, mmdebstrap and a mirror; roots are made once and kept in build/roots. Prints wall seconds and sizes; ends
# with status 1 if anything failed.
set -euo pipefail
cd "$(dirname "$0")/.."
[ "$(id -u)" = 0 ] || { echo "check_packages.sh: needs root, for chroot" >&2; exit 2; }
kinds=${*:-deb develop wheel tarball older image}
version=$(sed -n 's/^project(strake VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
machine=$(dpkg --print-architecture)
dist=$PWD/dist roots=$PWD/build/roots
mkdir -p "$roots"
root=
leave() {
    [ -n "$root" ] || return 0
    ! mountpoint -q "$root/proc" || umount "$root/proc"
    rm -rf "$root"
    root=
}
trap leave EXIT
fail() { echo "check_packages.sh: $*" >&2; exit 1; }
has() { [ -e "$1" ] || fail "there is no $1: ./package.sh makes it"; }

# A fresh copy of a minimal root: enter SUITE PACKAGES...
enter() {
    local suite=$1 name
    local -a include=()
    shift
    name=$(IFS=-; echo "$suite${*:+-$*}")
    [ $# = 0 ] || include=("--include=$(IFS=,; echo "$*")")
    [ -e "$roots/$name.tar" ] || {
        mmdebstrap --quiet --variant=minbase "${include[@]}" "$suite" "$roots/part.tar" "$(packaging/mirror.sh)"
        mv "$roots/part.tar" "$roots/$name.tar"
    }
    root=$(mktemp -d "$roots/in.XXXXXX")
    chmod 755 "$root"
    tar -xf "$roots/$name.tar" -C "$root"
    cp /etc/resolv.conf "$root/etc"
    mount -t proc proc "$root/proc"
    mkdir "$root/parcel"
}
inside() { # USER COMMAND...
    local user=$1
    shift
    # Some processors need OPENBLAS_CORETYPE with Debian's OpenBLAS: it is what this machine has it to be.
    local -a blas=()
    [ -z "${OPENBLAS_CORETYPE-}" ] || blas=("OPENBLAS_CORETYPE=$OPENBLAS_CORETYPE")
    chroot --userspec="$user" "$root" env -i PATH=/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin HOME=/tmp LANG=C.UTF-8 \
        DEBIAN_FRONTEND=noninteractive "${blas[@]}" "$@"
}
install() { inside 0 sh -euc 'apt-get update -qq && apt-get install -y -qq --no-install-recommends "$@" >/tmp/apt.log 2>&1 || { tail /tmp/apt.log; exit 1; }; rm /tmp/apt.log' sh "$@"; }
files() { (cd "$root" && find . -xdev \( -path ./proc -o -path ./parcel -o -path ./tmp -o -path './var/lib/apt' -o -path './var/cache' -o -path './var/log' -o -path './var/lib/dpkg' \) -prune -o -print | sort); }
clock() { date +%s.%N; }
since() { awk -v begin="$1" -v end="$(clock)" '{printf "%.1f s (load %s)", end - begin, $1}' /proc/loadavg; }
tell() { printf '%-10s %s\n' "$1" "$2"; }
# The first steps of docs/install.md, in the folder $1 that has the examples.
wing='set -e; cd "$1"; mkdir -p generated; make_surface wing -o generated/wing.obj; strake run case.yaml --out run --quiet'
converged() { # FOLDER
    local status
    status=$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["status"])' "$root$1/run/run.json")
    [ "$status" = converged ] || fail "the wing's case ended as $status"
    [ -s "$root$1/run/report.html" ] || fail "the run has no report"
}

check_deb() {
    has "$dist/strake_${version}_$machine.deb"
    enter bookworm
    cp "$dist"/*_"${version}_$machine.deb" "$root/parcel"
    files >"$roots/before"
    local packages size begin
    packages=$(inside 0 dpkg-query -W | wc -l)
    size=$(du -smx "$root" | cut -f1)
    begin=$(clock)
    install "/parcel/strake_${version}_$machine.deb"
    tell deb "installed with downloads in $(since "$begin")"
    local run
    run=$(clock)
    cp -r "$root/usr/share/doc/strake/examples/wing" "$root/tmp/wing"
    inside 0 sh -c "$wing" sh /tmp/wing
    converged /tmp/wing
    tell deb "the wing's case converged in $(since "$run")"
    tell deb "both in $(since "$begin")"
    tell deb "$(inside 0 dpkg-query -W | wc -l) packages for $packages, $(du -smx --exclude=parcel --exclude=wing --exclude=var/lib/apt --exclude=var/cache "$root" | cut -f1) MB for $size"
    tell deb "strake itself: $(inside 0 dpkg-query -W -f '${Installed-Size}' strake) kB"
    inside 0 sh -c 'strake --version && strake run --help >/dev/null && [ ! -e /usr/bin/cc ]' >/dev/null
    install "/parcel/python3-strake_${version}_$machine.deb"
    tell deb "python3: $(inside 0 sh -c 'cd /tmp/wing && python3 -c "import strake; print(strake.__version__, strake.read_surface(\"run/best.obj\"))"')"
    inside 0 sh -c 'apt-get purge -y -qq --auto-remove strake python3-strake >/dev/null 2>&1'
    [ "$(inside 0 dpkg-query -W | wc -l)" = "$packages" ] || fail "packages are left: $(inside 0 dpkg-query -W | tail -n 5)"
    local left
    left=$(files | comm -13 "$roots/before" -)
    [ -z "$left" ] || fail "left behind: $left"
    tell deb "purged without a trace"
    leave
}

check_develop() {
    has "$dist/libstrake-dev_${version}_$machine.deb"
    enter bookworm g++ cmake make
    cp "$dist"/*_"${version}_$machine.deb" "$root/parcel"
    local begin
    begin=$(clock)
    install "/parcel/libstrake-dev_${version}_$machine.deb" "/parcel/strake_${version}_$machine.deb"
    tell develop "installed with downloads in $(since "$begin")"
    # The program of docs/library.md, by a name with a capital letter.
    mkdir -p "$root/tmp/program"
    python3 - "$root/tmp/program" <<'PYTHON'
import pathlib, re, sys
page = pathlib.Path("docs/library.md").read_text(encoding="utf-8")
cmake, bend = [code for _, code in re.findall(r"^```(cmake|cpp)\n(.*?)^```", page, re.M | re.S)]
out = pathlib.Path(sys.argv[1])
(out / "CMakeLists.txt").write_text(cmake.replace("find_package(strake", "find_package(Strake"))
(out / "bend.cpp").write_text(bend)
PYTHON
    begin=$(clock)
    inside 0 sh -euc 'cd /tmp/program; { cmake -B build && cmake --build build; } >log 2>&1 || { tail -n 30 log; exit 1; }; build/bend' >"$root/tmp/said"
    grep -q 'lifted by' "$root/tmp/said" || fail "the program said: $(cat "$root/tmp/said")"
    tell develop "$(cat "$root/tmp/said")"
    inside 0 sh -euc 'cd /tmp; cc -O2 -shared -fPIC -o area.so /usr/share/doc/strake/examples/external/area.c -lm
        make_surface lifting_body --triangles 2000 -o body.obj
        printf "%s\n" "case: plugin" "surface: {file: body.obj}" "regions: {nose: {box: [[-1, -9, -9], [0.8, 9, 9]]}}" "fixed: [nose]" \
            "quantities: {wetted: {plugin: {library: area.so}}}" "parameters: {levels: auto, patches_per_level: [2], variables: [normal]}" \
            "objective: {minimize: wetted}" "constraints: {volume: {min: 1, relative: true}}" >plugin.yaml
        strake check plugin.yaml --evaluate' >"$root/tmp/said"
    tell develop "plug-in: $(grep wetted "$root/tmp/said" | head -n 1)"
    tell develop "program and plug-in in $(since "$begin")"
    inside 0 sh -c 'apt-get purge -y -qq libstrake-dev strake >/dev/null 2>&1'
    local left
    left=$(files | grep -i strake || true)
    [ -z "$left" ] || fail "left behind: $left"
    leave
}

# The blocks of docs/index.md after the first, which is about a checkout.
ten_minutes() {
    python3 - <<'PYTHON'
import pathlib, re
blocks = re.findall(r"^```sh\n(.*?)^```", pathlib.Path("docs/index.md").read_text(encoding="utf-8"), re.M | re.S)
print("set -e\n" + "\n".join(blocks[1:]))
PYTHON
}
check_wheel() {
    local wheel begin
    wheel=$(echo "$dist"/strake-"$version"-*.whl)
    has "$wheel"
    enter bookworm python3-venv python3-numpy
    cp "$wheel" "$root/parcel"
    ten_minutes >"$root/tmp/page.sh"
    inside 0 sh -c 'cd /tmp && python3 -m venv --system-site-packages env'
    begin=$(clock)
    inside 0 sh -c 'cd /tmp && env/bin/pip install --quiet --no-index --disable-pip-version-check --root-user-action=ignore /parcel/*.whl'
    tell wheel "pip install in $(since "$begin")"
    tell wheel "$(inside 0 sh -c 'cd /tmp && env/bin/python -c "import strake; print(strake.__version__)" && env/bin/python -m strake --version')"
    local run
    run=$(clock)
    inside 0 sh -c 'mkdir /tmp/page && cd /tmp/page && PATH=/tmp/env/bin:$PATH sh /tmp/page.sh' >"$root/tmp/said" 2>&1 || { tail -n 30 "$root/tmp/said"; fail "the ten minutes' page failed"; }
    tell wheel "the ten minutes in $(since "$run"); with pip install $(since "$begin")"
    inside 0 sh -c 'cd /tmp/page && /tmp/env/bin/python -c "
import strake
case = strake.load_case(\"more.yaml\")
case.options(max_evaluations=4)
print(strake.run(case).status)"' >/dev/null
    tell wheel "$(du -smx "$root/tmp/env/lib/python3.11/site-packages/strake" "$root/tmp/env/lib/python3.11/site-packages/strake.libs" | awk '{s += $1} END {print s}') MB unpacked"
    leave
}

# Unpacked, moved, and called by a link.
moved_folder() {
    local folder=strake-$version-$(uname -m)
    has "$dist/$folder.tar.xz"
    mkdir -p "$root/opt/other place" "$root/usr/local/bin" "$root/tmp"
    tar -xf "$dist/$folder.tar.xz" -C "$root/opt/other place"
    ln -s "/opt/other place/$folder/bin/strake" "/opt/other place/$folder/bin/make_surface" "$root/usr/local/bin"
    cp -r "$root/opt/other place/$folder/share/cases/wing" "$root/tmp/wing"
}
run_folder() { # NAME
    local begin
    begin=$(clock)
    chown -R 1000:1000 "$root/tmp/wing"
    inside 1000:1000 sh -c "$wing" sh /tmp/wing
    converged /tmp/wing
    tell "$1" "$(inside 1000:1000 strake --version) converged in $(since "$begin"); $(du -smx "$root/opt" | cut -f1) MB"
    leave
}
check_tarball() {
    root=$(mktemp -d "$roots/in.XXXXXX")
    chmod 755 "$root"
    mkdir -p "$root"/{bin,proc,dev,usr/bin}
    [ -e "$roots/busybox" ] || (cd "$roots" && apt-get download -qq busybox-static >/dev/null && dpkg-deb -x busybox-static_*.deb busybox-root && cp busybox-root/bin/busybox . && rm -r busybox-root busybox-static_*.deb)
    cp "$roots/busybox" "$root/bin"
    local name
    for name in sh env mkdir readlink dirname; do ln -s busybox "$root/bin/$name"; done
    mount -t proc proc "$root/proc"
    mknod -m 666 "$root/dev/null" c 1 3
    moved_folder
    run_folder tarball
}
check_older() {
    enter bullseye
    moved_folder
    run_folder older
}

check_image() {
    local image=$dist/strake-$version.oci.tar begin
    has "$image"
    root=$(mktemp -d "$roots/in.XXXXXX")
    chmod 755 "$root"
    if tar -tf "$image" | grep -qx oci-layout; then
        tell image "an OCI archive of $(du -B MB "$image" | cut -f1)"
        local layer
        mkdir "$root.oci"
        tar -xf "$image" -C "$root.oci"
        layer=$(python3 - "$root.oci" <<'PYTHON'
import json, pathlib, sys
blobs = pathlib.Path(sys.argv[1]) / "blobs"
def blob(digest):
    return blobs / digest.replace(":", "/")
index = json.loads((blobs.parent / "index.json").read_text())
manifest = json.loads(blob(index["manifests"][0]["digest"]).read_text())
config = json.loads(blob(manifest["config"]["digest"]).read_text())["config"]
assert config["User"] == "strake" and config["Entrypoint"] == ["/usr/bin/strake"] and config["WorkingDir"] == "/work", config
for layer in manifest["layers"]:
    print(blob(layer["digest"]))
PYTHON
        )
        local one
        for one in $layer; do tar -xf "$one" -C "$root"; done
        rm -r "$root.oci"
    else
        tell image "no OCI archive but the root itself (this machine makes no images), of $(du -B MB "$image" | cut -f1)"
        tar -xf "$image" -C "$root"
    fi
    local size
    size=$(du -B 1000000 -sx "$root" | cut -f1)
    [ "$size" -lt 200 ] || fail "the image's root has $size MB, 200 are allowed"
    mount -t proc proc "$root/proc"
    local mounted=/work  # the folder that users mount
    cp -r "$root/usr/share/doc/strake/examples/wing" "$root$mounted/wing"
    chown -R 1000:1000 "$root$mounted"
    begin=$(clock)
    inside strake sh -c "$wing" sh "$mounted/wing"
    converged "$mounted/wing"
    tell image "$(inside strake sh -c 'id -un') converged in $(since "$begin"); $size MB unpacked"
    leave
}

for kind in $kinds; do
    case $kind in
    deb | develop | wheel | tarball | older | image) "check_$kind" ;;
    *) sed -n 2p "$0" >&2; exit 2 ;;
    esac
done
