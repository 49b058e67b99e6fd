#!/bin/bash
# Makes the start shape, the mesh about it and the flow to start from, in generated/: prepare.sh [BIN]
# BIN holds make_surface (default: what ./run.sh has built). Needs: scripts/setup.sh openfoam
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bin=$(cd "${1:-$here/../../../build/run/bin}" && pwd)
cd "$here"
../../../scripts/examples.sh ../.. "$bin"
./drag.py prepare generated/body.obj
