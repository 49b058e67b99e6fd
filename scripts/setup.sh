#!/bin/bash
# Installs the packages of scripts/packages.txt that are missing: setup.sh [run|test|pictures|slurm|openfoam|package]...
# Asks the package database only, so that it costs nothing when there is nothing to do.
set -euo pipefail
cd "$(dirname "$0")/.."
kinds=${*:-run}

wanted=$(awk -v kinds=" $kinds " '!/^#/ && NF >= 2 && index(kinds, " " $2 " ") {print $1, $3}' scripts/packages.txt |
    while read -r package command; do
        [ -n "$command" ] && command -v "$command" >/dev/null || echo "$package"
    done)
[ -n "$wanted" ] || { echo "setup.sh: no packages for '$kinds'; kinds: run, test, pictures, slurm, openfoam, package" >&2; exit 2; }
if ! command -v dpkg-query >/dev/null; then
    echo "setup.sh: this is no Debian; continuing with what is installed (needed: $(echo $wanted))" >&2
    exit 0
fi
# shellcheck disable=SC2086
installed=$(dpkg-query -W -f='${Package} ${db:Status-Status}\n' $wanted 2>/dev/null | awk '$2 == "installed" {print $1}') || true
missing=$(comm -23 <(sort -u <<<"$wanted") <(sort -u <<<"$installed"))
[ -n "$missing" ] || exit 0

as_root=()
if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null || {
        echo "setup.sh: neither root nor sudo; install these packages: $(echo $missing)" >&2
        exit 1
    }
    as_root=(sudo)
fi
# shellcheck source=scripts/progress.sh
. scripts/progress.sh
apt_get() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get "$@"; }
# shellcheck disable=SC2086
install() { apt_get install -y -q --no-install-recommends $missing; }
# An image may come without package lists, or with lists that have grown old: then, and only then, fetch them.
fetch_and_install() { install || { apt_get update -q && install; }; }
echo "installing $(echo "$missing" | wc -l) packages: $(echo $missing)" >&2
if ! progress "Installing packages" 120 fetch_and_install; then
    echo "setup.sh: the packages could not be installed (see above)" >&2
    exit 1
fi
