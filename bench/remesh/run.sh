#!/bin/bash
# bench/remesh/run.sh [OUT] [SURFACE…]: strake remesh beside CGAL's isotropic remeshing (Debian's libcgal-dev), same
# surface, same edge length (the mean of the input; of LENGTH in the environment), ten iterations, one run each, as a
# Markdown table. CPU: user and system seconds of the whole program. Without surfaces: bodies of this project.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
out=$(realpath -m "${1:-runs/remesh}")
[ $# -eq 0 ] || shift
angle=${ANGLE:-40}
launcher=()
! command -v ccache >/dev/null || launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
(cd "$root" && cmake --preset bench "${launcher[@]}" >/dev/null && ninja -C build/bench --quiet strake make_surface remesh_figures cgal_remesh)
bin=$root/build/bench
mkdir -p "$out"
surfaces=("$@")
if [ ${#surfaces[@]} -eq 0 ]; then
    for body in lifting_body:131000 wing:22000 naca0012:1920; do
        "$bin/cases/geometry/make_surface" "${body%:*}" --triangles "${body#*:}" -o "$out/${body%:*}.off" >/dev/null
        surfaces+=("$out/${body%:*}.off")
    done
fi
cpu() {  # the command's user and system seconds; its output goes to $out/log
    local TIMEFORMAT='%U %S' times
    times=$({ time "$@" >"$out/log" 2>&1; } 2>&1) || { echo "failed"; return 0; }
    awk '{printf "%.2f", $1 + $2}' <<<"$times"
}
echo "| surface | by | CPU s | triangles | mean | 5 % | smallest | angles (deg) | regular | Hausdorff | creases | intersecting |"
echo "|---|---|---|---|---|---|---|---|---|---|---|---|"
row() {  # SURFACE NAME RESULT CPU
    local figures
    figures=$([ -s "$3" ] && "$bin/bench/remesh/remesh_figures" "$1" "$3" "$angle" || echo "no result")
    echo "| $(basename "${1%.*}") | $2 | $4 | $figures |"
}
for surface in "${surfaces[@]}"; do
    name=$(basename "${surface%.*}")
    rm -f "$out/$name"-{strake,protect,constrain}.off
    length=${LENGTH:-$("$bin/cli/strake" info "$surface" --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["edge_length"]["mean"])')}
    seconds=$(cpu "$bin/cli/strake" remesh "$surface" -o "$out/$name-strake.off" --edge-length "$length" --angle "$angle" --threads 1 --quiet)
    row "$surface" strake "$out/$name-strake.off" "$seconds"
    for mode in protect constrain; do
        seconds=$(cpu "$bin/bench/remesh/cgal_remesh" "$surface" "$out/$name-$mode.off" "$length" "$angle" "$mode" 10)
        row "$surface" "CGAL, $mode" "$out/$name-$mode.off" "$seconds"
    done
done
