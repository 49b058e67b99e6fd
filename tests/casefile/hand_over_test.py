#!/usr/bin/python3
"""The examples for SU2 and Cart3D with the scripts that play their programs: hand_over_test.py EXTERNAL_CASES STRAKE MAKE_SURFACE"""
import csv
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

CASES, STRAKE, MAKE_SURFACE = (os.path.abspath(path) for path in sys.argv[1:])
del sys.argv[1:]


def run(*command, cwd):
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)


class Example:
    name = fake = None

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        for script in ("newton.py", "played.py", "volume.py"):
            shutil.copy(os.path.join(CASES, script), folder.name)
        self.case = os.path.join(folder.name, self.name)
        shutil.copytree(os.path.join(CASES, self.name), self.case, ignore=shutil.ignore_patterns("generated"))
        self.generated = os.path.join(self.case, "generated")
        os.makedirs(self.generated)
        self.good(MAKE_SURFACE, "ellipsoid", "--triangles", "300", "-o", "generated/body.obj")

    def good(self, *command, cwd=None):
        done = run(*command, cwd=cwd or self.case)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def refused(self, word, *command, cwd):
        done = run(*command, cwd=cwd)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn(word, done.stderr)

    def play(self, *command):
        return [os.path.join(self.case, self.fake), *command]

    def history(self):
        with open(os.path.join(self.case, "run/history.csv"), encoding="ascii") as file:
            return list(csv.DictReader(file))

    def replace(self, name, old, new):
        path = os.path.join(self.case, name)
        with open(path, encoding="utf-8") as file:
            text = file.read()
        self.assertIn(old, text)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text.replace(old, new, 1))

    def improves(self, by, keep):
        self.replace("case.yaml", "patches_per_level: [2, 6]", "patches_per_level: [2]")
        self.good(STRAKE, "run", "case.yaml", "--out", "run", "-q")
        rows = self.history()
        best = [row for row in rows if row["accepted"] == "1"][-1]
        self.assertLess(float(best["aero.drag"]), (1 - by) * float(rows[0]["aero.drag"]))
        for name in keep:
            self.assertGreater(float(best[name]), (1 - 1e-5) * float(rows[0][name]))


class Su2(Example, unittest.TestCase):
    name, fake = "su2", "fake_su2.py"

    def setUp(self):
        super().setUp()
        self.good(*self.play("mesh", "generated/body.obj", "generated"))

    def test_drag_falls_and_sensitivities_are_the_derivatives(self):
        self.replace("case.yaml", "evaluations: 16", "evaluations: 8")
        self.improves(0.005, ["aero.lift", "volume"])
        # Points of the mesh are vertices of the surface, so the strict test has to pass.
        self.good(STRAKE, "gradient-check", "case.yaml", "--level", "1", "-q")

    def test_without_the_numbers_of_the_mesh_nothing_moves(self):
        """Rows counted from 0 are not SU2's global indices; the program refuses them, and no number comes of it."""
        self.replace("case.yaml", "    gradient_points: generated/surface.csv\n", "")
        self.replace("case.yaml", "    on_failure: shrink_step\n", "")
        done = run(STRAKE, "check", "case.yaml", "--evaluate", cwd=self.case)
        self.assertEqual(done.returncode, 5, done.stderr)

    def test_a_folder_that_an_earlier_process_left_is_not_in_the_way(self):
        """Folders of failed evaluations are kept, and numbers of processes come again."""
        left = lambda: os.makedirs(os.path.join(self.case, f"strake-check-{os.getpid()}/evaluations/000001"))
        done = subprocess.run([STRAKE, "check", "case.yaml", "--evaluate"], cwd=self.case, capture_output=True, text=True, check=False,
                              env={**os.environ, "TMPDIR": self.case}, preexec_fn=left)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_files_of_another_design_are_refused(self):
        self.replace("flow.cfg", "MESH_FILENAME= mesh.su2", "MESH_FILENAME= generated/mesh.su2")
        self.replace("flow.cfg", "MESH_OUT_FILENAME= mesh_out.su2", "MESH_OUT_FILENAME= generated/mesh.su2")
        with open(os.path.join(self.generated, "surface.csv"), encoding="ascii") as file:
            rows = [[word.strip() for word in line.split(",")] for line in file][1:]
        self.write_positions(rows)
        self.good(*self.play("SU2_CFD", "flow.cfg"))
        os.rename(os.path.join(self.case, "restart_flow.dat"), os.path.join(self.case, "solution_flow.dat"))
        self.replace("flow.cfg", "MATH_PROBLEM= DIRECT", "MATH_PROBLEM= DISCRETE_ADJOINT")
        self.good(*self.play("SU2_CFD_AD", "flow.cfg"))
        self.refused("solution_adj_cd.dat", *self.play("SU2_DOT_AD", "flow.cfg"), cwd=self.case)
        self.write_positions([[k, repr(1.01 * float(x)), y, z] for k, x, y, z in rows])
        self.good(*self.play("SU2_DEF", "flow.cfg"))
        self.refused("another mesh", *self.play("SU2_CFD_AD", "flow.cfg"), cwd=self.case)
        for broken, word in ((rows[:-1], "points"), (rows + rows[:1], "twice"), ([["0", *rows[0][1:]]] + rows[1:], "not on")):
            self.write_positions(broken)
            self.refused(word, *self.play("SU2_DEF", "flow.cfg"), cwd=self.case)

    def write_positions(self, rows):
        with open(os.path.join(self.case, "surface_positions.dat"), "w", encoding="ascii") as file:
            file.writelines(" ".join(row) + "\n" for row in rows)


class Cart3d(Example, unittest.TestCase):
    name, fake = "cart3d", "fake_cart3d.py"

    def setUp(self):
        super().setUp()
        self.good(*self.play("components", "generated/body.obj", "generated/body.tri"))

    def numbers(self, path):
        with open(path, encoding="ascii") as file:
            return file.read().split()

    def test_drag_falls_and_components_are_kept(self):
        self.replace("case.yaml", "evaluations: 24", "evaluations: 13")
        self.improves(0.01, ["aero.lift", "volume"])
        before, after = self.numbers(os.path.join(self.generated, "body.tri")), self.numbers(os.path.join(self.case, "run/best.tri"))
        start = 2 + 3 * int(before[0])
        self.assertEqual(before[:2] + before[start:], after[:2] + after[start:])  # triangles and components
        self.assertNotEqual(before[2:start], after[2:start])

    def test_a_surface_that_is_open_inside_out_or_of_other_components_is_refused(self):
        numbers = self.numbers(os.path.join(self.generated, "body.tri"))
        first, triangles = 2 + 3 * int(numbers[0]), int(numbers[1])
        target = os.path.join(self.case, "Components.i.tri")

        def write(numbers):
            with open(target, "w", encoding="ascii") as file:
                file.write(" ".join(numbers))

        write(numbers)
        for program in ("autoInputs", "cubes", "mgPrep", "flowCart"):
            self.good(*self.play(program))
        write(numbers[:-1] + ["9"])
        for program in ("autoInputs", "cubes", "mgPrep"):
            self.good(*self.play(program))
        self.refused("Config.xml", *self.play("flowCart"), cwd=self.case)
        turned = list(numbers)
        turned[first:first + 3 * triangles] = reversed(numbers[first:first + 3 * triangles])
        write(turned)
        self.refused("into the body", *self.play("autoInputs"), cwd=self.case)
        write(numbers[:1] + [str(triangles - 1)] + numbers[2:first] + numbers[first + 3:-1])
        self.refused("watertight", *self.play("autoInputs"), cwd=self.case)
        write(numbers[:-1])
        self.refused("numbers", *self.play("autoInputs"), cwd=self.case)

    def test_a_mesh_about_another_surface_is_refused(self):
        shutil.copy(os.path.join(self.generated, "body.tri"), os.path.join(self.case, "Components.i.tri"))
        self.good(*self.play("autoInputs"))
        self.replace("Components.i.tri", "\n", "\n ")
        self.refused("another surface", *self.play("cubes"), cwd=self.case)


if __name__ == "__main__":
    unittest.main()
