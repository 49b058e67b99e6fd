#!/bin/bash
# The examples of section VI of the paper (Berkenstock & Aftosmis 2008), each from its bare surface, with figures and
# pictures: paper.sh [-o FOLDER] [--small] [wing | lifting_body | bunny | vehicle | jet]...
# --small takes a tenth of the triangles. The bunny comes from Debian's package libcgal-demo (downloaded, not installed)
# or from the file that BUNNY names. Pictures need scripts/setup.sh pictures; without it there are none.
set -euo pipefail
cd "$(dirname "$0")/.."
out=build/paper small=1 examples=()
while [ $# -gt 0 ]; do
    case $1 in
        -o) out=$2 && shift ;;
        --small) small=10 ;;
        wing | lifting_body | bunny | vehicle | jet) examples+=("$1") ;;
        *) sed -n '2,5s/^# //p' "$0" >&2 && exit 2 ;;
    esac
    shift
done
[ ${#examples[@]} -gt 0 ] || examples=(wing lifting_body bunny vehicle jet)
if [ -z "${STRAKE_BIN:-}" ]; then
    scripts/setup.sh run
    cmake --preset run >/dev/null
    cmake --build build/run --target strake make_surface make_jet >/dev/null
    STRAKE_BIN=build/run/bin
fi
bin=$(realpath "$STRAKE_BIN")
export STRAKE_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1  # as on the paper's machine: one core
mkdir -p "$out" cases/paper/generated
generated=cases/paper/generated

# timed LABEL COMMAND...: the command's CPU seconds as a line of times.csv.
timed() {
    local label=$1 TIMEFORMAT='%U %S' log seconds
    shift
    log=$(mktemp)
    if ! seconds=$({ time "$@" >"$log" 2>"$log.err"; } 2>&1); then
        cat "$log" "$log.err" >&2
        exit 1
    fi
    seconds=$(awk '{print $1 + $2}' <<<"$seconds")
    echo "$label,$seconds" >>"$out/times.csv"
    printf '%-42s %8.2f s\n' "$label" "$seconds"
    rm -f "$log" "$log.err"
}
picture() {
    command -v xvfb-run >/dev/null && /usr/bin/python3 -c 'import vtkmodules' 2>/dev/null || return 0
    xvfb-run -a /usr/bin/python3 scripts/render.py "$out/$1" "${@:2}"
}
figures() { /usr/bin/python3 scripts/paper_figures.py "$@" | tee -a "$out/figures.txt"; }
edge_for() {  # SURFACE TRIANGLES: of so many equilateral ones of the same area
    "$bin/strake" info "$1" --json | /usr/bin/python3 -c "import json, sys; print((4 / 3**0.5 * json.load(sys.stdin)['area'] / $2) ** 0.5)"
}
deform() {  # NAME ENDING: linear and nonlinear
    timed "$1: one linear solve" "$bin/strake" deform "cases/paper/$1.yaml" --linear -o "$out/$1-linear.$2"
    timed "$1: nonlinear solve" "$bin/strake" deform "cases/paper/$1.yaml" --quiet -o "$out/$1.$2"
}

wing() {
    "$bin/make_surface" wing --triangles $((22000 / small)) -o $generated/wing.obj
    timed "wing: patches" "$bin/strake" patches $generated/wing.obj --angle 10 --angle 1 --min-size 0.2% -o "$out/wing-patches.vtp"
    deform wing_sweep obj
    deform wing_lift obj
    figures wing $generated/wing.obj "$out/wing_sweep.obj" "$out/wing_lift.obj"
    picture paper-wing.png "$out/wing-patches.vtp:level_1" "$out/wing_sweep.obj" "$out/wing_lift.obj" --view=-1,-0.8,0.5 \
        --titles "patches at 10 degrees|shear along the flow|force across it" --size 560,400
}
lifting_body() {
    "$bin/make_surface" lifting_body --triangles $((131000 / small)) -o $generated/lifting_body.stl
    timed "lifting body: patches" "$bin/strake" patches $generated/lifting_body.stl --angle 10 --angle 5 --angle 2.5 --min-size 0.5% \
        -o "$out/lifting_body-patches.vtp"
    deform lifting_body stl
    figures lifting_body $generated/lifting_body.stl "$out/lifting_body.stl"
    picture paper-lifting_body.png "$out/lifting_body-patches.vtp:level_3" $generated/lifting_body.stl "$out/lifting_body.stl" \
        --view=-1,-1,0.8 --titles "patches at 2.5 degrees|start|load on the cockpit" --size 560,440
}
bunny() {
    local start=${BUNNY:-$generated/bunny00.off}
    if [ ! -e "$start" ]; then
        (cd $generated && apt-get download -q libcgal-demo >/dev/null && dpkg-deb --fsys-tarfile libcgal-demo_*.deb |
            tar -xO --wildcards '*/data.tar.gz' | tar -xzO data/meshes/bunny00.off >bunny00.off.part &&
            mv bunny00.off.part bunny00.off && rm libcgal-demo_*.deb)
    fi
    local edge
    edge=$(edge_for "$start" $((83000 / small)))
    timed "bunny: remesh" "$bin/strake" remesh "$start" --edge-length "$edge" -o $generated/bunny.ply
    timed "bunny: patches" "$bin/strake" patches $generated/bunny.ply --angle 10 --min-size 0.5% -o "$out/bunny-patches.vtp"
    deform bunny ply
    figures bunny $generated/bunny.ply "$out/bunny.ply"
    picture paper-bunny.png $generated/bunny.ply "$out/bunny.ply" --view=-0.6,0.25,1 --up y --titles "start|an ear is bent" --size 640,560
}
vehicle() {
    "$bin/make_surface" winged_vehicle --triangles $((418000 / small)) -o $generated/vehicle.stl
    local wing
    wing=$(/usr/bin/python3 scripts/paper_figures.py triangle_near $generated/vehicle.stl 7 2 0.1)
    timed "vehicle: patches, three levels" "$bin/strake" patches $generated/vehicle.stl --angle 10 --angle 2 --angle 0.3 --min-size 0.5% \
        --split "containing:$wing" -o "$out/vehicle-patches.vtp"
    picture paper-vehicle.png "$out/vehicle-patches.vtp:level_1" "$out/vehicle-patches.vtp:level_2" "$out/vehicle-patches.vtp:level_3" \
        --view=-1,-1,1.2 --titles "level 1|level 2|level 3" --size 560,400
}
jet() {
    "$bin/make_jet" --triangles $((93000 / small)) -o $generated/jet.ply
    local edge
    edge=$(edge_for $generated/jet.ply $((112000 / small)))
    timed "jet: remesh" "$bin/strake" remesh $generated/jet.ply --edge-length "$edge" -o "$out/jet.ply"
    figures jet $generated/jet.ply "$out/jet.ply"
    picture paper-jet.png $generated/jet.ply "$out/jet.ply" --edges --view=-1,-1,1 --centre 15,1.2,0.8 --zoom 7 \
        --titles "as converted|strake remesh" --size 480,360
}

for example in "${examples[@]}"; do "$example"; done
