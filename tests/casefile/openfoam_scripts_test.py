#!/usr/bin/python3
"""What the OpenFOAM examples compute by themselves, without OpenFOAM: openfoam_scripts_test.py FOLDER_OF_THE_SCRIPTS"""
import contextlib
import io
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np

sys.dont_write_bytecode = True
SCRIPTS = os.path.abspath(sys.argv.pop(1))
sys.path.insert(0, SCRIPTS)
import carry
import foam
from body_surface import sphere


class Carry(unittest.TestCase):
    def setUp(self):
        self.surface = sphere(24, 32)
        self.points, self.faces = sphere(17, 23)  # of a solver's mesh: another triangulation of the same body
        self.map, self.worst = carry.SurfaceMap.between(*self.surface, self.points)

    def test_points_are_found_and_linear_motions_are_kept(self):
        self.assertLess(self.worst, 0.02)  # of the facets
        rows = np.arange(0, len(self.surface[1]), 7)
        weights = np.array([0.2, 0.5, 0.3])
        inside = np.einsum("k,nkj->nj", weights, self.surface[0][self.surface[1][rows]])
        exact, worst = carry.SurfaceMap.between(*self.surface, inside)
        self.assertLess(worst, 1e-14)
        np.testing.assert_allclose(exact.apply(self.surface[0]), inside, atol=1e-14)

    def test_a_point_on_a_vertex_gets_its_displacement_to_the_bit(self):
        same, worst = carry.SurfaceMap.between(*self.surface, self.surface[0])
        self.assertEqual(worst, 0)
        shift = np.random.default_rng(1).normal(size=self.surface[0].shape)
        np.testing.assert_array_equal(same.apply(shift), shift)

    def test_every_region_of_the_plane_of_a_triangle(self):
        corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
        cases = {(-1, -1): (1, 0, 0), (2, -0.5): (0, 1, 0), (-0.5, 2): (0, 0, 1), (0.25, -1): (0.75, 0.25, 0),
                 (-1, 0.25): (0.75, 0, 0.25), (1, 1): (0, 0.5, 0.5), (0.25, 0.25): (0.5, 0.25, 0.25)}
        for (x, y), wanted in cases.items():
            found, _ = carry.SurfaceMap.between(corners, np.array([[0, 1, 2]]), np.array([[x, y, 0.3]]))
            np.testing.assert_allclose(found.weights[0], wanted, atol=1e-15, err_msg=f"{x}, {y}")

    def test_the_way_back_is_the_transpose(self):
        random = np.random.default_rng(2)
        d, g = random.normal(size=self.surface[0].shape), random.normal(size=self.points.shape)
        self.assertAlmostEqual(np.sum(self.map.apply(d) * g), np.sum(d * self.map.transpose(g)), places=11)


class Files(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def write(self, name, text):
        path = os.path.join(self.folder.name, name)
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
        return path

    def test_points_survive_to_the_bit(self):
        points = np.random.default_rng(3).normal(size=(50, 3)) * 10.0 ** np.arange(-25, 25)[:, None]
        foam.write_points(self.folder.name, points)
        np.testing.assert_array_equal(foam.read_points(self.folder.name), points)

    def test_a_patch_and_its_points_in_order_of_appearance(self):
        head = foam.header("faceList", "faces")
        self.write("faces", head + "4\n(\n3(0 1 2)\n4(7 3 2 5) // note\n3(2 9 7)\n3(0 0 0)\n)\n")
        self.write("boundary", "/* two\nlines */ 2 ( other { nFaces 1; startFace 3; } body { type wall; nFaces 2; "
                               "startFace 1; } )")
        faces = foam.read_patch(self.folder.name, "body")
        self.assertEqual([list(face) for face in faces], [[7, 3, 2, 5], [2, 9, 7]])
        self.assertEqual(foam.points_of(faces), [7, 3, 2, 5, 9])

    def field(self, values):
        return self.write("field", "internalField uniform 0;\nboundaryField\n{\n    body\n    {\n        type calculated;\n"
                                   f"        value nonuniform List<scalar>\n{values}\n;\n    }}\n}}\n")

    def test_a_patch_field(self):
        values = foam.read_patch_field(self.field("3\n(\n1\n-2e-3\n0\n)"), "body", 1)
        self.assertEqual(values.tolist(), [[1], [-2e-3], [0]])

    def test_values_in_the_cells(self):
        path = self.write("cells", "internalField nonuniform List<vector> \n2\n(\n(1 2 3)\n(4 5 -6e-1)\n)\n;\n\nboundaryField\n{\n"
                                   "    body\n    {\n        value nonuniform List<vector> \n1\n(\n(7 8 9)\n)\n;\n    }\n}\n")
        self.assertEqual(foam.read_cell_field(path, 3).tolist(), [[1, 2, 3], [4, 5, -0.6]])
        self.assertEqual(foam.read_patch_field(path, "body", 3).tolist(), [[7, 8, 9]])

    def test_wrong_fields_end_the_evaluation(self):
        for values in ("3\n(\n1\n2\n)", "2\n(\n1\nnan\n)"):
            with self.assertRaises(SystemExit), open(os.devnull, "w", encoding="ascii") as sink:
                sys.stderr, kept = sink, sys.stderr
                try:
                    foam.read_patch_field(self.field(values), "body", 1)
                finally:
                    sys.stderr = kept

    def test_the_last_column_table(self):
        path = self.write("coefficient.dat", "# Time Cd Cs\n1 0.5 0\n2 0.25 0\n")
        self.assertEqual(foam.read_columns(path).tolist(), [[1, 0.5, 0], [2, 0.25, 0]])

    def test_stl_comes_back(self):
        path = os.path.join(self.folder.name, "body.stl")
        vertices, triangles = sphere(6, 8)
        foam.write_stl(path, vertices, triangles)
        self.assertEqual(os.path.getsize(path), 84 + 50 * len(triangles))
        corners, rows = foam.read_stl(path)
        np.testing.assert_allclose(corners[rows], vertices[triangles], atol=1e-7)
        with open(path, "ab") as file:
            file.write(b"more")
        with self.assertRaises(SystemExit), contextlib.redirect_stderr(io.StringIO()):
            foam.read_stl(path)


class Programs(unittest.TestCase):
    def test_a_missing_program_and_one_that_fails_are_told_in_one_line(self):
        with tempfile.TemporaryDirectory() as folder:
            for command, word in (("['no-such-foam']", "not found"), ("['sh', '-c', 'echo broken; exit 3']", "status 3"),
                                  ("['sh', '-c', 'echo FOAM FATAL ERROR']", "status 0")):
                code = f"import sys; sys.path.insert(0, {SCRIPTS!r}); import foam; foam.run('.', *{command})"
                done = subprocess.run([sys.executable, "-B", "-c", code], cwd=folder, capture_output=True, text=True,
                                      check=False)
                self.assertEqual(done.returncode, 1)
                self.assertIn(word, done.stderr.splitlines()[-1])


if __name__ == "__main__":
    unittest.main()
