"""The motion limit on the files: scripts/check_motion.py measures a run, a run of before is resumed with the old meaning,
limits by region, warnings; wings of before. Arguments: the programs strake and make_surface."""
import json
import math
import pathlib
import re
import sqlite3
import subprocess
import sys
import tempfile
import unittest

STRAKE, MAKE_SURFACE = (str(pathlib.Path(p).resolve()) for p in sys.argv[1:3])
CHECK = str(pathlib.Path(__file__).resolve().parents[2] / "scripts/check_motion.py")
CASE = """
case: limited
surface: {file: body.obj}
regions: {root: {box: [[-9, -9, -9], [0.8, 9, 9]]}, tail: {box: [[5, -9, -9], [99, 9, 9]]}}
fixed: [root]
parameters: {levels: auto, patches_per_level: [4], variables: [load], LIMIT}
quantities: {high: {type: extent, direction: [0, 0, 1], smoothing: 5%}, keep: {command: [sh, -c, "echo '{\\"value\\": 1}' > {result}"], format: obj, gradients: false}}
objective: {maximize: high.max}
optimize: {budget: {evaluations: 8}}
output: {report: false}
"""

WING = """
case: wing
surface: {file: wing.obj}
symmetry: {plane: y, at: 0}
regions: {root: {box: [[-9, -9, -9], [9, 0.1, 9]]}}
fixed: [root]
planform: {wing: {on: all - root, span: y KEEP}}
shell: none
parameters: {fields: {number: 12, kind: sections}, max_displacement: 2%}
objective: {maximize: volume}
constraints: {area: {max: 1, relative: true}}
optimize: {budget: {evaluations: 3}}
output: {report: false}
"""


def strake(*arguments, status=0):
    done = subprocess.run([STRAKE, *arguments], cwd=FOLDER.name, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=300, check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stdout, done.stderr)
    return done


def write(name, limit, **changes):
    text = CASE.replace("LIMIT", limit)
    for old, new in changes.items():
        text = text.replace(old, new)
    (pathlib.Path(FOLDER.name) / name).write_text(text)


def resumed(case, meaning, evaluations):
    """A run that began with an earlier meaning of its keys; the case asks for one evaluation. @return what it says, its history"""
    run = f"{case}-{meaning}"
    strake("run", case, "--out", run, "-q")
    folder = pathlib.Path(FOLDER.name) / run
    with sqlite3.connect(folder / "journal.sqlite") as journal:
        journal.execute(f"UPDATE facts SET value = '{meaning}' WHERE name = 'meaning'")
        journal.execute("DELETE FROM facts WHERE name = 'hash'")
    journal.close()
    done = strake("resume", run, "--evaluations", str(evaluations))
    return done.stdout + done.stderr, (folder / "history.csv").read_text().splitlines()


def bend_up(file):
    """What lies outboard of 70 % of the wing's semispan is wound on an arc of 80 degrees, then straight on: a winglet."""
    lines = []
    for line in file.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"] and float(words[2]) > 0.84:
            x, y, z = map(float, words[1:])
            angle = min((y - 0.84) / 0.1, math.radians(80))
            beyond = y - 0.84 - 0.1 * angle
            y = 0.84 + (0.1 - z) * math.sin(angle) + beyond * math.cos(angle)
            line = f"v {x} {y} {0.1 - (0.1 - z) * math.cos(angle) + beyond * math.sin(angle)}"
        lines.append(line)
    file.write_text("\n".join(lines) + "\n")


def setUpModule():
    global FOLDER
    FOLDER = tempfile.TemporaryDirectory()
    subprocess.run([MAKE_SURFACE, "lifting_body", "--triangles", "2000", "-o", "body.obj"], cwd=FOLDER.name, check=True,
                   stdout=subprocess.DEVNULL)


def tearDownModule():
    FOLDER.cleanup()


class MotionLimit(unittest.TestCase):
    def result(self, run):
        return json.loads((pathlib.Path(FOLDER.name) / run / "run.json").read_text())

    def test_the_script_measures_every_shape_of_a_run(self):
        write("case.yaml", "max_displacement: 0.5%")
        strake("run", "case.yaml", "--out", "run", "-q")
        self.assertTrue(self.result("run")["motion_limit"]["active"])
        self.assertIn("the motion limit (0.5 % of the diagonal) is active on", self.result("run")["reason"])
        measured = subprocess.run([CHECK, "run", "--strake", STRAKE], cwd=FOLDER.name, capture_output=True, text=True,
                                  timeout=120, check=False)
        self.assertEqual(measured.returncode, 0, measured.stdout + measured.stderr)
        less = subprocess.run([CHECK, "run", "--strake", STRAKE, "--limit", "0.004"], cwd=FOLDER.name, capture_output=True,
                              text=True, timeout=120, check=False)
        self.assertEqual(less.returncode, 1, less.stdout + less.stderr)

    def test_a_run_of_before_goes_on_with_the_old_meaning(self):
        write("old.yaml", "max_displacement: 0.5%", **{"evaluations: 8": "evaluations: 1"})
        strake("run", "old.yaml", "--out", "old", "-q")
        with sqlite3.connect(pathlib.Path(FOLDER.name) / "old/journal.sqlite") as journal:
            journal.execute("DELETE FROM facts WHERE name IN ('meaning', 'hash')")
        journal.close()
        strake("resume", "old", "--evaluations", "10", "-q")
        result = self.result("old")
        self.assertEqual(result["evaluations"], 10)
        self.assertNotIn("motion_limit", result)
        moved = json.loads(strake("status", "old", "--json").stdout)
        del moved  # the run is readable
        measured = subprocess.run([CHECK, "old", "--strake", STRAKE, "--limit", "0.005"], cwd=FOLDER.name,
                                  capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual(measured.returncode, 1, measured.stdout + measured.stderr)  # variables add up

    def test_a_wing_of_before_lets_its_edges_go(self):
        """A run from when wings kept nothing goes on, and is mixed, as one that says `keep: none`."""
        folder = pathlib.Path(FOLDER.name)
        subprocess.run([MAKE_SURFACE, "wing", "--triangles", "2000", "-o", "wing.obj"], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        for name in ("before", "none"):
            first = WING.replace("evaluations: 3", "evaluations: 1")  # designs after it differ by rounding
            (folder / "wing.yaml").write_text(first.replace("KEEP", ", keep: none"))
            strake("run", "wing.yaml", "--out", name, "-q")
        case = (folder / "before/case.yaml").read_text()
        old, meanings = re.subn(r"(meaning of its keys: )\d+\b", r"\g<1>2", case)
        self.assertEqual((case.count(", keep: none, "), meanings), (1, 1), case)
        self.assertNotEqual(old, case)
        (folder / "before/case.yaml").write_text(old.replace(", keep: none, ", ", "))
        for name, said in (("before", ", keep: none, "), ("none", ", ")):
            with sqlite3.connect(folder / name / "journal.sqlite") as journal:
                journal.execute(f"UPDATE facts SET value = replace(value, '{said}', ', ') WHERE name = 'case'")
                journal.execute("UPDATE facts SET value = '2' WHERE name = 'meaning'")
                journal.execute("DELETE FROM facts WHERE name = 'hash'")
            journal.close()
        (folder / "kept.yaml").write_text(WING.replace("KEEP", ""))
        strake("run", "kept.yaml", "--out", "kept", "-q")
        self.assertIn("planform: keep", strake("mix", "kept", "before", "-o", "m.obj", status=2).stderr)
        for name in ("before", "none"):
            strake("resume", name, "--evaluations", "6", "-q")
        best = [(folder / name / "best.obj").read_bytes() for name in ("before", "none", "kept")]
        self.assertEqual(best[0], best[1])
        self.assertNotEqual(best[0], best[2])
        strake("run", "wing.yaml", "--out", "less", "-q")
        for name in ("before", "none"):
            strake("mix", name, "less", "-o", f"{name}.obj")
        self.assertEqual((folder / "before.obj").read_bytes(), (folder / "none.obj").read_bytes())

    def test_fields_of_a_run_of_before_count_as_they_did(self):
        """What sections that are kept take out of fields: a run from when it did not count goes on so."""
        folder = pathlib.Path(FOLDER.name)
        subprocess.run([MAKE_SURFACE, "wing", "--triangles", "2000", "-o", "wing.obj"], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        (folder / "first.yaml").write_text(WING.replace("KEEP", "").replace("evaluations: 3", "evaluations: 1"))
        rows = {meaning: resumed("first.yaml", meaning, 3)[1] for meaning in (3, 4, 5)}
        self.assertEqual(rows[3], rows[4])
        self.assertNotEqual(rows[4], rows[5])

    def test_sections_of_a_winglet_of_before_lie_where_they_did(self):
        """At fractions of an extent that changes of the wing move."""
        folder = pathlib.Path(FOLDER.name)
        subprocess.run([MAKE_SURFACE, "wing", "--triangles", "4000", "-o", "winglet.obj"], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        bend_up(folder / "winglet.obj")
        (folder / "winglet.yaml").write_text(
            "surface: {file: winglet.obj}\nsymmetry: {plane: y, at: 0}\n"
            "planform: {wing: {span: y, stations: [0, 0.5, 1], values: [twist@0.5, dihedral@0.5]}}\nshell: none\n"
            "parameters: {planform: {wing.twist: {by: station, range: [-3deg, 3deg]}, wing.thickness@1: {range: [-9%, 9%]}}}\n"
            "objective: {maximize: volume}\noptimize: {budget: {evaluations: 1}}\noutput: {report: false}\n")
        rows = {meaning: resumed("winglet.yaml", meaning, 3)[1] for meaning in (8, 9)}
        self.assertEqual(rows[8][:2], rows[9][:2])
        self.assertNotEqual(rows[8], rows[9])

    def test_a_large_body_of_before_follows_its_wrap_as_it_did(self):
        """Of more than 16 000 vertices; by the same sums in another order, and so do its fields."""
        folder = pathlib.Path(FOLDER.name)
        subprocess.run([MAKE_SURFACE, "ellipsoid", "--triangles", "33000", "-o", "large.obj"], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        (folder / "large.yaml").write_text(
            "surface: {file: large.obj}\nhold: point\nwrap: {alpha: 8%}\nobjective: {maximize: volume}\n"
            "constraints: {area: {max: 1.01, relative: true}}\noptimize: {budget: {evaluations: 1}}\n"
            "parameters: {fields: 6, variables: [normal], patches_per_level: [4], max_displacement: 0.5%}\n")
        rows = {meaning: resumed("large.yaml", meaning, 4)[1] for meaning in (6, 7, 8)}
        self.assertEqual(rows[6], rows[7])
        self.assertNotEqual(rows[7], rows[8])

    def test_regions_have_limits_of_their_own(self):
        write("regions.yaml", "max_displacement: {default: 0.5%, tail: {inward: 0, outward: 0.1%}}")
        strake("run", "regions.yaml", "--out", "regions", "-q")
        self.assertTrue(self.result("regions")["motion_limit"]["active"])
        write("wrong.yaml", "max_displacement: {tial: 1%}")
        self.assertIn("region 'tial' is not declared; did you mean 'tail'?", strake("check", "wrong.yaml", status=2).stderr)
        write("wrong.yaml", "max_displacement: {tail: {inward: 0, outward: 0}}")
        self.assertIn("inward and outward are both 0", strake("check", "wrong.yaml", status=2).stderr)
        write("wrong.yaml", "max_displacement: {tail: 0}")
        self.assertIn("max_displacement.tail = 0; a region that is not to move is for `fixed`: add it there, `fixed: [tail]`",
                      strake("check", "wrong.yaml", status=2).stderr)
        write("wrong.yaml", "max_displacement: {tail: -1%}")
        self.assertIn("must be >= 0", strake("check", "wrong.yaml", status=2).stderr)

    def test_a_limit_that_limits_nothing_is_told(self):
        """Planform variables move the datum, too. Told where it is stated, not of the default that a run writes down."""
        folder = pathlib.Path(FOLDER.name)
        subprocess.run([MAKE_SURFACE, "wing", "--triangles", "1000", "-o", "wing.obj"], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        alone = WING.replace("KEEP", "").replace("fields: {number: 12, kind: sections}", "planform: {wing.span: {range: [-10%, 10%]}}")
        alone = alone.replace("max: 1, relative", "max: 1.2, relative")
        cases = {"alone": (alone, 1), "default": (alone.replace(", max_displacement: 2%", ""), 0),
                 "fields": (alone.replace("{planform", "{fields: {number: 12, kind: sections}, planform"), 0)}
        for name, (text, count) in cases.items():
            (folder / f"{name}.yaml").write_text(text)
            said = strake("check", f"{name}.yaml", "--quick")
            self.assertEqual((said.stdout + said.stderr).count("max_displacement has no effect"), count, name)
        strake("run", "default.yaml", "--out", "default", "-q")
        said = strake("check", "default/case.yaml", "--quick")
        self.assertNotIn("has no effect", said.stdout + said.stderr)
        moved = self.result("default")
        self.assertGreater(moved["objective"], 1.05 * moved["objective_start"])  # by more than 5 % of motion

    def test_variables_that_hold_each_other_back_reach_the_limit(self):
        """Each of four loads alone moves the surface by the limit; together they press a closed body evenly, and move it by a
        sixtieth of that. Their ranges must not be what ends the run."""
        subprocess.run([MAKE_SURFACE, "ellipsoid", "--triangles", "1500", "-o", "closed.obj"], cwd=FOLDER.name, check=True,
                       stdout=subprocess.DEVNULL)
        (pathlib.Path(FOLDER.name) / "closed.yaml").write_text(
            "surface: {file: closed.obj}\nhold: point\nobjective: {maximize: volume}\noptimize: {budget: {evaluations: 60}}\n"
            "parameters: {levels: auto, patches_per_level: [4], variables: [normal], max_displacement: 0.5%}\n")
        for starts in (1, 2):  # random starts are drawn in the first ranges
            run = f"closed{starts}"
            done = strake("run", "closed.yaml", "--out", run, "--set", f"optimize.starts={starts}")
            self.assertNotIn("the ranges become", done.stdout + done.stderr)  # they are as wide from the first step on
            told = json.loads((pathlib.Path(FOLDER.name) / run / "run.json").read_text())
            self.assertIn(told["status"], ("converged", "budget")[:starts])
            self.assertGreater(told["motion_limit"]["used"], 0.9, told["reason"])
            self.assertLessEqual(told["motion_limit"]["used"], 1 + 1e-9)
            level = told["levels"][0]
            self.assertGreater(level["objective_end"], 1.03 * level["objective_start"], "0.06 % with their first ranges")
        self.assertTrue(json.loads((pathlib.Path(FOLDER.name) / "closed1/run.json").read_text())["motion_limit"]["active"])
        # Runs of before begin with what one may do alone: they widen that at the end of the level, or keep it.
        (pathlib.Path(FOLDER.name) / "few.yaml").write_text(
            (pathlib.Path(FOLDER.name) / "closed.yaml").read_text().replace("evaluations: 60", "evaluations: 1"))
        for meaning in (3, 6):
            run = f"few.yaml-{meaning}"
            said, _ = resumed("few.yaml", meaning, 60)
            told = json.loads((pathlib.Path(FOLDER.name) / run / "run.json").read_text())
            self.assertEqual(told["status"], "converged")
            if meaning == 6:
                self.assertIn("the ranges become 4 times as wide", said)
                self.assertGreater(told["motion_limit"]["used"], 0.9, told["reason"])
            else:
                self.assertIn("the variables' own range ends there", told["reason"])
                self.assertLess(told["motion_limit"]["used"], 0.05)

    def test_fields_that_hold_each_other_back_begin_with_wide_ranges(self):
        """Without a shell what the limit lets fields be together is known. A run of before goes on with what one may do alone."""
        folder = pathlib.Path(FOLDER.name)
        subprocess.run([MAKE_SURFACE, "wing", "--triangles", "1000", "-o", "free.obj"], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        sides = (folder / "free.obj").read_text()  # no two triangles are as near to the middle: runs of 5 and 8 hold the same
        (folder / "free.obj").write_text(re.sub(r"(?m)^(v \S+ \S+ )([0-9]\S*)$", lambda v: f"{v[1]}{1.05 * float(v[2]):.17g}", sides))
        (folder / "free.yaml").write_text(
            "surface: {file: free.obj}\nshell: none\nhold: point\nobjective: {maximize: volume}\n"
            "optimize: {budget: {evaluations: 30}}\nparameters: {fields: {number: 24, kind: sections}, max_displacement: 0.5%}\n")
        gain = {}
        for meaning in (5, 8):
            run = f"free{meaning}"
            strake("run", "free.yaml", "--out", run, "-q")
            with sqlite3.connect(folder / run / "journal.sqlite") as journal:  # as if it had ended after one
                journal.execute(f"UPDATE facts SET value = '{meaning}' WHERE name = 'meaning'")
                journal.execute("DELETE FROM facts WHERE name = 'hash'")
                journal.execute("DELETE FROM evaluations WHERE number > 1")
                journal.execute("DELETE FROM calls WHERE evaluation > 1")
            journal.close()
            history = folder / run / "history.csv"
            whole = history.read_text()
            history.write_text("".join(whole.splitlines(True)[:2]))
            strake("resume", run, "-q")
            (self.assertEqual if meaning == 8 else self.assertNotEqual)(history.read_text(), whole)
            told = self.result(run)
            self.assertLessEqual(told["motion_limit"]["used"], 1 + 1e-9)
            gain[meaning] = told["objective"] - told["objective_start"]
        self.assertGreater(gain[8], 1.003 * gain[5])

    def test_what_is_asked_of_deform_is_not_limited_by_the_default(self):
        write("asked.yaml", "max_displacement: 5%")
        asked = (pathlib.Path(FOLDER.name) / "asked.yaml").read_text().replace(", max_displacement: 5%", "")
        (pathlib.Path(FOLDER.name) / "asked.yaml").write_text(asked + "strains: [{region: tail, translate: [0, 0, 1.2]}]\n")
        words = strake("deform", "asked.yaml", "-o", "asked.obj").stdout
        self.assertGreater(float(re.search(r"max displacement .*\(([0-9.]+) % of the diagonal", words).group(1)), 10, words)

    def test_mix_gives_what_is_asked_and_says_what_is_beyond(self):
        folder = pathlib.Path(FOLDER.name)
        for name, sense in (("up", "maximize"), ("down", "minimize")):
            write(f"{name}.yaml", "max_displacement: 0.5%", maximize=sense)
            strake("run", f"{name}.yaml", "--out", name, "-q")
        between = strake("mix", "down", "up", "--weight", "0.5", "-o", "between.obj")
        self.assertEqual(between.stderr, "")
        beyond = strake("mix", "down", "up", "--weight", "4", "-o", "beyond.obj", "--json")
        self.assertRegex(beyond.stderr, r"warning: beyond max_displacement of A's case: vertex \d+ is [0-9.]+ % .* the motion limit is 0.5 %")
        told = json.loads(beyond.stdout)
        self.assertTrue(told["beyond_motion_limit"])
        self.assertTrue((folder / "beyond.obj").exists())
        diagonal = json.loads(strake("check", "up.yaml", "--json", "--quick").stdout)["surface"]["diagonal"]
        self.assertGreater(told["max_from_b"], 0.01 * diagonal)  # farther than two such shapes can be apart

    def test_apply_gives_all_of_a_motion(self):
        """However far: what is moved may be any body, and has no limit of its own."""
        write("asked_of_apply.yaml", "max_displacement: 0.5%")
        text = (pathlib.Path(FOLDER.name) / "asked_of_apply.yaml").read_text()
        (pathlib.Path(FOLDER.name) / "asked_of_apply.yaml").write_text(text + "strains: [{region: tail, translate: [0, 0, 1.2]}]\n")
        strake("deform", "asked_of_apply.yaml", "-o", "far.obj", "-q")
        done = strake("apply", "body.obj", "body.obj", "--moved", "far.obj", "-o", "applied.obj")
        self.assertGreater(float(re.search(r"max displacement .*\(([0-9.]+) % of the diagonal", done.stdout).group(1)), 10, done.stdout)

    def test_init_writes_the_default_of_the_schema(self):
        strake("init", "body.obj", "-o", "proposed.yaml")
        written = re.search(r"max_displacement: (\S+)", (pathlib.Path(FOLDER.name) / "proposed.yaml").read_text()).group(1)
        explained = strake("explain", "parameters.max_displacement").stdout
        self.assertRegex(explained, rf"(?m)^  default +{re.escape(written)}$")

    def test_a_limit_beyond_reason_is_told(self):
        write("far.yaml", "max_displacement: 90%")
        said = strake("check", "far.yaml")
        self.assertIn("90 % of the diagonal of the surface", said.stdout + said.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
