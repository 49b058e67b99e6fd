#!/usr/bin/env python3
"""The studio in a real browser: browser_test.py STRAKE MAKE_SURFACE. Exit status 77: skipped, with the reason."""
import pathlib
import signal
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
        cls.folder = pathlib.Path(cls.around.name)
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
        b.click("#save")
        b.until("!strakeStudio.editor.isChanged", 20)
        found = subprocess.run([STRAKE, "check", "case.yaml", "--quick"], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(found.returncode, 0, found.stderr)
        self.assertRegex(found.stdout, rf"held\s+{held} triangles")

    def test_3b_feels_what_variables_do(self):
        b = self.browser
        b.click("#tab-feel")
        b.until(f"{ROOT}.felt === 'ok 0'", 100)
        b.run("(() => { const i = document.querySelector('.slider input'); i.value = 0.5 * i.max; i.dispatchEvent(new Event('input')); })()")
        b.until(f"{ROOT}.felt === 'ok 1'", 100)
        self.assertIn("A valid shape", self.text("#panel-feel"))
        self.assertRegex(self.text("#panel-feel"), r"volume\s+[\d.]+\s+[\d.]+\s+[+\u2212]")
        self.assertTrue(b.run("strakeStudio.scene.model.p !== strakeStudio.scene.body.start"))
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

    def test_5_finds_its_way_back(self):
        b = self.browser
        port, token = self.url.split(":")[2].split("/")[:2]
        self.studio.kill()
        self.studio.communicate()
        b.until("strakeStudio.isLost", 20)
        self.assertIn("does not answer", self.text(".told"))
        type(self).start("--port", port)
        self.assertNotIn(token, self.url, "another start, another token")
        b.open(self.url)
        b.until(f"{ROOT}.ready > 0", 60)

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
        gone = [e for e in self.browser.errors if "ERR_CONNECTION" not in e and "Failed to fetch" not in e]
        self.assertEqual(gone, [])
        self.assertEqual([u for u in self.browser.requests if not u.startswith("http://127.0.0.1:")], [])


if __name__ == "__main__":
    if not find_chromium():
        print("skipped: there is no chromium")
        sys.exit(77)
    if "built without" in subprocess.run([STRAKE, "studio", "/nowhere", "--no-browser"], capture_output=True, text=True, check=False).stderr:
        print("skipped: built without the page")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
