import subprocess
import sys

import numpy as np
import pytest

import strake
from conftest import ellipsoid


def test_arrays_are_views_that_cannot_be_written(body):
    v = body.vertices
    assert v.dtype == np.float64 and v.shape == (body.num_vertices, 3) and v.flags.c_contiguous
    assert np.shares_memory(v, body.vertices) and not v.flags.writeable
    with pytest.raises(ValueError):
        v[0, 0] = 1
    kept = ellipsoid(n=6).vertices  # the surface is gone, its memory is not
    assert np.isfinite(kept).all()


def test_measures(body):
    assert body.is_closed
    assert body.volume == pytest.approx(4 / 3 * np.pi * 0.24, rel=0.06)
    assert body.areas().sum() == pytest.approx(body.area)
    assert np.linalg.norm(body.normals(), axis=1) == pytest.approx(1)
    assert body.with_vertices(2 * body.vertices).volume == pytest.approx(8 * body.volume)
    low, high = body.box
    assert body.diagonal == pytest.approx(np.linalg.norm(high - low))


def test_files_keep_bits(body, tmp_path):
    strake.write_surface(tmp_path / "b.obj", body)
    again = strake.read_surface(tmp_path / "b.obj")
    assert np.array_equal(again.vertices, body.vertices) and np.array_equal(again.triangles, body.triangles)


@pytest.mark.parametrize("make, kinds, words", [
    (lambda: strake.Surface([[0, 0, 0]], np.zeros((1, 3), dtype=np.int32) + 1), (strake.InvalidInput, ValueError), "vertex 1"),
    (lambda: strake.Surface([[0, np.nan, 0]], np.zeros((0, 3), dtype=np.int32)), (strake.InvalidInput,), "row 0"),
    (lambda: strake.Surface(np.eye(3), [[0, 1, 2.9]]), (strake.InvalidInput,), "Surface: triangles: 0.0 (float64) is not a whole number"),
    (lambda: strake.Surface(np.eye(3), np.array([[0, 1.5, 2]], dtype=np.float32)), (strake.InvalidInput,), "triangles"),
    (lambda: strake.Surface(np.eye(3), [[False, True, True]]), (strake.InvalidInput,), "False (bool)"),
    (lambda: strake.Surface(np.eye(3), [[0, 1, 2**40]]), (strake.InvalidInput,), "vertex 1099511627776, limits 0 and 2"),
    (lambda: strake.Surface(np.eye(3), [[0, 1]]), (strake.InvalidInput,), "shape (1, 2)"),
    (lambda: strake.patches(ellipsoid(n=4), patches_per_level=[2.5]), (strake.InvalidInput,), "patches_per_level: 2.5"),
    (lambda: strake.patches(ellipsoid(n=4), patches_per_level=[0]), (strake.InvalidInput,), "limits 1 and"),
    (lambda: strake.patches(ellipsoid(n=4), patches_per_level=3), (strake.InvalidInput,), "= 3 must be a list"),
    (lambda: strake.read_surface("/nowhere.stl"), (strake.InputError, OSError), "/nowhere.stl"),
    (lambda: strake.write_surface("/proc/x.stl", ellipsoid(n=4)), (strake.OutputError, OSError), "/proc/x.stl"),
    (lambda: strake.write_surface("x.doc", ellipsoid(n=4)), (strake.InvalidInput,), "doc"),
    (lambda: strake.patches(ellipsoid(n=4), angles=[200]), (strake.InvalidInput,), "200"),
    (lambda: strake.load_case("/nowhere.yaml"), (strake.Error,), "nowhere.yaml"),
])
def test_errors_have_types_and_words(make, kinds, words):
    with pytest.raises(strake.Error) as caught:
        make()
    assert words in str(caught.value)
    for kind in kinds:
        assert isinstance(caught.value, kind)


def test_corners_of_any_whole_type_are_taken(body):
    for kind in (np.int16, np.int32, np.int64, np.uint32, np.uint64):
        assert np.array_equal(strake.Surface(body.vertices, body.triangles.astype(kind)).triangles, body.triangles)
    assert strake.Surface(np.eye(3), [[0, 1, 2]]).num_triangles == 1
    assert strake.Surface(np.eye(3), np.zeros((0, 3), dtype=int)).num_triangles == 0


@pytest.mark.parametrize("number", [2.5, 2.0, np.float32(2.9), "2"])
def test_single_numbers_are_not_rounded_either(body, number):
    problem = strake.Problem(body)
    for call in (lambda: strake.DesignSpace(problem, level=number), lambda: problem.options(max_evaluations=number),
                 lambda: problem.options(seed=number), lambda: strake.Shell(body, height=0.1).solve(max_iterations=number)):
        with pytest.raises(TypeError):
            call()
    problem.options(max_evaluations=np.int64(7), seed=np.uint8(3))
    with pytest.raises(strake.InvalidInput, match="seed = -1, limits 0"):
        problem.options(seed=-1)


def test_patches_partition(body):
    tree = strake.patches(body, patches_per_level=[4, 8])
    for level in tree.levels:
        assert sorted(t for p in level.patches for t in p.triangles) == list(range(body.num_triangles))
        assert len(set(level.labels)) == len(level.patches)
        assert sum(p.area for p in level.patches) == pytest.approx(body.area)
    assert tree.levels[0].patches[0].name == "all"


def test_other_points_move_along(body):
    moved = body.vertices + [0.1, 0, 0.2]
    points = np.vstack([body.vertices[:5], 1.001 * body.vertices[5:9], [[9, 9, 9]]])
    carried = strake.SurfaceMap(body, points).moved(moved)
    assert np.array_equal(carried[:5], moved[:5])
    assert carried[5:9] - points[5:9] == pytest.approx(np.tile([0.1, 0, 0.2], (4, 1)), rel=1e-2)
    assert np.array_equal(carried[9], points[9])
    m, random = strake.SurfaceMap(body, points), np.random.default_rng(3)
    u, g = random.standard_normal(body.vertices.shape), random.standard_normal(points.shape)
    assert np.vdot(g, m.apply(u)) == pytest.approx(np.vdot(m.transpose(g), u))


def test_distance(body):
    told = body.distance(body.with_vertices(body.vertices + [0, 0, 0.01]))
    assert told["max"] == pytest.approx(0.01, rel=0.05) and len(told["at_vertices"]) == body.num_vertices


def test_a_numpy_that_the_module_does_not_know_is_refused():
    code = "import numpy; numpy.__version__ = '2.1.0'; import strake"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    if strake._core.numpy_2:
        assert done.returncode == 0, done.stderr
    else:
        assert done.returncode == 1 and "here is NumPy 2.1.0" in done.stderr, done.stderr
