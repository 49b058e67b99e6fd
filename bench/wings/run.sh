#!/bin/bash
# bench/wings/run.sh [OUT] [options of strake_wings]
# Least wave drag of a wing-body, and bending moment against area: by Strake's variables and by boxes of B-splines that
# twist. Prints one line each; histories and shapes go to OUT (default: runs/wings).
# STRAKE_DATA=FOLDER with oneraM6_pyhyp_small.ply: bending moment against area on that wing, too.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
out=runs/wings
if [ $# -gt 0 ] && [[ $1 != --* ]]; then
    out=$1
    shift
fi
launcher=()
! command -v ccache >/dev/null || launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
(cd "$root" && cmake --preset bench "${launcher[@]}" >/dev/null && ninja -C build/bench --quiet -j "${JOBS:-1}" strake_wings make_surface)
mkdir -p "$out"
out=$(cd "$out" && pwd)
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
python3 "$root/bench/wings/wing_body.py" --triangles 4000 -o "$out/wing_body.obj"
"$root/build/bench/cases/geometry/make_surface" wing --triangles 8000 -o "$out/wing.obj"
solve=("$root/build/bench/bench/wings/strake_wings" --out "$out" --root-held)
wave=("$root/bench/wings/wave.yaml" --set "surface.file=$out/wing_body.obj")
bending=("$root/bench/wings/bending.yaml" --downstream)
"${solve[@]}" "${wave[@]}" --boxes 6x4x2,8x5x2 --reach 0.03 "$@"
"${solve[@]}" "${bending[@]}" --set "surface.file=$out/wing.obj" --boxes 4x6x2,4x8x2 "$@"
onera=${STRAKE_DATA:-}/oneraM6_pyhyp_small.ply
if [ -f "$onera" ]; then
    "${solve[@]}" "${bending[@]}" --set "surface.file=$onera" --set case=bending_m6 --set 'axes={downstream: +x, up: +y}' \
        --set 'symmetry={plane: z, at: 0}' --set planform.wing.span=z --boxes 4x6x2,4x8x2 "$@"
fi
