#!/bin/bash
# Makes the surfaces of the example cases where they are missing: examples.sh CASES_FOLDER BIN [WING [BODY]]
# CASES_FOLDER holds the folders of the cases; BIN holds strake and make_surface; WING and BODY: numbers of triangles.
set -euo pipefail
cases=$1 bin=$2 wing_triangles=${3:-22000} body_triangles=${4:-30000}
wing=$cases/wing/generated body=$cases/lifting_body/generated
mkdir -p "$wing" "$body"

# Written under another name first: whatever stands there is complete.
if [ ! -e "$wing/wing.obj" ]; then
    "$bin/make_surface" wing --triangles "$wing_triangles" -o "$wing/part.obj"
    mv "$wing/part.obj" "$wing/wing.obj"
fi
if [ ! -e "$body/lifting_body.stl" ]; then
    "$bin/make_surface" lifting_body --triangles "$body_triangles" -o "$body/part.stl"
    mv "$body/part.stl" "$body/lifting_body.stl"
fi
surface() {  # FILE SURFACE TRIANGLES
    mkdir -p "$(dirname "$1")"
    [ -e "$1" ] && return
    local part=${1%/*}/part.${1##*.}
    "$bin/make_surface" "$2" --triangles "$3" -o "$part"
    mv "$part" "$1"
}
surface "$cases/wave_drag/generated/wavy_body.obj" wavy_body 5000
surface "$cases/nacelle/generated/nacelle.obj" nacelle 5000
surface "$cases/nacelle/generated/engine.obj" engine 2000
# Those of the paper's cases, but for the bunny; scripts/paper.sh makes all of them in the paper's sizes.
surface "$cases/paper/generated/wing.obj" wing "$wing_triangles"
surface "$cases/paper/generated/lifting_body.stl" lifting_body "$body_triangles"
# Those of the cases with OpenFOAM.
surface "$cases/external/openfoam_drag/generated/body.obj" bluff_body 4000
surface "$cases/external/openfoam_supersonic/generated/body.obj" wavy_body 3000
surface "$cases/external/openfoam_wing/generated/wing.obj" wing 5000
# Those of the hand-over to SU2 and Cart3D, whose programs are played by scripts: nothing for machines without Python.
surface "$cases/external/su2/generated/body.obj" ellipsoid 600
surface "$cases/external/cart3d/generated/body.obj" ellipsoid 600
if command -v python3 >/dev/null; then
    fakes=$(cd "$(dirname "$0")/../cases/external" && pwd)
    su2=$cases/external/su2/generated cart3d=$cases/external/cart3d/generated
    [ -e "$su2/mesh.su2" ] || python3 "$fakes/su2/fake_su2.py" mesh "$su2/body.obj" "$su2"
    [ -e "$cart3d/body.tri" ] || python3 "$fakes/cart3d/fake_cart3d.py" components "$cart3d/body.obj" "$cart3d/body.tri"
fi
# The wing with OpenFOAM starts from a twisted one.
wing_start=$cases/external/openfoam_wing/generated
if command -v python3 >/dev/null && [ ! -e "$wing_start/start.obj" ]; then
    python3 "$fakes/openfoam_wing/twist.py" 12 "$wing_start/wing.obj" "$wing_start/part.obj"
    mv "$wing_start/part.obj" "$wing_start/start.obj"
fi
# Those of the published problems.
if command -v python3 >/dev/null; then
    published=$cases/published/generated
    mkdir -p "$published"
    for start in bumped_spindle:10000 bumped_ogive:10000 frustum_1:10000 nose_0.75:4000 wing_panels:2000 sphere:2000 wing_10:2000 wing_6_12:2000 wing_raised:2000 sbend:1280 onera_m6:3000; do
        [ -e "$published/${start%:*}.obj" ] && continue
        python3 "$(dirname "$0")/../cases/published/surfaces.py" "${start%:*}" --triangles "${start#*:}" -o "$published/part.obj"
        mv "$published/part.obj" "$published/${start%:*}.obj"
    done
fi
# The shape that cases/wing/fit.yaml is to recover.
if [ ! -e "$wing/target.obj" ] || [ "$cases/wing/target.yaml" -nt "$wing/target.obj" ] ||
   [ "$wing/wing.obj" -nt "$wing/target.obj" ]; then
    "$bin/strake" deform "$cases/wing/target.yaml" -o "$wing/part.obj" >&2
    mv "$wing/part.obj" "$wing/target.obj"
fi
