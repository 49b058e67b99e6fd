#!/bin/bash
# ./run.sh            sets everything up, then runs the wing's two cases: a fit and an optimization
# ./run.sh CASE.yaml  the same set-up, then that case (a fit if it has the key `fit`, else an optimization)
# Results go to a new folder each time: runs/<folder>-<file>-001, -002, ...
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
cases=("$@")
for file in "${cases[@]}"; do
    [ -f "$file" ] || { echo "run.sh: $file: no such file" >&2; exit 2; }
done
[ ${#cases[@]} -gt 0 ] || cases=("$here/cases/wing/fit.yaml" "$here/cases/wing/case.yaml")

"$here/scripts/setup.sh" run
[ -e "$here/build/run/build.ninja" ] || (cd "$here" && cmake --preset run >/dev/null)
(cd "$here" && ninja -C build/run --quiet strake make_surface)
bin=$here/build/run/bin
"$here/scripts/examples.sh" "$here/cases" "$bin"

# Prints runs/NAME-001 with the first number that is free.
new_folder() {
    local number=1
    while [ -e "$(printf 'runs/%s-%03d' "$1" $number)" ]; do number=$((number + 1)); done
    printf 'runs/%s-%03d' "$1" $number
}
status=0
for file in "${cases[@]}"; do
    full=$(realpath "$file")
    command=run
    ! grep -q '^fit *:' "$full" || command=fit
    out=$(new_folder "$(basename "$(dirname "$full")")-$(basename "${full%.*}")")
    echo "strake $command $file --out $out" >&2
    "$bin/strake" "$command" "$file" --out "$out" || { status=$?; echo "run.sh: $file ended with status $status" >&2; }
done
exit $status
