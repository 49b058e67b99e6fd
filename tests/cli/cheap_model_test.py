"""Runs with a cheap model beside a program: what the log says, kill -9 and resume, parallel, a program as cheap model.
Arguments: the programs strake and make_surface."""
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

STRAKE, MAKE_SURFACE = (str(pathlib.Path(p).resolve()) for p in sys.argv[1:3])
# The solver sees a drag beside Newton's; the coarse one half of it, each with a count of its calls.
SOLVER = """
import json, math, os, sys
kind, request_file, result_file = sys.argv[1:]
request = json.load(open(request_file))
with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), kind + "-calls"), "a") as calls:
    place = "low_fidelity" if "low_fidelity" in result_file.split(os.sep) else "evaluations"
    calls.write("%s %d\\n" % (place, request["evaluation"]))
points, drag, area = [], 0.0, 0.0
for line in open(request["surface"]):
    words = line.split()
    if words[:1] == ["v"]:
        points.append([float(w) for w in words[1:4]])
    elif words[:1] == ["f"]:
        a, b, c = (points[int(w.split("/")[0]) - 1] for w in words[1:4])
        u, v = [b[i] - a[i] for i in range(3)], [c[i] - a[i] for i in range(3)]
        n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        size = math.sqrt(sum(x * x for x in n))
        area += size / 2
        if n[0] < 0:
            drag += (-n[0]) ** 3 / size ** 2
values = {"drag": drag + 0.002 * area if kind == "fine" else drag / 2}
json.dump({"values": values}, open(result_file, "w"))
"""
CASE = """
case: cheap
surface: {file: body.obj}
axes: {downstream: +x, up: +z}
regions: {nose: {box: [[-1, -9, -9], [0.8, 9, 9]]}, base: {plane: {normal: [1, 0, 0], at: 7.99}, side: above}}
fixed: [nose, base]
parameters: {levels: auto, patches_per_level: [6], variables: [normal], max_displacement: 3%}
quantities:
  fine: {command: ["PYTHON", SOLVER_FILE, fine, "{request}", "{result}"], outputs: [drag], format: obj, gradients: false, parallel: 1, low_fidelity: LOW}
  newton: {type: newtonian, cp_max: 2, shadows: false}
MORE
objective: {minimize: fine.drag}
constraints: {volume: {min: 1, relative: true}}
optimize: {finite_differences: true, budget: {evaluations: 10}}
output: {report: false, paraview: none}
""".replace("PYTHON", sys.executable)
COARSE = """  coarse: {command: ["PYTHON", SOLVER_FILE, coarse, "{request}", "{result}"], outputs: [drag], format: obj, gradients: false, parallel: 2}
""".replace("PYTHON", sys.executable)


def strake(*arguments, status=0):
    done = subprocess.run([STRAKE, *arguments], cwd=FOLDER, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=900, check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stdout, done.stderr)
    return done


def write(name, low, more="", **changes):
    text = CASE.replace("LOW", low).replace("MORE", more).replace("SOLVER_FILE", str(FOLDER / "solver.py"))
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    (FOLDER / name).write_text(text)


def calls(kind):
    file = FOLDER / (kind + "-calls")
    lines = file.read_text().splitlines() if file.exists() else []
    file.unlink(missing_ok=True)
    return lines


def history(run):
    return (FOLDER / run / "history.csv").read_text()


def objectives(run):
    rows = [line.split(",") for line in history(run).splitlines()]
    at = rows[0].index("objective")
    return [float(row[at]) for row in rows[1:] if row[at]]


def killed(case, out, after):
    """Runs until the solver has been called so often, kills, and resumes to the end; returns the calls of both parts."""
    run = subprocess.Popen([STRAKE, "run", case, "--out", out, "-q"], cwd=FOLDER, stdin=subprocess.DEVNULL)
    file = FOLDER / "fine-calls"
    while run.poll() is None and not (file.exists() and len(file.read_text().splitlines()) >= after):
        time.sleep(0.01)
    run.send_signal(signal.SIGKILL)
    run.wait()
    strake("resume", out, "-q")


def setUpModule():
    global FOLDER, TEMPORARY
    TEMPORARY = tempfile.TemporaryDirectory()
    FOLDER = pathlib.Path(TEMPORARY.name)
    subprocess.run([MAKE_SURFACE, "lifting_body", "--triangles", "1500", "-o", "body.obj"], cwd=FOLDER, check=True,
                   stdout=subprocess.DEVNULL)
    (FOLDER / "solver.py").write_text(SOLVER)


def tearDownModule():
    TEMPORARY.cleanup()


class CheapModel(unittest.TestCase):
    def test_a_built_in_one_saves_evaluations_and_says_what_it_is_worth(self):
        write("with.yaml", "{drag: newton.drag}")
        done = strake("run", "with.yaml", "--out", "with")
        self.assertIn("cheap model: rho ", done.stdout + done.stderr)
        self.assertIn("cheap model (newton.drag for fine.drag): rho ", done.stdout + done.stderr)
        self.assertEqual(len(history("with").splitlines()), 11)
        write("without.yaml", "newton", **{", low_fidelity: newton": "", "evaluations: 10": "evaluations: 40"})
        strake("run", "without.yaml", "--out", "without", "-q")
        start = objectives("with")[0]
        gain = start - min(objectives("without"))
        self.assertGreater(start - min(objectives("with")), 0.95 * gain, "in a quarter of the evaluations")
        calls("fine")

    def test_killed_and_resumed_it_ends_with_the_same_bits(self):
        write("case.yaml", "{drag: newton.drag}")
        strake("run", "case.yaml", "--out", "whole", "-q")
        whole = calls("fine")
        self.assertEqual(len(whole), 10)
        killed("case.yaml", "killed", 4)
        self.assertEqual(history("whole"), history("killed"))
        self.assertLessEqual(len(calls("fine")), len(whole) + 1, "only the one that was running is paid again")
        write("parallel.yaml", "{drag: newton.drag}", **{"parallel: 1": "parallel: 3"})
        strake("run", "parallel.yaml", "--out", "parallel", "-q")
        self.assertEqual(history("whole"), history("parallel"))
        calls("fine")

    def test_a_program_as_cheap_model_is_paid_once_for_each_design(self):
        changes = {"patches_per_level: [6]": "patches_per_level: [3]", "evaluations: 10": "evaluations: 4"}
        write("coarse.yaml", "coarse", COARSE, **changes)
        strake("run", "coarse.yaml", "--out", "coarse", "-q")
        fine, coarse = calls("fine"), calls("coarse")
        self.assertEqual(len(fine), 4)
        own = [c for c in coarse if c.startswith("low_fidelity")]
        self.assertEqual(len(own), len(set(own)))
        self.assertGreater(len(own), 10)
        self.assertEqual(sorted(c.split()[0] for c in coarse if not c.startswith("low_fidelity")), ["evaluations"] * 4)
        self.assertLess(min(objectives("coarse")), objectives("coarse")[0])
        killed("coarse.yaml", "coarse_killed", 3)
        self.assertEqual(history("coarse"), history("coarse_killed"))
        self.assertLessEqual(len([c for c in calls("coarse") if c.startswith("low_fidelity")]), len(own) + 2,
                             "those that were running are paid again")
        calls("fine")

    def test_nonsense_is_refused_by_check(self):
        write("wrong.yaml", "fine")
        self.assertIn("'fine.drag' depends on 'fine' itself", strake("check", "wrong.yaml", status=2).stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
