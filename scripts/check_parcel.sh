#!/bin/bash
# What the project shows and hands out, by the usual tools: check_parcel.sh [--quick]
# Licence tags (reuse), spelling (codespell), types of the Python module (mypy --strict), the API's reference without a
# warning (Doxygen), the links of the documentation; then, unless --quick, the Debian packages of the last commit
# (package.sh) by lintian, and, as root, all that package.sh makes in minimal roots (check_packages.sh).
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
packages() { ./package.sh && lintian --fail-on error,warning dist/*.deb; }
strangers() {
    [ "$(id -u)" = 0 ] || { echo "not checked in minimal roots: that needs root" >&2; return 0; }
    scripts/check_packages.sh
}
check reuse reuse lint --quiet
check codespell codespell
check mypy env -C python mypy --strict --cache-dir=/dev/null strake/__init__.pyi
check Doxygen reference
check links python3 tests/docs/links_test.py
[ "${1-}" = --quick ] || { check packages packages; check "minimal roots" strangers; }
[ ${#failed[@]} = 0 ] || { printf 'failed: %s\n' "${failed[*]}" >&2; exit 1; }
