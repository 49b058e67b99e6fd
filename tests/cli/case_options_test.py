"""Keys set on the command line in every command that reads a case, the names of the option for the output, the axes that
`check` draws, and the page at the end of a run. Arguments: the programs strake and make_surface."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

STRAKE, MAKE_SURFACE = (str(pathlib.Path(p).resolve()) for p in sys.argv[1:3])
VOLUME = pathlib.Path(__file__).resolve().parents[2] / "cases/external/volume.py"
CASE = """case: body
surface: {file: body.obj}
regions: {root: {box: [[-9, -9, -9], [0.8, 9, 9]]}, tail: {box: [[5, -9, -9], [99, 9, 9]]}}
fixed: [root]
parameters: {levels: auto, patches_per_level: [2], variables: [normal], max_displacement: 2%}
quantities: {match: {type: target_shape, file: body.obj}}
objective: {maximize: volume}
optimize: {budget: {evaluations: 3}}
"""
FIT = "optimize={budget: {evaluations: 2}}"


def strake(*arguments, status=0):
    done = subprocess.run([STRAKE, *arguments], cwd=FOLDER.name, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=300, check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stdout, done.stderr)
    return done


def path(name):
    return pathlib.Path(FOLDER.name) / name


def setUpModule():
    global FOLDER
    FOLDER = tempfile.TemporaryDirectory()
    for shape, name in (("lifting_body", "body.obj"), ("wing", "wing.obj")):
        subprocess.run([MAKE_SURFACE, shape, "--triangles", "1500", "-o", name], cwd=FOLDER.name, check=True,
                       stdout=subprocess.DEVNULL)
    path("case.yaml").write_text(CASE)
    path("fit.yaml").write_text(CASE.replace("objective: {maximize: volume}", "fit: [match]"))


def tearDownModule():
    FOLDER.cleanup()


class Settings(unittest.TestCase):
    def test_a_run_its_folder_and_its_continuation(self):
        strake("run", "case.yaml", "--out", "r", "-q", "--set", "optimize.budget.evaluations=2", "--set", "shell.thickness=5%")
        written = path("r/case.yaml").read_text()
        self.assertIn("budget: {evaluations: 2", written)
        self.assertIn("thickness: 5%", written)
        self.assertEqual(json.loads(strake("status", "r", "--json").stdout)["evaluations"], 2)
        again = json.loads(strake("resume", "r", "--evaluations", "3", "--json", "-q").stdout)
        self.assertEqual(again["evaluations"], 3)
        # The same bits as a file that says so.
        path("said.yaml").write_text(CASE.replace("evaluations: 3", "evaluations: 2") + "shell: {thickness: 5%}\n")
        strake("run", "said.yaml", "--out", "s", "-q")
        strake("run", "case.yaml", "--out", "t", "-q", "--set", "optimize.budget.evaluations=2", "--set", "shell.thickness=5%")
        self.assertEqual(path("s/best.obj").read_bytes(), path("t/best.obj").read_bytes())

    def test_every_command_that_reads_a_case(self):
        commands = {"run": ["case.yaml", "--out", "x"], "check": ["case.yaml"], "fit": ["fit.yaml", "--out", "x"],
                    "sweep": ["case.yaml", "--variable", "p1.normal", "--from", "0", "--to", "1", "--steps", "2"],
                    "deform": ["case.yaml", "-o", "x.obj"], "gradient-check": ["case.yaml"], "step": ["case.yaml", "--out", "x"]}
        for command, arguments in commands.items():
            done = strake(command, *arguments, "--set", "shell.thickness=-1", status=2)
            self.assertIn("--set shell.thickness=-1: shell.thickness = -1 must be > 0", done.stderr, command)
        self.assertFalse(path("x").exists())
        self.assertIn("at most 7 evaluations", strake("check", "case.yaml", "--set", "optimize.budget.evaluations=7").stdout)
        strake("fit", "fit.yaml", "--out", "f", "-q", "--set", FIT)
        self.assertIn("evaluations: 2", path("f/case.yaml").read_text())
        table = strake("sweep", "case.yaml", *commands["sweep"][1:], "--set", "parameters.variables=[load]", status=2).stderr
        self.assertIn("p1.load", table)  # the names that there are

    def test_check_tells_what_is_chosen_by_default(self):
        def told(*settings):
            return strake("check", "case.yaml", "--set", "parameters={max_displacement: 2%}", *settings).stdout
        free = told()
        self.assertIn("level 0     27 displacement fields, then those of 192 that the gradient asks for\n", free)
        self.assertIn("by default  fields: auto, split: sensitivity: the case says nothing of its variables", free)
        limited = told("--set", "constraints={area: {max: 1.01, relative: true}}")
        self.assertIn("level 0     27 displacement fields, up to 192 on later ones\n", limited)
        self.assertIn("by default  fields: auto: the case", limited)
        by_values = told("--set", "quantities={flow: {command: [cat], outputs: [drag], gradients: false}}", "--set", "objective={minimize: flow.drag}")
        self.assertIn("by default  fields: auto, variables: [normal]: the case", by_values)
        self.assertNotIn("by default", told("--set", "parameters.fields=auto"))
        self.assertNotIn("by default", strake("check", "case.yaml").stdout)

    def test_errors_in_json(self):
        told = json.loads(strake("check", "case.yaml", "--json", "--set", "fixed=[rot]", status=2).stdout)
        self.assertEqual(told["errors"][0]["setting"], "--set fixed=[rot]")
        self.assertIn("did you mean 'root'?", told["errors"][0]["message"])

    def test_a_file_is_relative_to_the_case(self):
        path("deep").mkdir(exist_ok=True)
        path("deep/case.yaml").write_text(CASE.replace("body.obj", "../body.obj"))
        strake("check", "deep/case.yaml", "--quick", "--set", "surface.file=../body.obj")
        self.assertIn("does not exist", strake("check", "deep/case.yaml", "--set", "surface.file=body.obj", status=2).stderr)


class Output(unittest.TestCase):
    WORDS = ("-o", "--out", "--output")

    def expect_output(self, file, *arguments):
        """Whatever the option is called, the command writes `file` into the folder."""
        for word in self.WORDS:
            folder = f"{arguments[0]}{word}"
            strake(*arguments, word, folder)
            self.assertTrue(path(folder).joinpath(file).exists(), (arguments, word))

    def test_run_folders(self):
        self.expect_output("samples.csv", "sample", "case.yaml", "-n", "2", "-q")
        self.expect_output("run.json", "step", "case.yaml", "-q", "--set", "optimize.budget.evaluations=2")
        self.expect_output("run.json", "fit", "fit.yaml", "-q", "--set", FIT)

    def test_folders_of_evaluations(self):
        program = ["case.yaml", "--set", 'quantities={bulk: {command: ["%s", "{request}", "{result}"]}}' % VOLUME,
                   "--set", "objective={maximize: bulk}"]
        self.expect_output("evaluations/000001/result.json", "check", *program, "--evaluate")
        self.expect_output("evaluations/000001/result.json", "gradient-check", *program, "-q")

    def test_check_has_none_without_an_evaluation(self):
        for word in self.WORDS:
            told = strake("check", "case.yaml", word, "unasked", status=2).stderr
            self.assertIn("strake: check: --out requires --evaluate\n", told)
        self.assertFalse(path("unasked").exists())


class Axes(unittest.TestCase):
    WING = ["--set", "surface.file=wing.obj", "--set", "regions={root: {box: [[-9, -9, -9], [9, 0.1, 9]]}}",
            "--set", "symmetry={plane: y}", "--set", "quantities={aero: {type: newtonian, mach: 6}}"]

    def points(self):
        return [tuple(map(float, line.split()[1:4])) for line in path("wing.obj").read_text().splitlines() if line.startswith("v ")]

    def test_where_nose_right_wing_and_top_are(self):
        points = self.points()
        words = strake("check", "case.yaml", "--quick", *self.WING, "--set", "axes={downstream: +x, up: +z}").stdout
        self.assertIn("downstream +x, up +z, right wing +y\n", words)
        self.assertIn("air meets the nose at x = %.6g, vertex" % (min(p[0] for p in points) + 0), words)
        self.assertIn("right wing tip at y = %.6g, vertex" % max(p[1] for p in points), words)
        self.assertIn("top at z = %.6g, vertex" % max(p[2] for p in points), words)
        self.assertIn("this is the right half", words)
        self.assertIn("coefficients of the half that is modelled", words)
        turned = strake("check", "case.yaml", "--quick", *self.WING, "--set", "axes={downstream: -x, up: +z}").stdout
        self.assertIn("air meets the nose at x = %.6g" % max(p[0] for p in points), turned)
        self.assertIn("this is the left half: left wing tip at y = %.6g" % max(p[1] for p in points), turned)

    def test_the_picture(self):
        done = strake("check", "case.yaml", "--quick", *self.WING, "--set", "axes={downstream: +x, up: +z}", "--picture", "axes.svg")
        self.assertIn("wrote       axes.svg\n", done.stdout)
        picture = path("axes.svg").read_text()
        told = json.loads(strake("check", "case.yaml", "--quick", "--json", *self.WING).stdout)
        self.assertEqual(picture.count("<image "), 3 + len(told["regions"]) + len(told["levels"]))
        for region in told["regions"]:
            self.assertIn(">%s: %d triangles, from " % (region["name"], region["triangles"]), picture)
        for level in told["levels"]:
            self.assertIn(">level %d: %d patches, from " % (level["level"], level["patches"]), picture)
            self.assertEqual(sum(patch["triangles"] for patch in level["each"]), told["surface"]["triangles"])
            self.assertGreater(min(patch["area"] for patch in level["each"]), 0)
        self.assertEqual(told["fixed"]["triangles"], told["fixed_triangles"])
        self.assertIn(">x = ", picture)
        for words in (">air<", ">up<", ">right wing<", "axes as stated", "held ("):
            self.assertIn(words, picture)
        strake("check", "case.yaml", "--quick", *self.WING, "--set", "axes={downstream: -x, up: +z}", "--picture", "turned.svg")
        turned = path("turned.svg").read_text()
        self.assertIn(">left wing<", turned)
        self.assertNotIn(">right wing<", turned)
        self.assertIn("axes assumed", self.drawn(*self.WING))
        self.assertNotIn(">air<", self.drawn())
        self.assertIn("must end in .svg", strake("check", "case.yaml", "--picture", "axes.png", status=2).stderr)

    def drawn(self, *arguments):
        strake("check", "case.yaml", "--quick", *arguments, "--picture", "drawn.svg")
        return path("drawn.svg").read_text()

    def test_in_json(self):
        told = json.loads(strake("check", "case.yaml", "--quick", "--json", *self.WING, "--set",
                                 "symmetry.coefficients=whole", "--set", "axes={downstream: [1, 0, 0], up: +z}").stdout)["axes"]
        self.assertEqual((told["downstream"], told["up"], told["right"]), ([1, 0, 0], [0, 0, 1], [0, 1, 0]))
        self.assertEqual((told["stated"], told["half"], told["coefficients"], told["used_by"]), (True, "right", "whole", ["aero"]))
        points = self.points()
        nose = told["nose"]
        self.assertEqual(nose["point"][0], min(p[0] for p in points))
        self.assertEqual(tuple(nose["point"]), points[nose["vertex"]])

    def test_assumed_ones_are_called_so_and_odd_ones_are_told(self):
        self.assertIn("assumed", strake("check", "case.yaml", "--quick", *self.WING).stdout)
        odd = strake("check", "case.yaml", "--quick", *self.WING, "--set", "axes={downstream: +x, up: +y}").stderr
        self.assertIn("warning: axes: the right wing points along -z, but the symmetry plane has the normal +y", odd)
        self.assertNotIn("axes  ", strake("check", "case.yaml", "--quick").stdout)
        self.assertIsNone(json.loads(strake("check", "case.yaml", "--quick", "--json").stdout)["axes"])


class HalfBodies(unittest.TestCase):
    def test_the_line_that_is_missing_is_printed(self):
        wing = ["--set", "surface.file=wing.obj", "--set", "regions={root: {box: [[-9, -9, -9], [9, 0.1, 9]]}}"]
        line = "symmetry: {plane: y, at: 0}"
        self.assertIn(line, strake("check", "case.yaml", *wing, status=3).stderr)
        told = strake("check", "case.yaml", "--quick", *wing, "--set", "objective={minimize: area}").stderr
        self.assertIn("note: half a body? Then add to the case " + line, told)
        self.assertNotIn(line, strake("check", "case.yaml", "--quick", *wing, "--set", "symmetry={plane: y}").stderr)


class Page(unittest.TestCase):
    def test_the_last_line_is_the_page_to_open(self):
        if "built without" in strake("report", "nowhere", status=2 if page_is_built() else 4).stderr:
            self.skipTest("this build has no page")
        out = strake("run", "case.yaml", "--out", "page").stdout
        self.assertEqual(out.splitlines()[-1], "open         page/report.html")
        self.assertTrue(path("page/report.html").exists())
        out = strake("run", "case.yaml", "--out", "none", "--set", "output.report=false").stdout
        self.assertFalse(path("none/report.html").exists())
        self.assertNotIn("report.html", out)


def page_is_built():
    done = subprocess.run([STRAKE, "report", "nowhere"], cwd=FOLDER.name, capture_output=True, text=True, check=False)
    return "built without" not in done.stderr


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
