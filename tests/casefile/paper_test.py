#!/usr/bin/python3
"""The paper's examples at a tenth of their size, as scripts/paper.sh runs them: paper_test.py SOURCE PROGRAM...
The bunny, which has to be downloaded, is left out."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

try:
    import vtkmodules  # noqa: F401
except ImportError:
    sys.exit(77)

source, *programs = map(pathlib.Path, sys.argv[1:])
with tempfile.TemporaryDirectory() as folder:
    work = pathlib.Path(folder)
    shutil.copytree(source / "scripts", work / "scripts")
    shutil.copytree(source / "cases/paper", work / "cases/paper", ignore=shutil.ignore_patterns("generated"))
    (work / "bin").mkdir()
    for program in programs:
        (work / "bin" / program.name).symlink_to(program.resolve())
    environment = dict(os.environ, STRAKE_BIN=str(work / "bin"))
    subprocess.run([work / "scripts/paper.sh", "-o", "out", "--small", "wing", "lifting_body", "vehicle", "jet"],
                   env=environment, check=True)
    figures = (work / "out/figures.txt").read_text()
    labels = {line.rsplit(",", 1)[0] for line in (work / "out/times.csv").read_text().splitlines()}


def numbers(pattern):
    match = re.search(pattern.replace("#", r"([+-]?[\d.]+(?:e[+-]?\d+)?)"), figures)
    assert match, f"no '{pattern}' in\n{figures}"
    return [float(g) for g in match.groups()]


before, after = numbers("shear along the flow: sweep # > # deg")
assert after > before + 1, "a shear along the flow sweeps the wing back"
before, after, twist_before, twist_after = numbers("force across: .*dihedral # > # deg, twist .nose up. # > # deg")
assert after > before + 5 and abs(twist_after - twist_before) > 2, "a force across it gives dihedral and twist"
growth, held, differing = numbers(r"volume .*\(# %\), # held triangles, # of them differ")
assert growth >= 10 and held > 1000 and differing == 0, "the cockpit grows and what is held does not move"
bad_before, creases_before, volume_before = numbers("jet, before: .*below 0.2: #, crease length #, volume #")
bad_after, creases_after, volume_after = numbers("jet, after: .*below 0.2: #, crease length #, volume #")
# At a tenth of the size the cells are as long as the engines' pylons are thick: creases and volume within 2 %.
assert bad_before > 500 and bad_after < 20, "slivers go"
assert abs(creases_after / creases_before - 1) < 0.02 and abs(volume_after / volume_before - 1) < 0.02
assert {"wing_sweep: nonlinear solve", "vehicle: patches, three levels", "jet: remesh"} <= labels
