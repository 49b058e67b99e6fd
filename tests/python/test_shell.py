import threading

import numpy as np
import pytest

import strake
from conftest import nose


def traction(body):
    out = np.zeros((body.num_triangles, 3))
    out[body.centroids()[:, 0] > 0.3] = [0, 0, 2e-4]
    return out


@pytest.fixture
def shell(body):
    return strake.Shell(body, height=0.05 * body.diagonal, fixed=nose(body))


def test_adjoint_is_the_derivative_of_solve(body, shell):
    force, weight = strake.traction_forces(body, traction(body)), np.zeros_like(body.vertices)
    weight[:, 2] = body.vertices[:, 0]
    end = shell.solve(force)
    assert end.converged and end.stable and "equilibrium" in end.reason
    gradient = shell.adjoint(weight).force
    direction = np.random.default_rng(5).standard_normal(force.shape) * np.abs(force).max()
    ends = []
    for step in (1e-3, -1e-3):
        assert shell.solve(force + step * direction).converged
        ends.append(np.vdot(weight, shell.vertices))
    assert (ends[0] - ends[1]) / 2e-3 == pytest.approx(np.vdot(gradient, direction), rel=1e-5)


def test_fixed_vertices_keep_their_bits_and_reset_goes_back(body, shell):
    shell.solve(strake.traction_forces(body, traction(body)))
    held = np.unique(body.triangles[nose(body)])
    assert np.array_equal(shell.vertices[held], body.vertices[held])
    assert np.abs(shell.vertices - body.vertices).max() > 1e-3
    assert np.array_equal(shell.surface.vertices, shell.vertices)
    shell.reset()
    assert shell.vertices == pytest.approx(body.vertices, abs=1e-15)


def test_motions(body):
    tail = np.nonzero((body.vertices[body.triangles][:, :, 0] > 0.7).all(axis=1))[0]
    shell = strake.Shell(body, height=0.1, fixed=nose(body), moved=[tail])
    assert shell.solve(motions=[strake.Motion(translation=[0, 0, 0.05])]).converged
    ends = np.unique(body.triangles[tail])
    assert shell.vertices[ends] - body.vertices[ends] == pytest.approx(np.tile([0, 0, 0.05], (len(ends), 1)), abs=1e-12)


def test_other_threads_run_while_it_solves(body):
    shells = [strake.Shell(body, height=0.05 * body.diagonal, fixed=nose(body)) for _ in range(2)]
    force, found = strake.traction_forces(body, traction(body)), [None, None]

    def work(k):
        shells[k].solve(force)
        found[k] = shells[k].vertices

    threads = [threading.Thread(target=work, args=(k,)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert np.array_equal(found[0], found[1])


@pytest.mark.parametrize("arguments, kind, words", [
    ({"height": -1.0}, strake.InvalidInput, "-1"),
    ({"height": 0.1, "fixed": [10**6]}, strake.InvalidInput, "triangle 1000000"),
    ({"height": 0.1, "symmetry": ((0, 0, 0), 0)}, strake.InvalidInput, "normal"),
])
def test_what_cannot_be_is_refused(body, arguments, kind, words):
    with pytest.raises(kind, match=words):
        strake.Shell(body, **arguments)


def ways_to_choose(numbers, count):
    """The same triangles said in every way there is."""
    mask = np.zeros(count, dtype=bool)
    mask[numbers] = True
    return [numbers, numbers[::-1], list(map(int, numbers)), tuple(numbers), numbers.astype(np.uint64), numbers.astype(np.int8)
            if count < 128 else numbers.astype(np.int16), np.append(numbers, numbers[:1]), mask, mask.tolist(), mask[::1].copy()]


def test_masks_and_numbers_choose_the_same_triangles(body):
    tail = np.nonzero((body.vertices[body.triangles][:, :, 0] > 0.7).all(axis=1))[0]
    up, seen = strake.Motion(translation=[0, 0, 0.05]), []
    for fixed, moved in zip(ways_to_choose(nose(body), body.num_triangles), ways_to_choose(tail, body.num_triangles)):
        assert strake.Problem(body, fixed=fixed).fixed == sorted(nose(body))
        shell = strake.Shell(body, height=0.1, fixed=fixed, moved=[moved])
        assert shell.solve(motions=[up]).converged
        seen.append(shell.vertices)
    assert len(seen) == 10 and all(np.array_equal(one, seen[0]) for one in seen)
    assert strake.Problem(body, fixed=[]).fixed == strake.Problem(body, fixed=np.zeros(body.num_triangles, bool)).fixed == []


@pytest.mark.parametrize("chosen, words", [
    ([2.0, 3.0], "2.0"), (np.array([7.6, 1], dtype=np.float32), "7.6"), (np.ones(5, bool), "mask of 5 booleans, must be"),
    ([True, False], "mask of 2"), ([-1], "triangle -1, limits 0 and"), ([10**6], "triangle 1000000, limits 0 and"),
    ([10**30], "must be triangle numbers"), (np.array([2**63], dtype=np.uint64), "9223372036854775808"), ("abc", "'abc'"),
    (3, "shape ()"), ([[1, 2]], "shape (1, 2)"), ({1, 2}, "{1, 2}"), (None, "None"), ([1 + 2j], "1"), ([None], "None"),
])
def test_what_chooses_no_triangles_is_refused(body, chosen, words):
    for make, argument in ((lambda: strake.Problem(body, fixed=chosen), "Problem: fixed"),
                           (lambda: strake.Shell(body, height=0.1, fixed=chosen), "Shell: fixed"),
                           (lambda: strake.Shell(body, height=0.1, moved=[[1], chosen]), "Shell: moved[1]")):
        with pytest.raises(strake.InvalidInput) as caught:
            make()
        assert argument in str(caught.value) and words in str(caught.value)


def test_a_mask_in_place_of_a_list_of_choices_is_refused(body):
    with pytest.raises((strake.InvalidInput, TypeError)):
        strake.Shell(body, height=0.1, moved=np.ones(body.num_triangles, bool))


def test_a_body_that_nothing_holds(body):
    with pytest.raises(strake.UnheldPart):
        strake.Shell(body, height=0.1).solve(strake.traction_forces(body, traction(body)))


def test_wrong_arrays(body, shell):
    with pytest.raises(strake.InvalidInput, match="5 rows"):
        shell.solve(np.zeros((5, 3)))
    bad = np.zeros_like(body.vertices)
    bad[3, 1] = np.inf
    with pytest.raises(strake.InvalidInput, match="row 3"):
        shell.solve(bad)
    with pytest.raises(TypeError):
        shell.solve("force")
