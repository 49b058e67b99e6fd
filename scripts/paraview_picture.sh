#!/bin/bash
# What ParaView shows of a run with its state file: paraview_picture.sh RUN OUT.png
# Needs pvpython (apt-get install python3-paraview, which takes the place of python3-vtk9) and xvfb-run.
set -euo pipefail
[ $# = 2 ] || { echo "usage: paraview_picture.sh RUN OUT.png" >&2; exit 2; }
run=$(realpath "$1") out=$(realpath "$2")
script=$(mktemp --suffix=.py)
trap 'rm -f "$script"' EXIT
cat >"$script" <<'PY'
import os
import runpy

from paraview.simple import *

runpy.run_path("series.py")
SaveScreenshot(os.environ["PICTURE"], list(GetLayouts().values())[0], ImageResolution=[1200, 480])
PY
cd "$run"
PICTURE=$out xvfb-run -a pvpython "$script"
