#!/usr/bin/env python3
"""The report in a real browser: browser_test.py STRAKE MAKE_SURFACE. Exit status 77: skipped, with the reason."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from browser import Browser, find_chromium  # noqa: E402

STRAKE, MAKE_SURFACE = sys.argv[1:3]

# Volume by a program that fails for every design beyond a limit, and says things that are no text to a page.
SOLVER = r"""
import json, sys
v, t = [], []
for line in open(sys.argv[1]):
    f = line.split()
    if f and f[0] == "v": v.append([float(x) for x in f[1:4]])
    if f and f[0] == "f": t.append([int(w.split("/")[0]) - 1 for w in f[1:4]])
cross = lambda p, q: (p[1]*q[2]-p[2]*q[1], p[2]*q[0]-p[0]*q[2], p[0]*q[1]-p[1]*q[0])
volume = sum(sum(x * y for x, y in zip(v[a], cross(v[b], v[c]))) for a, b, c in t) / 6
print("</script><script>window.broken = 1</script><!-- residual 1e-7")
if volume > float(sys.argv[3]):
    sys.exit("mesher: <b>negative</b> cell & \x1b[31mmore\x1b[0m")
g = [[0.0] * 3 for _ in v]
for s in t:
    for k in range(3):
        n = cross(v[s[(k + 1) % 3]], v[s[(k + 2) % 3]])
        for c in range(3): g[s[k]][c] += n[c] / 6
open("g.csv", "w").write("".join("%d,%r,%r,%r\n" % (i, *r) for i, r in enumerate(g)))
json.dump({"value": volume, "gradient": "g.csv", "variables": {"value": {"alpha": 0.0}}}, open(sys.argv[2], "w"))
"""
CASE = """
case: bodies
surface: {file: "<img src=x onerror=alert(1)>.obj", units: m}
regions: {root: {box: [[-9, -9, -9], [0.8, 9, 9]]}}
fixed: [root]
parameters: {levels: auto, patches_per_level: [3, 8], variables: [normal], max_displacement: 4%}
variables: {alpha: {start: 2deg, min: 0deg, max: 6deg}}
quantities:
  bulk: {command: [python3, -S, -E, "{case_dir}/solver.py", "{surface}", "{result}", "LIMIT"], format: obj,
         on_failure: shrink_step}
objective: {maximize: bulk}
constraints: {area: {max: 1.03, relative: true}}
optimize: {budget: {evaluations: 12}}
output: {report: true}
"""


def canvas(browser):
    """The picture at rest: where drawing is slow, edges are rough while something moves."""
    browser.settle()
    browser.until("document.querySelector('canvas.view').dataset.edges === 'smooth'")
    return browser.run("document.querySelector('canvas.view').toDataURL()")


WING = """
case: wing
surface: {file: wing.obj, units: m}
symmetry: {plane: y, at: 0}
planform: {wing: {span: y, stations: [0, 0.5, 1]}}
shell: none
parameters:
  planform: {wing.sweep: {by: station, range: [-5deg, 5deg]}, wing.thickness: {by: station, range: [-5%, 5%]}}
objective: {maximize: volume}
constraints: {area: {max: 1.001, relative: true}, wing.sweep@0.5: {min: 31deg}}
optimize: {budget: {evaluations: 8}}
"""


class WingPage(unittest.TestCase):
    def test_sheet_charts_and_airfoils(self):
        with tempfile.TemporaryDirectory() as folder, Browser(1100, 800) as b:
            here = pathlib.Path(folder)
            subprocess.run([MAKE_SURFACE, "wing", "--triangles", "3000", "-o", here / "wing.obj"], check=True,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            (here / "wing.yaml").write_text(WING)
            subprocess.run([STRAKE, "run", here / "wing.yaml", "--out", here / "run", "-q"], check=True, capture_output=True)
            b.open(here / "run/report.html")
            self.assertEqual(b.until("document.documentElement.dataset.ready"), "shapes")
            b.settle()
            self.assertEqual(b.errors, [])
            words = b.run("document.querySelector('#wings').innerText")
            for bad in ("NaN", "undefined", "null", "Infinity", "[object"):
                self.assertNotIn(bad, words)
            self.assertNotRegex(words, "\u22120\\.?0*(?![\\d.])")  # no sign of a zero
            for good in ("aspect ratio", "By station", "By panel", "0.5 – 1", "t/c, %", "50 % of the semispan"):
                self.assertIn(good, words)
            self.assertEqual(b.run("document.querySelectorAll('#wings .chart canvas').length"), 5)
            self.assertEqual(b.run("document.querySelectorAll('#wings svg.airfoil .start').length"), 3)
            self.assertEqual(b.run("document.querySelectorAll('#wings svg.airfoil .design').length"), 3)
            self.assertEqual(b.run("document.querySelectorAll('nav a[href=\"#wings\"]').length"), 1)
            b.resize(390, 844)
            b.settle()
            self.assertLessEqual(b.run("document.documentElement.scrollWidth"), 390)


BODY = """
case: hull
surface: {file: hull.obj, units: m}
planform: {hull: {length: x, stations: [0.1, 0.5, 0.9]}}
hold: none
shell: none
parameters: {planform: {hull.width: {by: station, range: [-5%, 5%]}, hull.camber: {by: station, range: [-2%, 2%]}}}
objective: {minimize: area}
output: {report: true}
optimize: {budget: {evaluations: 4}}
"""


class BodyPage(unittest.TestCase):
    def test_sheet_charts_and_sections(self):
        with tempfile.TemporaryDirectory() as folder, Browser(1100, 800) as b:
            here = pathlib.Path(folder)
            subprocess.run([MAKE_SURFACE, "lifting_body", "--triangles", "1500", "-o", here / "hull.obj"], check=True,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            (here / "hull.yaml").write_text(BODY)
            subprocess.run([STRAKE, "run", here / "hull.yaml", "--out", here / "run", "-q"], check=True, capture_output=True)
            b.open(here / "run/report.html")
            self.assertEqual(b.until("document.documentElement.dataset.ready"), "shapes")
            b.settle()
            self.assertEqual(b.errors, [])
            words = b.run("document.querySelector('#bodies').innerText")
            for bad in ("NaN", "undefined", "null", "Infinity", "[object"):
                self.assertNotIn(bad, words)
            for good in ("Body", "length, m", "By station", "camber, % of the length", "50 % of the length", "→"):
                self.assertIn(good, words)
            self.assertEqual(b.run("document.querySelectorAll('#bodies .chart canvas').length"), 3)
            self.assertEqual(b.run("document.querySelectorAll('#bodies svg.airfoil .start').length"), 3)
            self.assertEqual(b.run("document.querySelectorAll('#bodies svg.airfoil .design').length"), 3)
            self.assertEqual(b.run("document.querySelectorAll('nav a[href=\"#bodies\"]').length"), 1)
            self.assertIsNone(b.run("document.querySelector('#wings')"))


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        here = pathlib.Path(cls.folder.name)
        surface = here / "body.obj"
        subprocess.run([MAKE_SURFACE, "lifting_body", "--triangles", "1500", "-o", surface], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        volume = float(next(line.split()[1] for line in subprocess.run(
            [STRAKE, "info", surface], check=True, capture_output=True, text=True).stdout.splitlines()
            if line.startswith("volume")))
        surface.rename(here / "<img src=x onerror=alert(1)>.obj")
        (here / "solver.py").write_text(SOLVER)
        (here / "case.yaml").write_text(CASE.replace("LIMIT", str(1.004 * volume)))
        ended = subprocess.run([STRAKE, "run", here / "case.yaml", "--out", here / "run", "-q"], capture_output=True,
                               text=True, check=False)
        cls.page = here / "run/report.html"
        assert cls.page.exists(), ended.stderr
        cls.browser = Browser(1100, 800)
        cls.browser.open(cls.page)
        cls.ready = cls.browser.until("document.documentElement.dataset.ready")

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()
        cls.folder.cleanup()

    def text(self, selector):
        return self.browser.run(f"document.querySelector({selector!r}).innerText")

    def test_0_loads_without_a_word(self):
        b = self.browser
        self.assertEqual(self.ready, "shapes")
        b.settle()
        self.assertEqual(b.errors, [])
        self.assertEqual(b.requests, [])
        self.assertIsNone(b.run("window.broken"))
        self.assertEqual(b.run("document.querySelectorAll('main img:not(.pictures > figure > img), main script').length"), 0)
        words = self.text("main")
        for bad in ("NaN", "undefined", "null", "Infinity", "[object"):
            self.assertNotIn(bad, words)
        for good in ("maximize bulk", "Why it stopped", "What to try next", "onerror=alert(1)", "alpha"):
            self.assertIn(good, words)

    def test_0_shares_of_the_gain_add_up_where_a_level_goes_back(self):
        with tempfile.TemporaryDirectory() as folder, Browser(1100, 800) as b:
            run = pathlib.Path(folder) / "run"
            shutil.copytree(self.page.parent, run)
            record = json.loads((run / "run.json").read_text())
            levels = record["levels"]
            self.assertGreater(len(levels), 1)
            levels[-1]["objective_start"] = levels[0]["objective_start"]
            (run / "run.json").write_text(json.dumps(record))
            subprocess.run([STRAKE, "report", run], check=True, capture_output=True)
            b.open(run / "report.html")
            b.until("document.documentElement.dataset.ready")
            shares = b.run("""(() => { const t = [...document.querySelectorAll('#summary table')].find((t) => t.caption.textContent.startsWith('Levels'));
                const k = [...t.querySelectorAll('thead th')].findIndex((c) => c.textContent === 'share of the gain');
                return [...t.querySelectorAll('tbody tr')].map((r) => parseFloat(r.children[k].textContent.replace('\u2212', '-'))); })()""")
            self.assertEqual(len(shares), len(levels))
            self.assertAlmostEqual(sum(shares), 100, delta=0.5)  # three digits each

    def test_0_the_first_screen_shows_the_shape(self):
        b = self.browser
        self.assertEqual(b.run("[...document.querySelectorAll('.pictures img')].map((i) => i.naturalWidth > 300)"), [True, True])
        self.assertIn("at most", self.text(".pictures"))
        in_sight = """(() => { scrollTo(0, 0); return [...document.querySelectorAll('.pictures img')].map((i) => i.getBoundingClientRect())
            .filter((r) => r.width > 0).map((r) => r.top >= 0 && r.bottom <= innerHeight && r.right <= innerWidth); })()"""
        self.assertEqual(b.run(in_sight), [True, True])
        self.addCleanup(b.resize, 1100, 800)
        b.resize(390, 844)
        b.settle()
        self.assertEqual(b.run(in_sight), [True])  # a telephone: the design alone
        b.resize(1100, 800)
        b.settle()

    def test_0_no_table_is_cut_on_a_telephone(self):
        b = self.browser
        self.addCleanup(b.resize, 1100, 800)
        b.resize(390, 844)
        b.run("document.querySelector('#evaluations details').open = true")
        b.settle()
        wide = b.run("""[...document.querySelectorAll('main .scroll > table:not(.tree)')].filter((t) => t.getBoundingClientRect().right > innerWidth
            || t.closest('.scroll').scrollWidth > t.closest('.scroll').clientWidth).map((t) => t.caption.textContent)""")
        self.assertEqual(wide, [])
        self.assertLessEqual(b.run("document.documentElement.scrollWidth"), 390)
        heading = b.run("getComputedStyle(document.querySelector('table.stacks tbody td'), '::before').content")
        self.assertNotIn(heading, ("none", "normal"))
        b.run("document.querySelector('#evaluations details').open = false")
        b.resize(1100, 800)
        b.settle()

    def test_1_charts_and_variables(self):
        b = self.browser
        self.assertGreaterEqual(b.run("document.querySelectorAll('.u-wrap canvas').length"), 3)
        drawn = b.run("""[...document.querySelectorAll('.u-wrap canvas')].every((c) =>
            c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((v) => v > 0))""")
        self.assertTrue(drawn)
        self.assertGreaterEqual(b.run("document.querySelectorAll('canvas.heat').length"), 1)

    def test_2_designs_step_by_step(self):
        b = self.browser
        first = canvas(b)
        told = self.text("output.told")
        b.click("#shapes .controls:has(#design) button")  # "Before"
        self.assertNotEqual(self.text("output.told"), told)
        self.assertNotEqual(canvas(b), first)
        b.run("document.querySelector('#design').focus()")
        b.key("ArrowRight")
        self.assertEqual(self.text("output.told"), told)
        self.assertEqual(canvas(b), first)

    def test_3_colours(self):
        b = self.browser
        seen = set()
        choices = b.run("[...document.querySelector('#shapes select').options].map((o) => o.value)")
        self.assertIn("field:sensitivity", choices)
        self.assertIn("patches:1", choices)
        for value in choices:
            b.choose("Colour", value)
            seen.add(canvas(b))
        self.assertEqual(len(seen), len(choices))
        b.choose("Colour", "outward")

    def test_4_sections(self):
        b = self.browser
        drawn = "document.querySelector('.section-plot .design').getAttribute('d')"
        before, view = b.run(drawn), canvas(b)
        self.assertGreater(len(before), 100)
        b.run("document.querySelector('#section-at').focus()")
        for _ in range(3):
            b.key("ArrowRight")
        self.assertNotEqual(b.run(drawn), before)
        b.click("label.tick:last-of-type input")
        self.assertNotEqual(canvas(b), view)
        b.click("label.tick:last-of-type input")
        b.choose("Plane normal to", "0")
        self.assertNotEqual(b.run("document.querySelector('.section-plot').getAttribute('viewBox')"), "")
        b.choose("Plane normal to", "1")

    def test_5_another_axis_may_be_up(self):
        b = self.browser
        b.run("document.querySelector('canvas.view').focus()")
        b.key("Home")
        before = canvas(b)
        was = b.run("[...document.querySelectorAll('#shapes label')].find((l) => l.textContent.startsWith('Up')).querySelector('select').value")
        seen = set()
        for axis in "012":
            b.choose("Up", axis)
            seen.add(canvas(b))
            b.run("document.querySelector('canvas.view').focus()")
            b.key("ArrowLeft")
            seen.add(canvas(b))
        self.assertEqual(len(seen), 6)
        b.choose("Up", was)
        self.assertEqual(canvas(b), before)

    def test_5_view_by_keyboard_and_pick(self):
        b = self.browser
        before = canvas(b)
        b.run("document.querySelector('canvas.view').focus()")
        b.key("ArrowLeft")
        self.assertNotEqual(canvas(b), before)
        b.key("Home")
        self.assertEqual(canvas(b), before)
        b.click("canvas.view", 0.25, 0.5)
        self.assertRegex(self.text(".picked"), r"^Patch p\d")
        b.click("canvas.view", 0.02, 0.98)
        self.assertEqual(self.text(".picked"), "No patch there.")

    def test_6_tree(self):
        b = self.browser
        view = canvas(b)
        b.click("#patches button.patch")
        self.assertEqual(b.run("document.querySelector('#patches button.patch').getAttribute('aria-pressed')"), "true")
        self.assertNotEqual(canvas(b), view)
        b.key("ArrowDown")
        self.assertTrue(b.run("document.activeElement === document.querySelectorAll('#patches button.patch')[1]"))
        b.key("ArrowUp")
        b.key("Enter")
        self.assertEqual(canvas(b), view)
        count = "document.querySelectorAll('#patches tbody tr').length"
        b.click("#patches .controls button")  # "Open all"
        rows = b.run(count)
        b.click("#patches button.opener[aria-expanded=true]")
        self.assertLess(b.run(count), rows)
        shares = b.run("strakeReport.run.shapes.explained / strakeReport.run.shapes.change")
        self.assertAlmostEqual(shares, 1, delta=0.1)

    def test_7_failures(self):
        b = self.browser
        count = b.run("strakeReport.run.failures.count")
        self.assertGreater(count, 0)
        self.assertEqual(b.run("document.querySelectorAll('details.failure').length"), count)
        b.run("document.querySelectorAll('details.failure').forEach((d) => { d.open = true; })")
        words = self.text("#failures")
        self.assertIn("</script><script>window.broken = 1</script><!-- residual 1e-7", words)
        self.assertIn("<b>negative</b> cell & \\x1B[31mmore", words)

    def test_8_all_controls_by_tab(self):
        b = self.browser
        b.run("document.activeElement.blur()")
        seen = []
        for _ in range(70):
            b.call("Input.dispatchKeyEvent", type="keyDown", key="Tab", code="Tab", windowsVirtualKeyCode=9)
            b.call("Input.dispatchKeyEvent", type="keyUp", key="Tab", code="Tab", windowsVirtualKeyCode=9)
            seen.append(b.run("document.activeElement.tagName + (document.activeElement.className || document.activeElement.id)"))
        for wanted in ("A", "SELECT", "CANVASview", "INPUTdesign", "INPUTsection-at", "BUTTON", "BUTTONpatch"):
            self.assertIn(wanted, seen)

    def test_9_narrow_and_printed(self):
        b = self.browser
        for width in (480, 360):
            b.resize(width, 800)
            b.settle()
            self.assertLessEqual(b.run("document.documentElement.scrollWidth"), width)
        for width, scale in ((390, 1.1), (1001, 1.25)):  # pixels are no whole numbers of the page's
            b.resize(width, 844, scale)
            b.settle()
            dark = b.run("""(() => { const view = document.querySelector('canvas.view'), { width, height } = view, copy = document.createElement('canvas');
                Object.assign(copy, { width, height }); const g = copy.getContext('2d', { willReadFrequently: true }); g.drawImage(view, 0, 0);
                return [[0, 0, width, 1], [0, height - 1, width, 1], [0, 0, 1, height], [width - 1, 0, 1, height]].map((side) => g.getImageData(...side).data.filter((v) => v < 128).length); })()""")
            self.assertEqual(dark, [0, 0, 0, 0], "the panes reach the edges of the view")
        b.resize(1100, 800)
        printed = b.call("Page.printToPDF", printBackground=True)["data"]
        self.assertGreater(len(printed), 40000)
        self.assertEqual(b.errors, [])
        self.assertEqual(b.requests, [])


if __name__ == "__main__":
    if not find_chromium():
        print("skipped: there is no chromium (scripts/setup.sh test installs it)")
        sys.exit(77)
    missing = subprocess.run([STRAKE, "report", os.devnull], capture_output=True, text=True, check=False).stderr
    if "built without the report page" in missing:
        print("skipped: this build has no page (node and npm were missing)")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
