"""The examples of version 0.1, with the case files that it came with: of_0_1_test.py ROOT STRAKE MAKE_SURFACE

Each passes `strake check`; the wing's runs a few evaluations, and its fit, too. What has moved meanwhile is said as a note, not as an error.
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT, STRAKE, MAKE_SURFACE = (pathlib.Path(a).resolve() for a in sys.argv[1:4])


def run(*command, cwd=None):
    done = subprocess.run([str(word) for word in command], cwd=cwd, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}: status {done.returncode}\n{done.stdout[-3000:]}")
    return done.stdout


with tempfile.TemporaryDirectory() as temporary:
    work, programs = pathlib.Path(temporary) / "cases", pathlib.Path(temporary) / "bin"
    shutil.copytree(ROOT / "cases", work, ignore=shutil.ignore_patterns("*.yaml", "generated", "*.cpp", "*.hpp"))
    shutil.copytree(ROOT / "tests/casefile/of_0_1/cases", work, dirs_exist_ok=True)
    programs.mkdir()
    os.symlink(STRAKE, programs / "strake")
    os.symlink(MAKE_SURFACE, programs / "make_surface")
    run(ROOT / "scripts/examples.sh", work, programs, 3000, 3000)
    cases = [file for file in sorted(work.rglob("*.yaml")) if "bunny" not in file.name]  # its surface is a download
    assert len(cases) == 19, cases
    for case in cases:
        run(STRAKE, "check", case, cwd=work)
    print(len(cases), "cases of 0.1 pass check")
    for command, case in (("run", "wing/case.yaml"), ("fit", "wing/fit.yaml"), ("run", "external/case.yaml")):
        out = work / command / case.replace("/", "-")
        run(STRAKE, command, work / case, "--out", out, "--quiet", "--set", "optimize.budget.evaluations=4", "--set", "output.report=false", cwd=work)
        result = json.loads((out / "run.json").read_text())
        assert result["status"] in ("budget", "converged"), result["status"]
        assert (out / "best.obj").is_file() or list(out.glob("best.*")), out
        print(case, result["status"])
