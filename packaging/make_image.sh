#!/bin/bash
# An image for containers: make_image.sh DEB OUT. A minimal Debian 12 root with the package, a user without rights, and
# `strake` as what it runs. By buildah where this machine allows it; else OUT is the same root as a tar file, for
# `podman import`, `apptainer build` and chroot, and this script says so.
set -euo pipefail
deb=$(realpath "$1") out=$2
command -v mmdebstrap >/dev/null || { echo "make_image.sh: needs mmdebstrap" >&2; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
chmod 755 "$work"
cp "$deb" "$work"
(cd "$work" && dpkg-scanpackages . >Packages 2>/dev/null)
# Pages, translations and other character sets than UTF-8 stay outside; so does Perl, which only the package that merges /usr of an older system needs.
mmdebstrap --variant=minbase --include=usr-is-merged,strake --hook-dir=/usr/share/mmdebstrap/hooks/merged-usr --skip=cleanup/apt/lists \
    --aptopt='APT::Install-Recommends "false"' \
    --dpkgopt='path-exclude=/usr/share/man/*' --dpkgopt='path-exclude=/usr/share/locale/*' --dpkgopt='path-exclude=/usr/share/info/*' \
    --dpkgopt='path-exclude=/usr/lib/*/perl/*' --dpkgopt='path-exclude=/usr/share/doc/*' --dpkgopt='path-include=/usr/share/doc/*/copyright' --dpkgopt='path-include=/usr/share/doc/strake/examples/*' \
    --customize-hook='chroot "$1" useradd --create-home --uid 1000 strake' \
    --customize-hook='sed -i "/copy:/d" "$1"/etc/apt/sources.list' \
    --customize-hook='rm -rf "$1/var/lib/apt/lists"/* "$1/var/cache/apt"/*.bin "$1/usr/share/perl" "$1"/usr/lib/*/gconv "$1/usr/share/zoneinfo/right" "$1"/var/cache/debconf/*-old' \
    --customize-hook='mkdir "$1/work" && chown 1000:1000 "$1/work"' \
    bookworm "$work/root.tar" "deb $("$(dirname "$0")/mirror.sh") bookworm main" \
    "deb [trusted=yes] copy:$work ./"
license=GPL-3.0-or-later
[ "${STRAKE_GPL:-ON}" = ON ] || license=Apache-2.0
if command -v buildah >/dev/null && container=$(buildah from scratch 2>/dev/null); then
    buildah add "$container" "$work/root.tar" / >/dev/null
    buildah config --user strake --workingdir /work --entrypoint '["/usr/bin/strake"]' --cmd --help \
        --label org.opencontainers.image.title=strake --label org.opencontainers.image.licenses="$license" "$container"
    buildah commit --disable-compression=false --timestamp "${SOURCE_DATE_EPOCH:-0}" --rm "$container" "oci-archive:$out" >/dev/null
else
    echo "make_image.sh: this machine makes no container images (buildah is missing, or user namespaces): $out is the root itself" >&2
    mv "$work/root.tar" "$out"
fi
