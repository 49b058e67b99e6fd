"""shell: none on the files: run, resume, step, fit, deform, check, report, apply, gradient-check, mix and Python's case of a
body whose parts pass through each other. Arguments: the programs strake and make_surface."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

STRAKE, MAKE_SURFACE = (str(pathlib.Path(p).resolve()) for p in sys.argv[1:3])
CASE = """
case: dirty
surface: {file: body.obj}
regions: {nose: {box: [[-9, -9, -9], [-1.6, 9, 9]]}}
fixed: [nose]
shell: none
GOAL
optimize: {budget: {evaluations: 12}}
"""
RUN = "objective: {maximize: volume}\nconstraints: {area: {max: 1.01, relative: true}}"


def strake(*arguments, status=0):
    done = subprocess.run([STRAKE, *arguments], cwd=FOLDER.name, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=300, check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stdout, done.stderr)
    return done


def path(name):
    return pathlib.Path(FOLDER.name) / name


def vertices(name):
    lines = path(name).read_text().splitlines()
    return [tuple(map(float, line.split()[1:])) for line in lines if line.startswith("v ")]


def setUpModule():
    global FOLDER
    FOLDER = tempfile.TemporaryDirectory()
    subprocess.run([MAKE_SURFACE, "wing_through_body", "-o", "body.obj"], cwd=FOLDER.name, check=True, capture_output=True)
    path("run.yaml").write_text(CASE.replace("GOAL", RUN))
    strake("run", "run.yaml", "--out", "runs/a", "--quiet")


def tearDownModule():
    FOLDER.cleanup()


class WithoutShell(unittest.TestCase):
    def test_a_run_gains_and_holds_what_is_held(self):
        run = json.loads(path("runs/a/run.json").read_text())
        self.assertGreater(run["objective"], 1.002 * run["objective_start"])
        rest, best = vertices("body.obj"), vertices("runs/a/best.obj")
        self.assertEqual(len(rest), len(best))
        held = [i for i, v in enumerate(rest) if v[0] < -1.7]
        self.assertGreater(len(held), 20)
        for i in held:
            self.assertEqual(rest[i], best[i])
        self.assertTrue(path("runs/a/report.html").exists())

    def test_its_full_case_can_be_run_again(self):
        full = path("runs/a/case.yaml").read_text()
        self.assertIn("shell: none", full)
        strake("check", "runs/a/case.yaml")

    def test_resume_step_report_and_mix(self):
        strake("resume", "runs/a", "--evaluations", "+2", "--quiet")
        strake("step", "run.yaml", "--out", "runs/s", "--quiet")
        strake("report", "runs/a")
        strake("mix", "runs/a", "runs/a", "--weight", "0.5", "-o", "mixed.obj")
        self.assertEqual(len(vertices("mixed.obj")), len(vertices("body.obj")))

    def test_check_and_gradients(self):
        facts = json.loads(strake("check", "run.yaml", "--json").stdout)
        self.assertIn("section.move_z.1", json.dumps(facts))
        strake("gradient-check", "run.yaml")

    def test_fit(self):
        done = strake("deform", "run.yaml", "--field", "section.move_z.2=4%", "-o", "target.obj", "--json")
        moved = json.loads(done.stdout)
        self.assertEqual(moved["status"], "converged")
        path("fit.yaml").write_text(CASE.replace(
            "GOAL", "quantities: {match: {type: target_shape, file: target.obj, match: same}}\nfit: [match]"))
        strake("fit", "fit.yaml", "--out", "runs/fit", "--quiet")
        worst = max(abs(a - b) for p, q in zip(vertices("target.obj"), vertices("runs/fit/best.obj")) for a, b in zip(p, q))
        self.assertLess(worst, 2e-3)

    def test_deform_by_fields(self):
        none = strake("deform", "run.yaml", "-o", "out.obj", status=2).stderr
        self.assertIn("name at least one with --field NAME=VALUE", none)
        wrong = strake("deform", "run.yaml", "--field", "section.fly.2=4%", "-o", "out.obj", status=2).stderr
        self.assertIn("there is no field of that name; fields: section.", wrong)
        far = strake("deform", "run.yaml", "--field", "section.scale_z.1=90%", "-o", "out.obj", status=1).stderr
        self.assertIn("fold", far)
        self.assertFalse(path("out.obj").exists())

    def test_what_is_not_defined_says_so(self):
        subprocess.run([MAKE_SURFACE, "holes", "-o", "holes.obj"], cwd=FOLDER.name, check=True, capture_output=True)
        goal = "quantities: {d: {type: wave_drag}}\nobjective: {minimize: d}"
        path("drag.yaml").write_text(CASE.replace("GOAL", goal).replace("body.obj", "holes.obj"))
        self.assertIn("the surface is open or misoriented at", strake("check", "drag.yaml", status=2).stderr)
        path("volume.yaml").write_text(CASE.replace("GOAL", RUN).replace("body.obj", "holes.obj"))
        strake("check", "volume.yaml")

    def test_init_proposes_what_it_has_tried(self):
        subprocess.run([MAKE_SURFACE, "inner_walls", "-o", "walls.obj"], cwd=FOLDER.name, check=True, capture_output=True)
        told = json.loads(strake("init", "walls.obj", "-o", "walls.yaml", "--json", "--evaluations", "4").stdout)
        self.assertTrue(told["tried"][0].startswith("an elastic shell on the surface: "), told["tried"])
        self.assertRegex(told["tried"][-1], "[0-8] of [68] test deformations fail")
        for way in told["tried"][:-1]:  # ends with the second failure
            self.assertRegex(way, "2 of [2-6] test deformations fail|refused")
        strake("run", "walls.yaml", "--out", "runs/walls", "--quiet")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
