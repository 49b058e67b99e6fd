"""The wheel of `pip wheel .` from a build that is there: wheel_test.py BUILD

Made by the back end that pyproject.toml names, twice: the same bits. Unpacked, it is imported, and its programs run, by its own
libraries alone; its RECORD names every file with its hash. Ends with 77, which ctest counts as skipped, without patchelf.
"""
import base64
import csv
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv[1]).resolve()
if not shutil.which("patchelf"):
    print("skipped: patchelf is not installed (scripts/setup.sh run package)")
    sys.exit(77)
named = dict(re.findall(r'^(build-backend|backend-path) = \[?"([^"]+)"\]?$', (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.M))
sys.path.insert(0, str(ROOT / named["backend-path"]))
sys.dont_write_bytecode = True
back_end = __import__(named["build-backend"])


def told(*command, **environment):
    return subprocess.run([str(word) for word in command], check=True, text=True, stdout=subprocess.PIPE,
                          env={**os.environ, **environment}).stdout


with tempfile.TemporaryDirectory() as temporary:
    folder = pathlib.Path(temporary)
    os.environ["SOURCE_DATE_EPOCH"] = "1700000000"
    wheels = []
    for name in ("one", "two"):
        (folder / name).mkdir()
        wheels.append(folder / name / back_end.build_wheel(str(folder / name), {"build-dir": str(BUILD)}))
    assert wheels[0].read_bytes() == wheels[1].read_bytes(), "two wheels of the same build differ"
    tag = "cp{0}{1}-cp{0}{1}-manylinux_".format(*sys.version_info[:2])
    assert tag in wheels[0].name, wheels[0].name
    with zipfile.ZipFile(wheels[0]) as wheel:
        site = folder / "site"
        wheel.extractall(site)
        for item in wheel.infolist():
            (site / item.filename).chmod((item.external_attr >> 16) & 0o777)
        files = set(wheel.namelist())
    info = next(name for name in files if name.endswith("/RECORD"))
    recorded = {row[0]: row[1] for row in csv.reader((site / info).read_text(encoding="utf-8").splitlines())}
    assert set(recorded) == files, files ^ set(recorded)
    for name, digest in recorded.items():
        if name != info:
            told_digest = base64.urlsafe_b64encode(hashlib.sha256((site / name).read_bytes()).digest()).rstrip(b"=").decode()
            assert digest == f"sha256={told_digest}", name
    assert any(name.endswith("py.typed") for name in files)
    meta = (site / info.replace("RECORD", "METADATA")).read_text(encoding="utf-8")
    permissive = "no part under the GPL" in told(site / "strake/bin/strake", "--licenses")
    assert re.search(r"^License: (.*)$", meta, re.M)[1].startswith("Apache-2.0" if permissive else "GPL-3.0"), meta[:400]
    assert re.search(r"^Requires-Dist: numpy", meta, re.M), meta[:400]
    clean = {"PYTHONPATH": str(site), "PYTHONDONTWRITEBYTECODE": "1"}
    version = told(sys.executable, "-c", "import strake; print(strake.__version__)", **clean).strip()
    assert told(sys.executable, "-m", "strake", "--version", **clean).split()[1] == version
    told(site / "strake/bin/make_surface", "wing", "--triangles", "1000", "-o", folder / "wing.obj")
    assert (folder / "wing.obj").stat().st_size > 10000
    print(f"{wheels[0].name}: {wheels[0].stat().st_size / 1e6:.0f} MB")
