#!/bin/bash
# What ParaView shows of a run with its state file: paraview_picture.sh RUN OUT.png
# Needs pvpython (apt-get install python3-paraview, which takes the place of python3-vtk9) and xvfb-run.
set -euo pipefail
[ $# = 2 ] || { echo "usage: paraview_picture.sh RUN OUT.png" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
run=$(realpath "$1") out=$(realpath "$2")
cd "$run"
xvfb-run -a pvpython - "$out" <<'PY'
import runpy
import sys

from paraview.simple import *

runpy.run_path("series.py")
SaveScreenshot(sys.argv[1], list(GetLayouts().values())[0], ImageResolution=[1200, 480])
PY
/usr/bin/python3 "$here/smaller_png.py" "$out"
