#!/usr/bin/env python3
"""Takes the pictures of docs/studio.md with a headless Chromium: studio_pictures.py STRAKE SURFACE OUT_FOLDER

SURFACE is made by make_surface wing --triangles 4000.

Pictures: studio-look, -choose, -case, -feel, -section, -run. The case is the one that Strake proposes; eight evaluations are made.
"""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from browser import Browser  # noqa: E402

strake, surface, out = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
state = "document.documentElement.dataset"


def shot(browser, name):
    time.sleep(0.6)
    browser.run("scrollTo(0, 0)")
    browser.run("(() => { const s = strakeStudio; s.refreshAgain = s.refresh; s.refresh = async () => {}; })()")
    browser.settle()
    # Whoever takes the pictures works in a folder of any name.
    browser.run("strakeStudio.folder.textContent = strakeStudio.folder.textContent.replace(/^\\S+/, '/home/me/body')")
    browser.run("(() => { const r = document.querySelector('#panel-run .reason'); r.textContent = r.textContent.replace(/^\\S*\\/runs/, 'runs'); })()")
    browser.settle()
    browser.screenshot(out / f"studio-{name}.png")
    browser.run("strakeStudio.refresh = strakeStudio.refreshAgain")
    print(out / f"studio-{name}.png")


with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as cache:
    os.environ["XDG_CACHE_HOME"] = cache
    shutil.copy(surface, folder)
    studio = subprocess.Popen([strake, "studio", surface.name, "--no-browser"], cwd=folder, stdout=subprocess.PIPE, text=True)
    with Browser(1280, 860) as b:
        b.open(studio.stdout.readline().strip())
        b.until(f"{state}.ready > 0")
        shot(b, "look")
        b.click("#propose-first")
        b.until(f"{state}.ready > 1", 600)
        b.click("#tab-choose")
        b.choose("Choose by", "plane")
        b.choose("Normal to", "0")
        b.run("(() => { const s = document.querySelector('#plane-at'); s.value = 250; s.dispatchEvent(new Event('input', { bubbles: true })); })()")
        b.run("strakeStudio.tell('')")
        shot(b, "choose")
        b.click("#put-region")
        time.sleep(1)
        b.click("#tab-case")
        b.click("#save")
        time.sleep(1.5)
        shot(b, "case")
        b.click("#tab-feel")
        b.until(f"{state}.felt", 200)
        b.run("(() => { const i = document.querySelector('.slider input'); i.value = 0.6 * i.max; i.dispatchEvent(new Event('input')); })()")
        b.until(f"{state}.felt === 'ok 1'", 100)
        b.until(f"{state}.fetched > 0", 100)
        b.choose("Colours", "slope")
        b.until("!!strakeStudio.scene.field && !!strakeStudio.feel.rates", 100)
        b.run("strakeStudio.tell('')")
        shot(b, "feel")
        b.choose("Colours", "patches")
        b.click("#cut")
        b.run("(() => { const s = document.querySelector('#section-at'); s.value = 700; s.dispatchEvent(new Event('input', { bubbles: true })); })()")
        shot(b, "section")
        b.click("#cut")
        b.click("#tab-run")
        b.run("strakeStudio.runs.evaluations.value = 16")
        b.click("#start")
        b.until(f"!!document.querySelector('#report-link')", 600)
        b.run("strakeStudio.tell('')")
        shot(b, "run")
    studio.send_signal(signal.SIGTERM)
    studio.communicate()
