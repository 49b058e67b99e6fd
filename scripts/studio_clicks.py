#!/usr/bin/env python3
"""From a bare surface to a run and its report by clicks alone: studio_clicks.py STRAKE SURFACE:HELD... [--goal QUANTITY] [--evaluations N]

HELD says what is chosen to be held, as a user who looks at the body would point at it:
    patch     the patch under the pointer, as far from the middle along the longest side as any that is seen
    patches   that one and the one at the other end
    plane     a plane across the longest side; its dot is dragged
    part      a connected part: the smallest one that is seen
A press of the mouse is a click, so is a drag; a drop-down list takes two. Each region of the case that is written is compared with
every plane and box along the coordinates, with every part and with unions of patches; the case is checked, and the run of the page and one
of the shell (with the same few evaluations, so that it ends soon) give the same bits. Exit status 1: something of this is not so.
"""
import argparse
import base64
import json
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from browser import Browser  # noqa: E402

STATE = "document.documentElement.dataset"


class User:
    def __init__(self, browser):
        self.b, self.clicks = browser, 0

    def click(self, selector):
        self.b.click(selector)
        self.clicks += 1

    def at(self, x, y, to=None):
        """On the surface; with `to`, a drag."""
        left, top = self.b.place_of("canvas.view")[:2]
        path = [("mousePressed", x, y)] + ([("mouseMoved", (x + to[0]) / 2, (y + to[1]) / 2), ("mouseMoved", *to)] if to else [])
        for kind, u, w in path + [("mouseReleased", *(to or (x, y)))]:
            self.b.call("Input.dispatchMouseEvent", type=kind, x=left + u, y=top + w, button="left", buttons=1, clickCount=1)
        self.clicks += 1
        self.settled()

    def choose(self, label, value):
        self.b.choose(label, value)
        self.clicks += 2
        self.settled()

    def settled(self):
        time.sleep(0.4)
        self.b.until("!strakeStudio.choosing.isAsking", 60)
        self.b.settle()


def what_is_seen(b):
    """[x, y, triangle, point] of a grid over the view."""
    return b.run("""(() => { const s = strakeStudio.scene, list = []; for (let i = 1; i < 40; ++i) for (let k = 1; k < 30; ++k) {
        const x = (i / 40) * s.viewer.width, y = (k / 30) * s.viewer.height, hit = s.at(x, y); if (hit) list.push([x, y, hit.triangle, hit.point]); } return list; })()""")


def hold(user, held):
    b = user.b
    facts = b.run("(({ low, high, components }) => ({ low, high, components }))(strakeStudio.scene.body.facts)")
    size = [h - l for l, h in zip(facts["low"], facts["high"])]
    axis = size.index(max(size))
    user.click("#tab-choose")
    if held == "plane":
        user.choose("Choose by", "plane")
        if axis:
            user.choose("Normal to", str(axis))
        spots = b.run("(() => { const s = strakeStudio.scene, h = s.handles[0], p = s.viewer.placeOf(h.at), q = s.viewer.placeOf(h.at.map((v, k) => v + 0.05 * s.body.diagonal * h.along[k])); return [p, q]; })()")
        user.at(*spots[0], to=spots[1])
        return
    if held == "part":
        user.choose("Choose by", "component")
    seen = what_is_seen(b)
    if held == "part":
        part = b.run("[...strakeStudio.scene.body.array('component')]")
        count = {}
        for one in part:
            count[one] = count.get(one, 0) + 1
        seen.sort(key=lambda one: count[part[one[2]]])
        user.at(*seen[0][:2])
        return
    seen.sort(key=lambda one: one[3][axis])
    user.at(*seen[-1][:2])
    if held == "patches":
        user.at(*seen[0][:2])


class Surface:
    """What the server sends, read without the page."""

    def __init__(self, answer):
        length = struct.unpack_from("<I", answer)[0]
        self.facts, self.data = json.loads(answer[4:4 + length]), answer[4 + length:]
        numbers = lambda name: struct.unpack_from(f"<{self.facts['arrays'][name]['count']}{'f' if self.facts['arrays'][name]['type'] == 'f32' else 'I'}",
                                                  self.data, self.facts["arrays"][name]["offset"])
        p, t = numbers("positions"), numbers("triangles")
        self.corners = [[p[3 * v:3 * v + 3] for v in t[k:k + 3]] for k in range(0, len(t), 3)]
        self.labels = [("patch", numbers(level["array"])) for level in self.facts["levels"]] + [("component", numbers("component"))]

    def shorter(self, marks):
        """Each way to say exactly these triangles: {kind: number of patches or parts}."""
        ways = {}
        inside = [t for t, m in enumerate(marks) if m]
        if len(inside) == len(marks):
            return {"whole surface": 1}
        low = [min(c[a] for t in inside for c in self.corners[t]) for a in range(3)]
        high = [max(c[a] for t in inside for c in self.corners[t]) for a in range(3)]
        others = [t for t, m in enumerate(marks) if not m]
        for a in range(3):
            if all(max(c[a] for c in self.corners[t]) > high[a] for t in others) or all(min(c[a] for c in self.corners[t]) < low[a] for t in others):
                ways["plane"] = 1
        if all(any(c[a] < low[a] or c[a] > high[a] for c in self.corners[t] for a in range(3)) for t in others):
            ways["box"] = 1
        for kind, label in self.labels:
            mine = {label[t] for t in inside}
            if not mine & {label[t] for t in others}:
                ways[kind] = min(len(mine), ways.get(kind, 1 << 30))
        return ways


def stated(yaml):
    """Kind and number of pieces of a region's text."""
    for kind in ("triangles", "any_of", "plane", "box", "patch", "component", "solid", "all"):
        if re.search(rf"\b{kind}\b", yaml):
            names = re.search(rf"\b{kind}: \[([^\]]*)\]", yaml)
            return kind, 1 + names[1].count(",") if names and kind in ("patch", "component") else 1
    words = yaml.strip().strip("'")
    if re.fullmatch(r"p[\d.]+( \+ p[\d.]+)*", words):
        return "patch", 1 + words.count("+")
    return "steps", 1


def regions_are_short(b, surface, text):
    words = []
    for region in b.run("strakeStudio.editor.regions"):
        bits = base64.b64decode(region["marks"])
        marks = [(bits[t >> 3] >> (t & 7)) & 1 for t in range(len(surface.corners))]
        yaml = re.search(rf"^  {re.escape(region['name'])}:(.*(?:\n   .*)*)", text, re.M)[1].split("#")[0]
        kind, pieces = stated(yaml)
        ways = surface.shorter(marks)
        short = (kind in ("patch", "component", "solid", "all") and pieces <= min([ways.get(kind, pieces)] + [n for k, n in ways.items() if k == "component"])) or \
            kind == "plane" or (kind == "box" and "plane" not in ways and 1 not in [ways.get("patch"), ways.get("component")]) or not ways
        words.append((region["name"], yaml.strip(), sum(marks), ways, short))
    return words


def one_body(strake, file, held, goal, evaluations, picture):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        os.environ["XDG_CACHE_HOME"] = str(folder / "cache")
        work = folder / "work"
        work.mkdir()
        shutil.copy(file, work / file.name)
        studio = subprocess.Popen([strake, "studio", file.name, "--no-browser"], cwd=work, stdout=subprocess.PIPE, text=True)
        try:
            with Browser(1280, 860) as b:
                b.open(studio.stdout.readline().strip())
                b.until(f"{STATE}.ready > 0", 600)
                user = User(b)
                user.click("#propose-first")
                b.until(f"{STATE}.ready > 1 || ({STATE}.task || 'propose: 0') !== 'propose: 0'", 1200)
                b.until("strakeStudio.editor.regions.length > 0 || strakeStudio.editor.text.trim()", 60)
                hold(user, held)
                user.click("#put-region")
                user.settled()
                user.click("#tab-case")
                b.until(f"{STATE}.errors === '0' && {STATE}.form > 10", 60)
                chooses = b.run(f"(() => {{ const s = document.querySelector('#form-objective'), v = [...s.options].map((o) => o.value).find((v) => v.replace('+', '') === {goal!r}); if (s.value === v) return false; "
                                "s.value = v; s.dispatchEvent(new Event('change', { bubbles: true })); return true; })()")
                user.clicks += 2
                if chooses:
                    b.until(f"/(min|max)imize: {goal}/.test(strakeStudio.editor.text)", 30)
                    b.until(f"{STATE}.errors === '0'", 60)
                user.click("#tab-run")
                b.run(f"strakeStudio.runs.evaluations.value = {evaluations}")
                user.click("#start")
                b.until(f"{STATE}.run && !['running', 'starting'].includes({STATE}.run)", 3600)
                b.until("!!document.querySelector('#report-link')", 60)
                user.clicks += 1  # on the link: it opens another tab
                report = b.run("(async () => { const a = await fetch(document.querySelector('#report-link').href); return a.status === 200 && (await a.text()).includes('<title>'); })()")
                if picture:
                    b.screenshot(picture)
                words = b.run("strakeStudio.runs.status.textContent")
                answer = base64.b64decode(b.run("(async () => { const a = new Uint8Array(await (await fetch('api/surface')).arrayBuffer()); let s = ''; "
                                                "for (let k = 0; k < a.length; k += 32768) s += String.fromCharCode(...a.subarray(k, k + 32768)); return btoa(s); })()"))
                text = (work / "case.yaml").read_text()
                regions = regions_are_short(b, Surface(answer), text)
                gone = [e for e in b.errors if not ("404" in e and e.endswith("/api/best"))]  # it is not written yet
        finally:
            studio.send_signal(signal.SIGTERM)
            studio.communicate()
        checked = subprocess.run([strake, "check", "case.yaml", "--quick"], cwd=work, capture_output=True, text=True, check=False)
        subprocess.run([strake, "run", "case.yaml", "--set", f"optimize.budget.evaluations={evaluations}", "--out", "again", "-q"], cwd=work, capture_output=True, check=False)
        run = next((work / "runs").iterdir())
        best = sorted(p.name for p in run.glob("best.*"))
        same = bool(best) and all((run / name).read_bytes() == (work / "again" / name).read_bytes() for name in best if not name.endswith((".json", ".yaml")))
        print(f"{file.name}: {user.clicks} clicks; {words}; report {'shown' if report else 'MISSING'}; "
              f"check {checked.returncode}; the shell's bits {'the same' if same else 'DIFFER'} ({', '.join(best)})", flush=True)
        for name, yaml, count, ways, short in regions:
            print(f"    {name}: {yaml}   {count} triangles; ways to say them: {ways}{'' if short else '   NOT the shortest'}", flush=True)
        for error in gone:
            print(f"    the page said: {error}")
        if checked.returncode:
            print(checked.stdout[-2000:], checked.stderr[-2000:])
        return user.clicks <= 15 and report and not checked.returncode and same and all(r[-1] for r in regions) and not gone


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("strake")
    parser.add_argument("bodies", nargs="+", metavar="SURFACE:HELD")
    parser.add_argument("--goal", default="area")
    parser.add_argument("--evaluations", type=int, default=3)
    parser.add_argument("--pictures", type=pathlib.Path)
    told = parser.parse_args()
    fine = True
    for body in told.bodies:
        name, held = body.rsplit(":", 1)
        file = pathlib.Path(name).resolve()
        fine &= one_body(str(pathlib.Path(told.strake).resolve()), file, held, told.goal, told.evaluations, told.pictures and str(told.pictures / f"{file.stem}.png"))
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
