#!/bin/bash
# Makes what others install, into dist/, and says what it made: package.sh [source|deb|wheel|tarball|image]... (default: all)
#   source   strake-VERSION.tar.xz: the committed sources with the finished pages of report and studio, so that they build without a network
#   deb      strake, libstrake-dev and python3-strake for this Debian, by dpkg-buildpackage from that tarball
#   wheel    the Python package with the program inside and its libraries beside it, for this Python and glibc
#   tarball  strake-VERSION-MACHINE.tar.xz: program, loader and libraries in one folder, for machines without root or with older systems
#   image    strake-VERSION.oci.tar: a container image (needs buildah and user namespaces)
# Needs what scripts/setup.sh run package installs. DEB_BUILD_OPTIONS goes to dpkg-buildpackage. Where there is ccache it is
# used: the same sources once more take two minutes. STRAKE_GPL=OFF in the environment makes them without parts under the GPL.
set -euo pipefail
cd "$(dirname "$0")"
root=$PWD
kinds=${*:-source deb wheel tarball image}
version=$(sed -n 's/^project(strake VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
[ "$(dpkg-parsechangelog -S Version)" = "$version" ] || { echo "package.sh: debian/changelog is not of version $version" >&2; exit 1; }
dist=$root/dist
mkdir -p "$dist"
# Always the same folder, so that a compiler cache knows the sources again.
work=$root/build/package
rm -rf "$work"
mkdir -p "$work"
trap 'rm -rf "$work"' EXIT
# What is made is this commit, also where others follow meanwhile.
commit=$(git rev-parse HEAD)
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct "$commit")
export SOURCE_DATE_EPOCH
tarball=$dist/strake-$version.tar.xz
made=()

has() { [[ " $kinds " == *" $1 "* ]]; }
for kind in $kinds; do
    case $kind in
    source | deb | wheel | tarball | image) ;;
    *) sed -n 2p "$0" >&2; exit 2 ;;
    esac
done

# The committed sources, and what npm makes of the pages of report and studio.
make_source() {
    mkdir -p "$work/strake-$version/viewer/page/bundle"
    git archive "$commit" | tar -x -C "$work/strake-$version"
    echo "$commit" >"$work/strake-$version/.commit"
    cmake -S "$work/strake-$version" -B "$work/page" -G Ninja -DSTRAKE_TESTS=OFF -DSTRAKE_REPORT_PAGE=ON >"$work/page.log" 2>&1 &&
        ninja -C "$work/page" strake_pages >>"$work/page.log" 2>&1 || { tail "$work/page.log" >&2; return 1; }
    cp "$work/page/viewer/page/"{report,studio}.{js,css} "$work/strake-$version/viewer/page/bundle"
    tar --sort=name --owner=0 --group=0 --numeric-owner --mtime="@$SOURCE_DATE_EPOCH" -C "$work" -cJf "$tarball" "strake-$version"
    rm -rf "$work/page" "$work/strake-$version"
    made+=("$tarball")
}
unpacked() { # FOLDER
    mkdir -p "$1"
    tar -xJf "$tarball" -C "$1" --strip-components=1
}

# What the packages in dist/ were made from.
built_from() { echo "$commit ${STRAKE_GPL:-ON}"; }
deb_of() { echo "$dist/${1}_${version}_$(dpkg --print-architecture).deb"; } # PACKAGE
make_deb() {
    local sources=$work/deb/strake-$version
    unpacked "$sources"
    # debhelper has a HOME of its own, where the compiler's cache would be lost. Symbols for a debugger would double the
    # compiler's time, and nobody gets them.
    ! command -v ccache >/dev/null || export CCACHE_DIR="${CCACHE_DIR:-$(ccache --get-config cache_dir)}"
    (cd "$sources" && PATH=/usr/lib/ccache:$PATH CCACHE_BASEDIR=$sources CCACHE_NOHASHDIR=true DEB_CFLAGS_STRIP=-g DEB_CXXFLAGS_STRIP=-g \
        DEB_BUILD_OPTIONS="noautodbgsym ${DEB_BUILD_OPTIONS-}" dpkg-buildpackage -b -us -uc) >"$dist/deb.log" 2>&1 || { tail -n 40 "$dist/deb.log" >&2; return 1; }
    rm "$dist/deb.log"
    for file in "$work"/deb/*.deb; do
        [[ $file != *-dbgsym* ]] || continue
        cp "$file" "$dist"
        made+=("$dist/${file##*/}")
    done
    built_from >"$dist/.built_from"
}

# What the Debian packages install: one build serves every kind.
build_once() {
    [ -e "$work/installed/usr/bin/strake" ] && return
    local name
    for name in strake python3-strake; do
        [ -e "$(deb_of $name)" ] && [ "$(cat "$dist/.built_from" 2>/dev/null)" = "$(built_from)" ] || make_deb
        dpkg-deb -x "$(deb_of $name)" "$work/installed"
    done
}
make_wheel() {
    build_once
    packaging/make_wheel.py "$version" "$work/installed/usr" "$work/wheel" "$dist" || return 1
    made+=("$dist"/strake-"$version"-*.whl)
}
make_tarball() {
    build_once
    packaging/make_tarball.sh "$version" "$work/installed/usr" "$root/docs" "$root/cases" "$work/folder" "$dist" || return 1
    made+=("$dist"/strake-"$version"-"$(uname -m)".tar.xz)
}
make_image() {
    build_once
    packaging/make_image.sh "$(deb_of strake)" "$dist/strake-$version.oci.tar" || return 1
    made+=("$dist/strake-$version.oci.tar")
}

if has source || [ ! -e "$tarball" ] || [ "$(tar -xJOf "$tarball" "strake-$version/.commit" 2>/dev/null)" != "$commit" ]; then
    make_source
fi
for kind in deb wheel tarball image; do
    has $kind || continue
    "make_$kind"
done
for file in "${made[@]}"; do
    printf '%8s  %s\n' "$(du -h "$file" | cut -f1)" "${file#"$root"/}"
done
