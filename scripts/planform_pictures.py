#!/usr/bin/env python3
"""Takes the pictures of docs/planform.md: planform_pictures.py BIN OUT_FOLDER, with a headless Chromium

Runs cases/wing/wave.yaml and a hull by its length, and takes the sheets of both: planform-sheet.svg by `strake info`,
planform-wing.png, planform-report.png and planform-body.png from the reports.
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from browser import Browser  # noqa: E402

bin, out = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
HULL = """case: hull
surface: {file: hull.obj, units: m}
planform: {hull: {length: x, stations: [0.1, 0.5, 0.9]}}
hold: none
shell: none
parameters:
  planform:
    hull.width:  {by: station, range: [-20%, 20%]}
    hull.height: {by: station, range: [-20%, 20%]}
objective: {minimize: area}
constraints: {volume: {min: 1, relative: true}}
optimize: {budget: {evaluations: 20}}
"""


def strake(*words):
    subprocess.run([bin / "strake", *words], check=True, stdout=subprocess.DEVNULL)


def page(browser, report):
    browser.open(report)
    browser.until("document.documentElement.dataset.ready")
    browser.settle()


def window(browser, name, place):
    browser.run(f"document.querySelector({place!r}).scrollIntoView()")
    browser.settle()
    browser.screenshot(out / name)
    print(out / name)


with tempfile.TemporaryDirectory() as folder:
    here = pathlib.Path(folder)
    (here / "generated").mkdir()
    for kind, count, file in (("wing", "22000", "generated/wing.obj"), ("lifting_body", "6000", "hull.obj")):
        subprocess.run([bin / "make_surface", kind, "--triangles", count, "-o", here / file], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
    shutil.copy(pathlib.Path(__file__).resolve().parents[1] / "cases/wing/wave.yaml", here)
    (here / "hull.yaml").write_text(HULL)
    for name in ("wave", "hull"):
        strake("run", here / f"{name}.yaml", "--out", here / name, "-q")
    strake("info", "--planform", here / "wave/best.obj", "--start", here / "generated/wing.obj", "--stations", "0,0.5,1", "--sections",
           out / "planform-sheet.svg")
    print(out / "planform-sheet.svg")
    with Browser(1180, 420) as b:
        page(b, here / "wave/report.html")
        window(b, "planform-wing.png", "#summary")
        b.resize(1180, 760)
        window(b, "planform-report.png", "#wings")
        b.resize(1180, 1080)
        page(b, here / "hull/report.html")
        window(b, "planform-body.png", "#bodies")
