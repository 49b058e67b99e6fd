#!/bin/bash
# ./run.sh            sets everything up, then runs the wing's two cases: a fit and an optimization
# ./run.sh CASE.yaml  the same set-up, then that case (a fit if it has the key `fit`, else an optimization)
# Results go to a new folder each time: runs/<folder>-<file>-001, -002, ...
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
# shellcheck source=scripts/progress.sh
. "$here/scripts/progress.sh"
cases=("$@")
for file in "${cases[@]}"; do
    [ -f "$file" ] || { echo "run.sh: $file: no such file" >&2; exit 2; }
done
[ ${#cases[@]} -gt 0 ] || cases=("$here/cases/wing/fit.yaml" "$here/cases/wing/case.yaml")

"$here/scripts/setup.sh" run
if [ ! -e "$here/build/run/build.ninja" ]; then
    (cd "$here" && progress "1/3 Configuring" 15 cmake --preset run)
fi
# Nothing to do: no word of it. A whole build takes six minutes of one core.
cores=$(nproc)
if [ "$(cd "$here" && ninja -C build/run -n strake make_surface | tail -n 1)" != "ninja: no work to do." ]; then
    (cd "$here" && progress "2/3 Building on $cores cores" $((360 / cores)) ninja -C build/run strake make_surface)
fi
bin=$here/build/run/bin
progress "3/3 Example surfaces" 10 "$here/scripts/examples.sh" "$here/cases" "$bin"

# Prints runs/NAME-001 with the first number that is free.
new_folder() {
    local number=1
    while [ -e "$(printf 'runs/%s-%03d' "$1" $number)" ]; do number=$((number + 1)); done
    printf 'runs/%s-%03d' "$1" $number
}
opener=xdg-open
command -v xdg-open >/dev/null || opener="your browser"
[ "$(uname)" != Darwin ] || opener=open
status=0
reports=()
for file in "${cases[@]}"; do
    full=$(realpath "$file")
    command=run
    ! grep -q '^fit *:' "$full" || command=fit
    out=$(new_folder "$(basename "$(dirname "$full")")-$(basename "${full%.*}")")
    echo "strake $command $file --out $out" >&2
    "$bin/strake" "$command" "$file" --out "$out" || { status=$?; echo "run.sh: $file ended with status $status" >&2; }
    [ ! -e "$out/report.html" ] || reports+=("$out/report.html")
done
for report in "${reports[@]}"; do
    echo "Report: $report (open it with: $opener $report)" >&2
done
exit $status
