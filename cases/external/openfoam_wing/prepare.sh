#!/bin/bash
# Makes a plain wing, the mesh about it, the flow to start from, and the start shape, in generated/: prepare.sh [BIN]
# BIN holds make_surface (default: what ./run.sh has built). Needs: scripts/setup.sh openfoam
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bin=$(cd "${1:-$here/../../../build/run/bin}" && pwd)
cd "$here"
../../../scripts/examples.sh ../.. "$bin"
./wing.py prepare generated/wing.obj
