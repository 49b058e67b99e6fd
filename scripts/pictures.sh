#!/bin/bash
# Renders docs/pictures from run folders, off screen with VTK: pictures.sh [BIN] [RUN_OF_FIT RUN_OF_WING RUN_OF_BODY EVIDENCE]
# Without run folders it takes the newest under runs/ (as ./run.sh leaves them), and the evidence suite's runs/evidence
# (bench/coarse_to_fine/run.sh, at least --problems local_bump,global_twist). Needs: scripts/setup.sh pictures
set -euo pipefail
cd "$(dirname "$0")/.."
bin=${1:-build/run/bin}
newest() { find runs -maxdepth 1 -name "$1-*" -type d 2>/dev/null | sort | tail -n 1; }
fit=${2:-$(newest wing-fit)} wing=${3:-$(newest wing-case)} body=${4:-$(newest lifting_body-case)}
evidence=${5:-runs/evidence}
out=docs/pictures
mkdir -p $out
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

picture() {  # OUT.png and the arguments of render.py
    xvfb-run -a /usr/bin/python3 scripts/render.py "$out/$1" "${@:2}"
    echo "$out/$1"
}
patches() {  # SURFACE NAME WANTED_PER_LEVEL: the tree that the case uses
    "$bin/strake" patches "$1" --angle auto --patches-per-level "$3" -o "$work/$2.vtp" >/dev/null
}

scripts/examples.sh cases "$bin"
start=cases/wing/generated/wing.obj
patches $start wing 2,6,16
patches cases/lifting_body/generated/lifting_body.stl body 4,12,32

# What fields and loads do: docs/variables.md.
xvfb-run -a /usr/bin/python3 scripts/variables_pictures.py "$bin" $out
# What strake init draws by itself: no VTK here.
"$bin/make_surface" wing --triangles 4000 -o "$work/wing.obj"
"$bin/strake" init "$work/wing.obj" -o "$work/init.yaml" --quiet
cp "$work/init-patches.svg" $out/init.svg
# The start page's commands, on a terminal, while the run goes on.
(
    cd "$work"
    PATH="$OLDPWD/$bin:$bin:$PATH"
    "$OLDPWD/scripts/terminal_picture.py" "$OLDPWD/$out/terminal.svg" --columns 104 --until '^\[.* (19|2[0-9])/60 ' \
        --title 'strake init, strake run' -- strake init wing.obj -o first.yaml -- strake run first.yaml --out runs/first
)
picture wing-patches.png "$work/wing.vtp:level_1" "$work/wing.vtp:level_2" "$work/wing.vtp:level_3" \
    --view=-0.5,-0.7,1.2 --titles "level 1|level 2|level 3" --size 640,520
picture lifting_body-patches.png "$work/body.vtp:level_1" "$work/body.vtp:level_2" "$work/body.vtp:level_3" \
    --view=-1,-1,1 --titles "level 1|level 2|level 3" --size 640,480
"$bin/make_surface" naca0012 --triangles 1500 -o "$work/needles.obj"
"$bin/strake" remesh "$work/needles.obj" -o "$work/even.obj" --edge-length 0.08 --quiet
picture remesh.png "$work/needles.obj" "$work/even.obj" --edges --view=-1,-0.7,0.6 --titles "before|strake remesh" --size 560,360
"$bin/make_surface" lifting_body --triangles 4000 -o "$work/whole.obj"
# A hole around a point of the upper side, and turned triangles behind it.
awk '/^v / {x[++n] = $2; y[n] = $3; z[n] = $4}
     /^f/ {px = (x[$2] + x[$3] + x[$4]) / 3; py = (y[$2] + y[$3] + y[$4]) / 3; pz = (z[$2] + z[$3] + z[$4]) / 3
           if ((px - 4) ^ 2 + (py - 0.4) ^ 2 < 0.8 && pz > 0) next
           if (px > 6 && px < 6.7 && pz > 0) {print $1, $2, $4, $3; next}} {print}' "$work/whole.obj" >"$work/torn.obj"
"$bin/strake" info "$work/torn.obj" --vtp "$work/torn.vtp" >/dev/null
for fill in planar smooth; do
    "$bin/strake" repair "$work/torn.obj" --out "$work/$fill.obj" --orient --holes all --fill $fill --isolated --quiet
done
picture repair.png "$work/torn.vtp:misoriented" "$work/planar.obj" "$work/smooth.obj" --edges --view=-1,-0.7,1.2 \
    --titles "torn|strake repair|with --fill smooth" --size 520,360
"$bin/make_surface" lifting_body --triangles 1500 -o "$work/coarse.obj"
"$bin/strake" remesh "$work/coarse.obj" -o "$work/coarse-even.obj" --edge-length 2.5% --quiet
picture remesh-body.png "$work/coarse.obj" "$work/coarse-even.obj" --edges --view=-1,-1,1 --titles "before|strake remesh" --size 560,420
if [ -n "$wing" ]; then
    picture wing.png $start "$wing"/best.obj "$work/wing.vtp:level_2" \
        --view=-1,-0.7,0.45 --titles "before|after: more volume, hardly more skin|patches, level 2" --size 640,420
fi
if [ -n "$fit" ]; then
    picture wing-fit.png $start cases/wing/generated/target.obj "$fit"/best.obj \
        --view=-1,-0.7,0.45 --titles "start|target|recovered" --size 640,420
fi
if [ -n "$body" ]; then
    picture lifting_body.png cases/lifting_body/generated/lifting_body.stl "$body"/best.stl \
        --view=-1,-1,0.8 --titles "before|after: more volume within the area allowed" --size 800,560
fi
glide=$(newest lifting_body-glide) wave=$(newest wave_drag-case)
if [ -n "$glide" ]; then
    picture glide.png cases/lifting_body/generated/lifting_body.stl "$glide"/best.stl \
        --view=-1,-1,0.8 --titles "before|after: a longer glide, trimmed, same volume" --size 800,560
fi
if [ -n "$wave" ]; then
    /usr/bin/python3 scripts/plot_radius.py cases/wave_drag/generated/wavy_body.obj "$wave"/best.obj $out/wave_drag.svg
    echo "$out/wave_drag.svg"
fi
# The report: of the glide, and of a run in which a program failed (runs/failing-*).
failing=$(newest failing)
if [ -n "$glide" ] && [ -n "$failing" ]; then
    "$bin/strake" report "$glide" -o "$work/glide.html" >/dev/null
    "$bin/strake" report "$failing" -o "$work/failing.html" >/dev/null
    scripts/report_pictures.py "$work/glide.html" "$work/failing.html" $out
fi
# The runs of docs/external/openfoam.md, into runs/openfoam_*.
external=cases/external
solver() {  # PICTURE START RUN TITLES and the arguments of render.py
    local name=$1 start=$2 run=$3 titles=$4
    [ -f "$run/best.obj" ] && picture "$name" "$start" "$run/best.obj" --titles "$titles" --size 440,340 "${@:5}"
    return 0
}
solver openfoam_drag.png $external/openfoam_drag/generated/body.obj runs/openfoam_drag \
    "before|after: less drag, same volume" --view=-1,-1,0.5
solver openfoam_supersonic.png $external/openfoam_supersonic/generated/body.obj runs/openfoam_supersonic \
    "before|after: less wave drag, same volume" --view side --edges
solver openfoam_wing.png $external/openfoam_wing/generated/start.obj runs/openfoam_wing \
    "before|after: less drag, same lift" --view=-1,-0.7,0.45
# Problems with published answers: scripts/published.sh wing_body_free stokes_area transonic, into build/published.
published=build/published generated=cases/published/generated
with_wing() {  # BODY NAME: both in one file
    awk 'FNR == 1 {before = n} $1 == "v" {++n; print} $1 == "f" {print "f", $2 + before, $3 + before, $4 + before}' \
        "$1" $generated/wing_panels.obj >"$work/$2.obj"
}
if [ -f $published/wing_body_free/best.obj ]; then
    with_wing $generated/bumped_spindle.obj start
    with_wing $published/wing_body_free/best.obj free
    picture published-wing_body_free.png "$work/start.obj" "$work/free.obj" --view=-1,-1,0.8 \
        --titles "start|free fuselage: least wave drag at Mach 1.4" --size 520,300
fi
if [ -f $published/stokes_area/best.obj ]; then
    picture published-stokes_area.png $generated/sphere.obj $published/stokes_area/best.obj --view=0,-1,0.2 --edges \
        --titles "start|least drag in Stokes flow, same area" --size 400,230
fi
if [ -f $published/transonic/box/transonic-box_4x4x2.obj ]; then
    scripts/section_picture.py $out/published-transonic.svg --at 0.2,0.7,1.05 start=$generated/onera_m6.obj \
        Strake=$published/transonic/best.obj "box 4 x 4 x 2=$published/transonic/box/transonic-box_4x4x2.obj"
fi
find $out \( -name "published-*.png" -o -name "variables-*.png" \) -exec /usr/bin/python3 scripts/smaller_png.py {} +
if [ -f "$evidence/local_bump-sqp.vtp" ] && [ -f "$evidence/global_twist-sqp.vtp" ]; then
    bump=$evidence/local_bump-sqp.vtp twist=$evidence/global_twist-sqp.vtp
    picture trees.png "$bump:fineness" "$bump:patch" "$twist:fineness" "$twist:patch" --columns 2 --size 640,360 --view=0.4,1,0.6 \
        --titles "local bump: splits above a patch|its patches|global twist: splits above a patch|its patches"
fi
# Large ones get a palette instead of true colours: a third of the size.
find $out -name "*.png" -size +150k -exec /usr/bin/python3 scripts/smaller_png.py {} +
