#!/usr/bin/env python3
"""series.pvd of a run as ParaView reads it: series_test.py STRAKE MAKE_SURFACE

Where ParaView's Python is installed (pvpython and xvfb-run), series.py is run in it and must not say a word; else VTK's
readers, which are the same, read every data set. Exit status 77: skipped, with the reason.
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

STRAKE, MAKE_SURFACE = sys.argv[1:3]
CASE = """
case: body
surface: {file: body.obj}
regions: {root: {box: [[-9, -9, -9], [0.8, 9, 9]]}}
fixed: [root]
parameters: {levels: auto, patches_per_level: [3, 8], variables: [normal], max_displacement: 4%}
objective: {maximize: volume}
constraints: {area: {max: 1.01, relative: true}}
optimize: {budget: {evaluations: 8}}
output: {paraview: POLICY}
"""
IN_PARAVIEW = """
import os, runpy
from paraview.simple import *
runpy.run_path("series.py")
source = FindSource("designs")
assert len(source.TimestepValues) >= 2, list(source.TimestepValues)
assert source.PointData["displacement"].GetRange(-1)[1] > 0
for name in ("patch", "patch_level_1"):
    assert source.CellData[name] is not None, name
SaveScreenshot("shown.png", list(GetLayouts().values())[0], ImageResolution=[400, 200])
assert os.path.getsize("shown.png") > 2000
"""


def with_vtk(folder, files):
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
    for k, file in enumerate(files):
        words = []
        reader = vtkXMLPolyDataReader()
        for event in ("ErrorEvent", "WarningEvent"):
            reader.AddObserver(event, lambda *_: words.append(event))
        reader.SetFileName(str(folder / file))
        reader.Update()
        assert not words, (file, words)
        data = reader.GetOutput()
        assert data.GetNumberOfPolys() > 600 and data.GetNumberOfPoints() > 300, file
        moved = data.GetPointData().GetArray("displacement").GetMaxNorm()
        assert (moved > 1e-3) == (k > 0), (file, moved)
        loads = data.GetPointData().GetArray("load")
        assert loads.GetNumberOfComponents() == 3 and (loads.GetMaxNorm() > 0) == (k > 0), file
        assert data.GetPointData().GetArray("objective_sensitivity").GetMaxNorm() > 0, file
        assert data.GetCellData().GetArray("patch").GetRange()[1] >= 2, file
        assert data.GetCellData().GetArray("patch_level_2").GetRange()[1] >= 5, file


def with_paraview(folder):
    script = folder / "look.py"
    script.write_text(IN_PARAVIEW)
    done = subprocess.run(["xvfb-run", "-a", "pvpython", script], cwd=folder, capture_output=True, text=True,
                          timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert not done.stdout and not done.stderr, done.stdout + done.stderr


def main():
    has_paraview = shutil.which("pvpython") and shutil.which("xvfb-run")
    if not has_paraview:
        try:
            import vtkmodules.vtkIOXML  # noqa: F401
        except ImportError:
            print("skipped: neither ParaView's Python nor python3-vtk9 is installed (scripts/setup.sh test)")
            return 77
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([MAKE_SURFACE, "lifting_body", "--triangles", "1500", "-o", folder / "body.obj"], check=True,
                       capture_output=True)
        for policy in ("every_accepted", "best"):
            (folder / "case.yaml").write_text(CASE.replace("POLICY", policy))
            run = folder / policy
            subprocess.run([STRAKE, "run", folder / "case.yaml", "--out", run, "-q"], check=True, capture_output=True)
            steps = xml.etree.ElementTree.parse(run / "series.pvd").getroot().iter("DataSet")
            files = [step.get("file") for step in steps]
            assert len(files) >= 2 and (policy != "best" or len(files) == 2), files
            compile((run / "series.py").read_text(), "series.py", "exec")
            if has_paraview:
                with_paraview(run)
            else:
                with_vtk(run, files)
    print("1 passed, 0 failed")
    return 0


sys.exit(main())
