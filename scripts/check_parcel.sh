#!/bin/bash
# What the project shows and hands out, by the usual tools: check_parcel.sh [--quick]
# Licence tags (reuse), spelling (codespell), types of the Python module (mypy --strict), the API's reference without a
# warning (Doxygen); then, unless --quick, the Debian packages of the last commit (package.sh) by lintian.
# Needs scripts/setup.sh run package. Ends with status 1 at the end if any had something to say.
set -uo pipefail
cd "$(dirname "$0")/.."
failed=()
check() {  # NAME COMMAND...
    printf '== %s\n' "$1"
    "${@:2}" || failed+=("$1")
}
reference() {
    local out=build/reference
    mkdir -p $out
    (cat scripts/Doxyfile; echo "OUTPUT_DIRECTORY = $out") | doxygen -
}
packages() { ./package.sh source deb && lintian --fail-on warning dist/*.deb; }
check reuse reuse lint --quiet
check codespell codespell
check mypy env -C python mypy --strict --cache-dir=/dev/null strake/__init__.pyi
check Doxygen reference
[ "${1-}" = --quick ] || check packages packages
[ ${#failed[@]} = 0 ] || { printf 'failed: %s\n' "${failed[*]}" >&2; exit 1; }
