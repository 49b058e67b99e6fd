"""Displacement fields whose finer ones always promise more: a level that another was left for has to move before it is left for finer ones. Long runs by values alone
with fields in front are searched by models. A run of before goes on as it began. Arguments: the programs strake and make_surface."""
import json
import math
import pathlib
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unittest

STRAKE = str(pathlib.Path(sys.argv[1]).resolve())
RINGS, AROUND = 81, 10
CASE = """
case: spindle
surface: {file: spindle.obj}
invariance: {revolve: x}
regions:
  nose: {plane: {normal: [1, 0, 0], at: 0.01}, side: below}
  tail: {plane: {normal: [1, 0, 0], at: 0.99}, side: above}
fixed: [nose, tail]
shell: none
parameters: {fields: {number: auto, along: splines, motions: [scale]}, variables: [], max_displacement: 3%}
quantities:
  drag: {type: wave_drag, stations: 200}
objective: {minimize: drag}
constraints: {volume: {equals: 1, relative: true}}
optimize: {budget: {evaluations: BUDGET}}
output: {report: false}
"""
BY_VALUES = CASE.replace("drag: {type: wave_drag, stations: 200}", "drag: {command: ['true'], gradients: false}").replace("number: auto", "number: 6")


def write_spindle(path):
    """A bumped body of revolution, rings denser at its ends."""
    stations = [0.5 - 0.5 * math.cos(math.pi * k / (RINGS + 1)) for k in range(1, RINGS + 1)]
    lines = ["v 0 0 0"]
    for x in stations:
        radius = 0.06 * (4 * x * (1 - x)) ** 0.75 * (1 + 0.12 * math.sin(6 * math.pi * x))
        for k in range(AROUND):
            angle = 2 * math.pi * k / AROUND
            lines.append(f"v {x!r} {radius * math.cos(angle)!r} {radius * math.sin(angle)!r}")
    lines.append("v 1 0 0")
    at = [[2 + ring * AROUND + k % AROUND for k in range(AROUND + 1)] for ring in range(RINGS)]
    last = 2 + RINGS * AROUND
    for k in range(AROUND):
        lines.append(f"f 1 {at[0][k + 1]} {at[0][k]}")
        for ring in range(RINGS - 1):
            a, b, c, d = at[ring][k], at[ring][k + 1], at[ring + 1][k], at[ring + 1][k + 1]
            lines += [f"f {a} {b} {c}", f"f {b} {d} {c}"]
        lines.append(f"f {at[-1][k]} {at[-1][k + 1]} {last}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def set_meaning(run, meaning):
    with sqlite3.connect(pathlib.Path(FOLDER.name) / run / "journal.sqlite") as journal:
        journal.execute("UPDATE facts SET value = ? WHERE name = 'meaning'", (meaning,))
        journal.execute("DELETE FROM facts WHERE name = 'hash'")
    journal.close()


def strake(*arguments):
    done = subprocess.run([STRAKE, *arguments], cwd=FOLDER.name, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode in (0, 3), (arguments, done.returncode, done.stdout, done.stderr)
    return json.loads((pathlib.Path(FOLDER.name) / arguments[arguments.index("-o") + 1 if "-o" in arguments else 1] / "run.json").read_text())


def setUpModule():
    global FOLDER
    FOLDER = tempfile.TemporaryDirectory()
    folder = pathlib.Path(FOLDER.name)
    write_spindle(folder / "spindle.obj")
    for name, budget in (("short", "1"), ("long", "50")):
        (folder / f"{name}.yaml").write_text(CASE.replace("BUDGET", budget), encoding="utf-8")


def tearDownModule():
    FOLDER.cleanup()


class Levels(unittest.TestCase):
    def test_a_level_moves_before_it_is_left_for_finer_ones(self):
        now = strake("run", "long.yaml", "-o", "now", "-q")
        strake("run", "short.yaml", "-o", "again", "-q")
        shutil.copytree(pathlib.Path(FOLDER.name) / "again", pathlib.Path(FOLDER.name) / "before")
        again = strake("resume", "again", "--evaluations", "50", "-q")
        set_meaning("before", "11")
        before = strake("resume", "before", "--evaluations", "50", "-q")

        def idle(run):  # levels that were left before they had moved
            return sum(level["evaluations"] == 1 for level in run["levels"][1:-1])
        for run in (now, again):
            self.assertEqual(idle(run), 0, run["levels"])
            self.assertGreater(len(run["levels"]), 3, "levels that could be left so")
        self.assertGreater(idle(before), 0, before["levels"])
        self.assertLessEqual(now["objective"], before["objective"])

    def test_a_long_run_by_values_has_models_and_one_of_before_differences(self):
        (pathlib.Path(FOLDER.name) / "values.yaml").write_text(BY_VALUES.replace("BUDGET", "400"), encoding="utf-8")

        def told():  # the design to come, and what is said of it
            done = subprocess.run([STRAKE, "step", "values.yaml", "-o", "steps"], cwd=FOLDER.name, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300,
                                  check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            return done.stderr
        self.assertIn("method: auto chooses model, in batches of 8: displacement fields are the first level", told())
        set_meaning("steps", "13")
        self.assertIn("method: auto chooses sqp by differences", told())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
