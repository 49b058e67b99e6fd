#!/usr/bin/env python3
"""The studio in a real browser: browser_test.py STRAKE MAKE_SURFACE. Exit status 77: skipped, with the reason."""
import json
import math
import os
import pathlib
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from browser import Browser, find_chromium  # noqa: E402

STRAKE, MAKE_SURFACE = sys.argv[1:3]
ROOT = "document.documentElement.dataset"


class Page(unittest.TestCase):
    """One user's way, step by step."""

    @classmethod
    def setUpClass(cls):
        cls.around = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.around.name) / "work"
        cls.folder.mkdir()
        os.environ["XDG_CACHE_HOME"] = str(pathlib.Path(cls.around.name) / "cache")
        subprocess.run([MAKE_SURFACE, "wing", "--triangles", "2000", "-o", cls.folder / "body.stl"], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        cls.start()
        cls.browser = Browser(1280, 860)
        cls.browser.open(cls.url)
        cls.browser.until(f"{ROOT}.ready > 0")

    @classmethod
    def start(cls, *arguments):
        cls.studio = subprocess.Popen([STRAKE, "studio", "body.stl", "--no-browser", *arguments], cwd=cls.folder,
                                      stdout=subprocess.PIPE, text=True)
        cls.url = cls.studio.stdout.readline().strip()

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()
        cls.studio.send_signal(signal.SIGTERM)
        cls.studio.communicate(timeout=20)
        cls.around.cleanup()

    def text(self, selector):
        return self.browser.run(f"document.querySelector({selector!r}).innerText")

    def chosen(self):
        return self.browser.run("strakeStudio.scene.chosen ? strakeStudio.scene.chosen.reduce((a, b) => a + b, 0) : 0")

    def choose_tool(self, tool):
        self.browser.choose("Choose by", tool)
        self.settled()

    def settled(self):
        """The server has answered the last choice."""
        time.sleep(0.4)
        self.browser.until("!strakeStudio.choosing.isAsking")
        self.browser.settle()

    def count(self, condition):
        """Triangles whose three vertices (in the file's coordinates: x) fulfil a condition, by the page's own arrays."""
        return self.browser.run(f"""(() => {{ const b = strakeStudio.scene.body; let n = 0;
            const holds = (v) => {{ const x = [0, 1, 2].map((c) => b.start[3 * v + c] + b.center[c]); return {condition}; }};
            for (let t = 0; t < b.count; ++t) if ([0, 1, 2].every((k) => holds(b.triangles[3 * t + k]))) ++n; return n; }})()""")

    def test_1_looks(self):
        for words in ("size x × y × z", "aspect ratio", "of half a body", "Its longest side would be"):
            self.assertIn(words, self.text("#panel-look"))
        self.assertEqual(self.browser.run("[...document.querySelectorAll('.labels span')].map((s) => s.textContent).join()"),
                         "x,y,z,stream (guess),up (guess),plane of symmetry (half a body)")
        before = self.browser.run("document.querySelector('canvas.view').toDataURL()")
        self.browser.run("document.querySelector('canvas.view').focus()")
        self.browser.key("ArrowLeft")
        self.assertNotEqual(self.browser.run("document.querySelector('canvas.view').toDataURL()"), before, "the keyboard turns it")
        self.browser.key("Home")
        left, top, width, height = self.browser.place_of("canvas.view")
        self.browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=left + width / 2, y=top + height / 2)
        self.browser.until("/patch p/.test(document.querySelector('.pointer').textContent)", 10)
        self.assertRegex(self.text(".pointer"), r"connected part 0, patch p[\d.]+ / .*triangle \d+")

    def test_2_chooses_patches_planes_boxes_and_rectangles(self):
        b = self.browser
        b.click("#tab-choose")
        b.click("canvas.view")
        self.settled()
        level = b.run("(() => { const s = strakeStudio.scene, f = s.body.facts.levels[0], l = s.body.array(f.array), p = f.patches.indexOf("
                      "strakeStudio.choosing.steps[0].patch); return l.reduce((n, q) => n + (q === p), 0); })()")
        self.assertEqual(self.chosen(), level)
        b.run("[...document.querySelectorAll('#panel-choose button')].find((x) => x.textContent === 'Complement').click()")
        self.settled()
        self.assertEqual(self.chosen(), b.run("strakeStudio.scene.body.count") - level)
        b.run("[...document.querySelectorAll('#panel-choose button')].find((x) => x.textContent === 'Clear').click()")
        self.choose_tool("plane")
        b.choose("Normal to", "1")
        b.run("(() => { const s = document.querySelector('#plane-at'); s.value = 120; s.dispatchEvent(new Event('input', { bubbles: true })); })()")
        self.settled()
        at = b.run("strakeStudio.choosing.dragged().plane.at")
        self.assertEqual(self.chosen(), self.count(f"x[1] <= {at}"))
        self.assertGreater(self.chosen(), 0)
        self.assertIn("plane: {normal: [0, 1, 0]", self.text(".found pre"))
        self.choose_tool("box")
        b.run("(() => { const s = document.querySelector('#box-y-1'); s.value = 400; s.dispatchEvent(new Event('input', { bubbles: true })); })()")
        self.settled()
        high = b.run("strakeStudio.choosing.corners[1][1]")
        self.assertEqual(self.chosen(), self.count(f"x[1] <= {high} + 1e-9"))
        self.choose_tool("rectangle")
        b.run("strakeStudio.scene.viewer.look('top')")
        b.settle()
        left, top, width, height = b.place_of("canvas.view")
        for kind, x, y in (("mousePressed", 0.02, 0.02), ("mouseMoved", 0.5, 0.5), ("mouseMoved", 0.98, 0.98), ("mouseReleased", 0.98, 0.98)):
            b.call("Input.dispatchMouseEvent", type=kind, x=left + x * width, y=top + y * height, button="left", buttons=1, clickCount=1)
        self.settled()
        facing = b.run("(() => { const b = strakeStudio.scene.body, f = b.faceNormals(b.start); let n = 0;"
                       " for (let t = 0; t < b.count; ++t) n += f[3 * t + 2] > 0; return n; })()")
        self.assertLessEqual(self.chosen(), facing, "the front side only")
        self.assertGreater(self.chosen(), 0.8 * facing)
        b.run("strakeStudio.scene.viewer.look('iso')")
        b.run("[...document.querySelectorAll('#panel-choose button')].find((x) => x.textContent === 'Clear').click()")
        self.settled()

    def drag(self, points):
        """Canvas pixels, as a user's mouse."""
        left, top = self.browser.place_of("canvas.view")[:2]
        for k, (x, y) in enumerate(points):
            kind = "mousePressed" if k == 0 else "mouseMoved"
            self.browser.call("Input.dispatchMouseEvent", type=kind, x=left + x, y=top + y, button="left", buttons=1, clickCount=1)
        self.browser.call("Input.dispatchMouseEvent", type="mouseReleased", x=left + points[-1][0], y=top + points[-1][1], button="left", clickCount=1)
        self.settled()

    def press(self, words):
        self.browser.run(f"[...document.querySelectorAll('#panel-choose button')].find((x) => x.textContent === '{words}').click()")
        self.settled()

    def projected(self):
        """Per triangle: its corners on the canvas (x, y) and towards the eye (z), by the camera and the file alone."""
        camera = self.browser.run("(() => { const v = strakeStudio.scene.viewer, b = strakeStudio.scene.body; v.camera.updateMatrixWorld(); "
                                  "return { e: v.camera.matrixWorldInverse.elements, p: v.camera.projectionMatrix.elements, w: v.width, h: v.height, c: b.center }; })()")
        data = (self.folder / "body.stl").read_bytes()
        count, found = struct.unpack_from("<I", data, 80)[0], []

        def times(m, v):  # column-major
            return [sum(m[4 * k + r] * v[k] for k in range(4)) for r in range(4)]

        for t in range(count):
            numbers, corners = struct.unpack_from("<12f", data, 84 + 50 * t), []
            for k in (1, 2, 3):
                x = [numbers[3 * k + c] - camera["c"][c] for c in range(3)] + [1.0]
                eye = times(camera["e"], x)
                clip = times(camera["p"], eye)
                corners.append(((clip[0] + 1) / 2 * camera["w"], (1 - clip[1]) / 2 * camera["h"], eye[2]))
            found.append(corners)
        return found

    @staticmethod
    def winds_around(line, x, y):
        """By the angle that the line turns around the point."""
        turn = 0.0
        for k, (ax, ay) in enumerate(line):
            bx, by = line[(k + 1) % len(line)]
            a, b = math.atan2(ay - y, ax - x), math.atan2(by - y, bx - x)
            turn += math.atan2(math.sin(b - a), math.cos(b - a))
        return abs(turn) > math.pi

    def test_2b_chooses_by_lasso(self):
        b = self.browser
        b.click("#tab-choose")
        self.press("Clear")
        b.run("strakeStudio.scene.viewer.look('iso')")
        self.choose_tool("lasso")
        width, height = b.place_of("canvas.view")[2:]
        line = [(width * (0.5 + 0.16 * math.cos(0.2 * k) * (1 + 0.3 * math.sin(0.6 * k))), height * (0.5 + 0.2 * math.sin(0.2 * k))) for k in range(31)]
        triangles = self.projected()
        middle = [[sum(c[k] for c in t) / 3 for k in range(3)] for t in triangles]
        expected = {t for t, m in enumerate(middle) if self.winds_around(line, m[0], m[1])}
        for through in (True, False):
            b.run(f"(() => {{ const t = document.querySelector('.options input[type=checkbox]'); if (t.checked !== {str(through).lower()}) t.click(); }})()")
            self.drag(line)
            chosen = set(b.run("[...strakeStudio.scene.chosen.keys()].filter((t) => strakeStudio.scene.chosen[t])"))
            if through:
                near = {t for t in chosen ^ expected}  # pixels are rounded: only what lies on the line may differ
                self.assertLess(len(near), 0.02 * len(expected) + 2)
                self.assertGreater(len(expected), 50)
            else:
                def area(t):
                    (ax, ay, _), (bx, by, _), (cx, cy, _) = triangles[t]
                    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)

                def hides(t, m):
                    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = triangles[t]
                    whole = area(t)
                    if whole == 0:
                        return False
                    u = ((bx - m[0]) * (cy - m[1]) - (by - m[1]) * (cx - m[0])) / whole
                    v = ((cx - m[0]) * (ay - m[1]) - (cy - m[1]) * (ax - m[0])) / whole
                    return min(u, v, 1 - u - v) > 0 and u * az + v * bz + (1 - u - v) * cz > m[2] + 1e-6
                seen = {t for t in expected if area(t) < 0 and not any(hides(s, middle[t]) for s in range(len(triangles)) if s != t)}
                self.assertGreater(len(seen), 20)
                self.assertLess(len(seen), len(expected))
                self.assertLess(len(chosen ^ seen), 0.06 * len(seen) + 2, "front side only")
            self.press("Clear")
            self.choose_tool("lasso")

    def test_2c_drags_planes_and_boxes_by_their_handles(self):
        b = self.browser
        self.press("Clear")
        for tool, count in (("plane", 1), ("box", 6)):
            self.choose_tool(tool)
            if tool == "plane":
                b.choose("Normal to", "1")
                self.settled()
            self.assertEqual(b.run("strakeStudio.scene.handles.length"), count)
            before = b.run("JSON.stringify(strakeStudio.choosing.dragged())")
            spot = b.run("(() => { const s = strakeStudio.scene, k = s.handles.findIndex((h) => h.words === 'plane' || h.words === 'y to'); return s.viewer.placeOf(s.handles[k].at); })()")
            step = b.run("(() => { const s = strakeStudio.scene, h = s.handles.find((h) => h.words === 'plane' || h.words === 'y to'), a = s.viewer.placeOf(h.at), "
                         "c = s.viewer.placeOf(h.at.map((v, k) => v + 0.05 * s.body.diagonal * h.along[k])); return [c[0] - a[0], c[1] - a[1]]; })()")
            sign = 1 if tool == "plane" else -1
            self.drag([spot, [spot[0] + sign * step[0], spot[1] + sign * step[1]], [spot[0] + 2 * sign * step[0], spot[1] + 2 * sign * step[1]]])
            self.assertNotEqual(b.run("JSON.stringify(strakeStudio.choosing.dragged())"), before)
            if tool == "plane":
                moved = b.run("strakeStudio.choosing.dragged().plane.at") - json.loads(before)["plane"]["at"]
                self.assertAlmostEqual(moved / (0.1 * b.run("strakeStudio.scene.body.diagonal")), 1, delta=0.1, msg="it follows the pointer")
                self.assertEqual(self.chosen(), self.count(f"x[1] <= {b.run('strakeStudio.choosing.dragged().plane.at')}"))
            else:
                self.assertEqual(self.chosen(), self.count(f"x[1] <= {b.run('strakeStudio.choosing.corners[1][1]')} + 1e-9"))
            self.press("Clear")

    def test_2d_chooses_a_spar_box_of_a_wing(self):
        b = self.browser
        self.choose_tool("wing")
        b.run("(() => { const s = document.querySelector('#wing-span-1'); s.value = 60; s.dispatchEvent(new Event('input', { bubbles: true })); })()")
        self.settled()
        self.assertEqual(b.run("strakeStudio.choosing.dragged().wing.span"), [0, 0.6])
        tip = b.run("strakeStudio.scene.body.facts.high[1]")
        reach = b.run(f"(() => {{ const s = strakeStudio.scene; let m = 0; s.chosen.forEach((c, t) => {{ if (c) for (let k = 0; k < 3; ++k) m = Math.max(m, s.body.start[3 * s.body.triangles[3 * t + k] + 1] + s.body.center[1]); }}); return m / {tip}; }})()")
        self.assertLessEqual(reach, 0.6 + 1e-6)
        self.assertGreater(reach, 0.5)
        self.assertIn("of: wing, chord: [0.15, 0.65], span: [0, 0.6]", self.text(".found pre"))
        self.press("Clear")

    def test_2e_measures_sections_lengths_and_angles(self):
        b = self.browser
        b.click("#cut")
        b.until("!!strakeStudio.section.found", 20)
        facts = json.loads(subprocess.run([STRAKE, "info", "--planform", "--json", "body.stl"], cwd=self.folder, capture_output=True, text=True, check=True).stdout)
        inside = [one for one in facts["planform"]["stations"] if one["leading_edge"][1] > 1e-6]
        self.assertTrue(inside)
        for one in inside:
            b.run(f"(() => {{ const i = strakeStudio.section.typed; i.value = {one['leading_edge'][1]!r}; i.dispatchEvent(new Event('change')); }})()")
            found = b.run("(() => { const f = strakeStudio.section.found.start; return [f.chord, f.thickness, f.radius, f.twist]; })()")
            self.assertAlmostEqual(found[0] / one["chord"], 1, delta=1e-4)
            self.assertAlmostEqual(found[1] / one["thickness_to_chord"], 1, delta=1e-3)
            if one["leading_edge_radius"] is None:
                self.assertIsNone(found[2], "the nose has too few points")
            else:
                self.assertAlmostEqual(found[2] / one["leading_edge_radius"], 1, delta=0.02)
            self.assertAlmostEqual(found[3], one["twist"], delta=1e-4)
        b.run("(() => { const i = strakeStudio.section.typed; i.value = 0.3; i.dispatchEvent(new Event('change')); })()")
        self.assertGreater(b.run("strakeStudio.section.found.start.chord") / inside[-1]["chord"], 1.2, "control: elsewhere it is another chord")
        # The four-digit section 0012 of 400 points, nose up by 3 degrees: its radius is 1.1019 t^2.
        known = b.run("""(() => { const line = [], c = Math.cos(Math.PI / 60), s = Math.sin(Math.PI / 60), n = 200;
            for (let k = 0; k < 2 * n; ++k) { const a = Math.PI * k / n, x = 0.5 * (1 + Math.cos(a)), w = Math.sqrt(x);
              const z = Math.sign(Math.sin(a)) * 0.6 * (0.2969 * w - 0.126 * x - 0.3516 * x ** 2 + 0.2843 * x ** 3 - 0.1036 * x ** 4); line.push([7 * (x * c + z * s), 7 * (z * c - x * s)]); }
            line.push(line[0]); const f = strakeStudio.section.measured([line]); return [f.chord, f.thickness, f.radius, f.twist]; })()""")
        for value, expected, miss in zip(known, (7, 0.12, 1.1019 * 0.0144, math.pi / 60), (0.01, 5e-4, 8e-4, 1e-3)):
            self.assertAlmostEqual(value, expected, delta=miss)
        self.assertIn("leading-edge radius", self.text(".section-facts"))
        b.click("#cut")
        b.click("#measure")
        b.run("strakeStudio.measure([0, 0, 0]); strakeStudio.measure([3, 4, 0]); strakeStudio.measure([3, 0, 0])")
        self.assertIn("Ruler: 5 (3, 4, 0), then 4; angle 36.87", self.text(".told"))
        b.click("#measure")

    def test_3_proposes_and_edits_a_case(self):
        b = self.browser
        b.click("#tab-case")
        b.click("#propose")
        b.until(f"{ROOT}.ready > 1", 300)
        self.assertTrue((self.folder / "case.yaml").exists())
        b.click("#tab-choose")
        self.choose_tool("plane")
        b.choose("Normal to", "1")
        self.settled()
        held = self.chosen()
        b.click("#put-region")
        self.settled()
        self.assertEqual(b.run("strakeStudio.choosing.nameInput.value"), "held2", "the next one does not replace it")
        b.click("#tab-case")
        b.until(f"{ROOT}.errors === '0'", 20)
        self.assertIn("held (fixed)", self.text(".regions"))
        self.assertIn(f"{held} triangles", self.text(".regions"))
        b.run("(() => { const t = strakeStudio.editor.area; t.value = t.value.replace('fixed:', 'fixedd:'); t.dispatchEvent(new Event('input')); })()")
        b.until(f"{ROOT}.errors === '1'", 20)
        line = 1 + b.run("strakeStudio.editor.text").split("fixedd:")[0].count("\n")
        self.assertIn(f"line {line}", self.text(".errors"))
        self.assertIn("did you mean 'fixed'", self.text(".errors"))
        b.run("(() => { const t = strakeStudio.editor.area; t.value = t.value.replace('fixedd:', 'fixed:'); t.dispatchEvent(new Event('input')); })()")
        b.until(f"{ROOT}.errors === '0'", 20)
        # The editor's own errors, keys of the schema as completions and as explanations; the policy refuses no style.
        shadow = "document.querySelector('#case-text').shadowRoot"
        self.assertTrue(b.run(f"getComputedStyle({shadow}.querySelector('.cm-gutters')).display === 'flex'"))
        editor = "strakeStudio.editor.area"
        b.until(f"{editor}.keys.length > 100", 20)
        b.run(f"(() => {{ const e = {editor}; e.value += 'optimize: {{budget: {{ev'; e.view.dispatch({{ selection: {{ anchor: e.value.length }} }}); }})()")
        offered = f"{editor}.complete({{ explicit: true, pos: {editor}.value.length, state: {editor}.view.state, matchBefore: (r) => ({{ from: {editor}.value.length - 2, to: {editor}.value.length, text: 'ev' }}) }})"
        self.assertIn("evaluations", b.run(f"{offered}.options.map((o) => o.label)"))
        b.run(f"(() => {{ const e = {editor}; e.value = e.value.replace(/optimize: .*$/, ''); }})()")
        b.until(f"{ROOT}.errors === '0'", 20)
        explained = f"(() => {{ const e = {editor}; return e.explain(e.value.search(/^fixed:/m) + 2).create().dom.textContent; }})()"
        self.assertTrue(b.run(explained).startswith("fixed ("))
        b.click("#save")
        b.until("!strakeStudio.editor.isChanged", 20)
        found = subprocess.run([STRAKE, "check", "case.yaml", "--quick"], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(found.returncode, 0, found.stderr)
        self.assertRegex(found.stdout, rf"held\s+{held} triangles")

    def test_3a_fills_in_the_form(self):
        b = self.browser
        b.until(f"{ROOT}.form > 10", 20)
        before = b.run("strakeStudio.editor.text")

        def fill(selector, value):
            b.run(f"(() => {{ const i = document.querySelector({selector!r}); i.value = {value!r}; i.dispatchEvent(new Event('change')); }})()")
            time.sleep(0.3)
            b.until(f"{ROOT}.errors === '0'", 20)
        fill("#form-optimize-budget-evaluations", "33")
        b.until("strakeStudio.editor.text.includes('evaluations: 33')", 20)
        fill("#form-objective-way", "minimize")
        b.until("strakeStudio.editor.text.includes('minimize: volume')", 20)
        self.assertNotIn("maximize: volume", b.run("strakeStudio.editor.text"))
        for _ in range(2):
            b.click("#undo")
            time.sleep(0.3)
        self.assertEqual(b.run("strakeStudio.editor.text"), before, "each change can be undone")
        b.click("#redo")
        b.until(f"{ROOT}.errors === '0' && strakeStudio.editor.text.includes('evaluations: 33')", 20)
        b.click("#undo")
        self.assertIn("The design variables", self.text(".reasons"), "what init proposes says why")
        out = b.run("(() => { const x = document.querySelector('[aria-label=\"Take out parameters.max_displacement\"]'); x.click(); return true; })()")
        self.assertTrue(out)
        b.until("!/^ *max_displacement:/m.test(strakeStudio.editor.text)", 20)
        b.click("#undo")
        self.assertEqual(b.run("strakeStudio.editor.text"), before)
        b.run("(() => { const i = document.querySelector('#form-parameters-max_displacement'); i.value = '-5%'; i.dispatchEvent(new Event('change')); })()")
        b.until(f"{ROOT}.errors === '1'", 20)
        b.until("!!document.querySelector('.row.wrong .wrong-words')", 20)
        self.assertIn("max_displacement", self.text(".row.wrong .wrong-words"), "the error of check stands at its row")
        b.click("#undo")
        b.until(f"{ROOT}.errors === '0'", 20)

    def test_3b_feels_what_variables_do(self):
        b = self.browser
        b.click("#tab-feel")
        b.until(f"{ROOT}.felt === 'ok 0'", 100)
        b.run("(() => { const i = document.querySelector('.slider input'); i.value = 0.5 * i.max; i.dispatchEvent(new Event('input')); })()")
        b.until(f"{ROOT}.felt === 'ok 1'", 100)
        self.assertIn("A valid shape", self.text("#panel-feel"))
        self.assertRegex(self.text("#panel-feel"), r"volume\s+[\d.]+\s+[\d.]+\s+[+\u2212]")
        self.assertTrue(b.run("strakeStudio.scene.model.p !== strakeStudio.scene.body.start"))
        b.until(f"{ROOT}.fetched > 0", 60)
        b.run("(() => { strakeStudio.feel.start = null; strakeStudio.feel.ask(); })()")  # as where it was moved before the start was answered
        b.until(f"{ROOT}.felt === 'ok 1' && !!strakeStudio.feel.start", 60)
        self.assertTrue(b.run("strakeStudio.scene.model.p === strakeStudio.feel.last && strakeStudio.feel.exactX[0] === strakeStudio.feel.x[0]"), "the values of the start come without its shape")
        moved = b.run("""(async () => { const real = window.fetch, before = strakeStudio.feel.last[0]; let got = 0;
            window.fetch = async (path, more) => { const answer = await real(path, more);
                if (String(path).startsWith('api/felt/shape')) { const p = new Float32Array(await answer.arrayBuffer()); if (got++ > 0) p[0] += 1; return new Response(p); }
                if (path !== 'api/felt_state') return answer;
                const state = await answer.json(); if (got === 0) state.done = 0; else state.shapes += 1000; return Response.json(state); };
            await strakeStudio.feel.ask(); window.fetch = real; const found = strakeStudio.scene.model.p[0] - before; await strakeStudio.feel.ask(); return found; })()""")
        self.assertAlmostEqual(moved, 1, delta=1e-3, msg="where the first shape is refused and a second one is valid, that one is shown")
        time.sleep(1.6)  # moves of one slider within a moment are one change
        b.run("(() => { const i = document.querySelector('.slider input'); i.value = 0.3 * i.max; i.dispatchEvent(new Event('input')); })()")
        self.assertTrue(b.run("strakeStudio.scene.model.p === strakeStudio.feel.buffer"), "to first order, before the exact shape is there")
        miss = b.run("""(async () => { const p = strakeStudio.scene.model.p.slice(), s = strakeStudio.scene.body.start;
            while (document.documentElement.dataset.felt !== 'ok 1') await new Promise((done) => setTimeout(done, 20));
            const q = strakeStudio.scene.model.p; let off = 0, size = 0;
            for (let k = 0; k < p.length; ++k) { off = Math.max(off, Math.abs(p[k] - q[k])); size = Math.max(size, Math.abs(q[k] - s[k])); } return off / size; })()""")
        self.assertLess(miss, 0.25, "near the exact one")
        b.choose("Colours", "slope")
        b.until("!!strakeStudio.scene.field && !!strakeStudio.feel.rates", 60)
        self.assertIn("volume", self.text(".legend"))
        self.assertTrue(b.run("strakeStudio.scene.field.values.every(Number.isFinite)"))
        b.choose("Colours", "patches")
        b.until("!strakeStudio.feel.envelopeTick.querySelector('input').disabled", 60)
        b.run("strakeStudio.feel.envelopeTick.querySelector('input').click()")
        b.until("(strakeStudio.scene.shells || []).length === 2", 20)
        b.run("strakeStudio.feel.envelopeTick.querySelector('input').click()")
        b.click("#undo")
        b.until(f"{ROOT}.felt === 'ok 1'", 100)
        self.assertAlmostEqual(b.run("strakeStudio.feel.x[0] / strakeStudio.feel.list[0].upper"), 0.5, delta=0.01, msg="undo takes the slider back")
        b.click("#feel-start")
        b.until(f"{ROOT}.felt === 'ok 0'", 100)
        self.assertLess(b.run("strakeStudio.scene.model.p.reduce((m, v, k) => Math.max(m, Math.abs(v - strakeStudio.scene.body.start[k])), 0)"), 1e-6)
        b.click("#tab-look")
        self.assertTrue(b.run("strakeStudio.scene.model.p === strakeStudio.scene.body.start"))

    def test_4_runs_and_watches(self):
        b = self.browser
        b.click("#tab-run")
        b.run("strakeStudio.runs.evaluations.value = 5")
        b.click("#start")
        b.until(f"{ROOT}.rows > 0", 100)
        b.until(f"{ROOT}.run && !['running', 'starting'].includes({ROOT}.run)", 300)
        b.until(f"{ROOT}.rows === '5'", 20)
        b.until("!!document.querySelector('#report-link')", 20)
        self.assertIn("5 of 5 evaluations", self.text("#panel-run"))
        b.until("strakeStudio.scene.model.p !== strakeStudio.scene.body.start", 20)
        run = next((self.folder / "runs").iterdir())
        shell = subprocess.run([STRAKE, "run", "case.yaml", "--set", "optimize.budget.evaluations=5", "--out", "again", "-q"],
                               cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(shell.returncode, 0, shell.stderr)
        self.assertEqual((run / "best.stl").read_bytes(), (self.folder / "again/best.stl").read_bytes(), "the same bits as from the shell")

    def test_4b_compares_two_designs(self):
        b = self.browser
        b.run("document.querySelector('#compare').open = true")
        b.until(f"!!{ROOT}.compared", 30)
        self.assertTrue(b.run("strakeStudio.scene.viewer.both"))
        off = b.run("(() => { const s = strakeStudio.scene; let m = 0; for (let k = 0; k < s.model.p.length; ++k) m = Math.max(m, Math.abs(s.model.p[k] - s.viewer.start.p[k])); return m; })()")
        self.assertGreater(off, 1e-5)
        self.assertLessEqual(b.run("strakeStudio.scene.field.values.reduce((m, v) => Math.max(m, Math.abs(v)), 0)"), 2 * off)
        b.run("document.querySelector('#compare').open = false")
        b.until("!strakeStudio.scene.viewer.both", 20)

    def test_5_finds_its_way_back(self):
        b = self.browser
        before = self.url
        b.run("(() => { const t = strakeStudio.editor.area; t.value += '# typed meanwhile\\n'; t.dispatchEvent(new Event('input')); })()")
        self.studio.kill()
        self.studio.communicate()
        b.until("strakeStudio.isLost", 20)
        self.assertIn("does not answer", self.text(".told"))
        # The first answer after it comes while the surface is still being read, as on a slow machine.
        b.run("(() => { const ask = window.fetch; window.fetch = async (path, how) => { const answer = await ask(path, how); "
              "if (!String(path).startsWith('api/state') || window.wasReading) return answer; window.wasReading = true; "
              "return new Response(JSON.stringify({ ...await answer.json(), is_opening: true, case: '' }), { headers: answer.headers }); }; })()")
        type(self).start()
        self.assertEqual(self.url, before, "the same address, and the page that is open goes on")
        b.until("window.wasReading && !strakeStudio.isLost", 20)
        b.until("strakeStudio.editor.name === 'case.yaml' && !!strakeStudio.scene", 60)
        time.sleep(1)
        self.assertIn("# typed meanwhile", b.run("strakeStudio.editor.text"))
        b.click("#undo")
        self.assertNotIn("# typed meanwhile", b.run("strakeStudio.editor.text"))

    def test_6_is_usable_on_a_narrow_screen_and_named_for_readers(self):
        b = self.browser
        b.resize(390, 800)
        b.settle()
        self.assertLessEqual(b.run("document.documentElement.scrollWidth"), 390)
        for tab in ("look", "choose", "case", "feel", "run"):
            b.click(f"#tab-{tab}")
            self.assertLessEqual(b.run("document.documentElement.scrollWidth"), 390, tab)
            nameless = b.run(f"""[...document.querySelectorAll('#panel-{tab} :is(input, select, textarea, button), .left :is(select, button, canvas)')]
                .filter((e) => !(e.textContent.trim() && e.tagName === 'BUTTON') && !e.getAttribute('aria-label') && !(e.labels && e.labels.length)).map((e) => e.outerHTML)""")
            self.assertEqual(nameless, [], tab)
        b.resize(1280, 860)

    def test_7_nothing_went_wrong_and_nothing_came_from_elsewhere(self):
        # The server was stopped and begun again while the page asked.
        ended = ("ERR_CONNECTION", "ERR_EMPTY_RESPONSE", "Failed to fetch")
        gone = [e for e in self.browser.errors if not any(word in e for word in ended)]
        self.assertEqual(gone, [])
        self.assertEqual([u for u in self.browser.requests if not u.startswith("http://127.0.0.1:")], [])


if __name__ == "__main__":
    if not find_chromium():
        print("skipped: there is no chromium")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as empty:  # it has no surface, so this studio ends at once
        probe = subprocess.run([STRAKE, "studio", "no.stl", "--no-browser"], cwd=empty, capture_output=True, text=True, timeout=20, check=False)
    if "built without" in probe.stderr:
        print("skipped: built without the page")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
