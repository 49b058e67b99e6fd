import json
import os
import subprocess
import sys

import numpy as np
import pytest

import explicit_component
import scipy_minimize
import strake
from conftest import nose

CASE = """case: body
surface: {file: body.obj}
regions: {nose: {box: [[-2, -2, -2], [-0.6, 2, 2]]}}
fixed: [nose]
shell: {thickness: 5%}
parameters: {levels: auto, patches_per_level: [2, 4], variables: [normal]}
objective: {maximize: volume}
constraints: {area: {max: 1.01, relative: true}}
optimize: {budget: {evaluations: 8}}
"""


def problem_of(body):
    problem = strake.Problem(body, thickness=0.05, fixed=nose(body), tree=strake.patches(body, patches_per_level=[2, 4]),
                             variables=["normal"])
    problem.maximize("volume")
    problem.constrain("area", max=1.01, relative=True)
    problem.options(max_evaluations=8)
    return problem


def test_yaml_and_python_give_the_same_bits(body, program, tmp_path):
    strake.write_surface(tmp_path / "body.obj", body)
    (tmp_path / "case.yaml").write_text(CASE)
    out = subprocess.run([program, "run", "case.yaml", "--out", "run", "--json", "-q"], cwd=tmp_path, check=False,
                         stdout=subprocess.PIPE)
    told = json.loads(out.stdout)
    seen = []
    result = strake.run(problem_of(body), callback=seen.append)
    loaded = strake.run(strake.load_case(tmp_path / "case.yaml"))
    best = strake.read_surface(tmp_path / "run/best.obj")
    for one in (result, loaded):
        assert one.status == told["status"] and one.evaluations == told["evaluations"]
        assert one.objective == told["objective"]
        assert np.array_equal(one.vertices, best.vertices)
    rows = (tmp_path / "run/history.csv").read_text().splitlines()[1:]
    assert [e.evaluation for e in seen] == [int(row.split(",")[0]) for row in rows]
    assert [e.objective for e in seen] == [float(row.split(",")[3]) for row in rows]
    assert result.done and result.values[result.names.index("volume")] > body.volume


def egg(n=12):
    """Thicker at one end, with left and right alike to the last triangle: squares cut crosswise."""
    u, around = np.meshgrid(np.linspace(-1, 1, n + 1), 2 * np.pi * np.arange(n) / n, indexing="ij")
    corners = [u, 0.5 * np.cos(around) * (1.2 + 0.3 * u), 0.3 * np.sin(around) * (1.2 - 0.2 * u)]
    corners = np.stack([np.round(c, 12) for c in corners], axis=-1).reshape(-1, 3)
    at = lambda i, j: i * n + j % n
    squares = np.array([[at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)] for i in range(n) for j in range(n)])
    ends = [[at(0, j + 1), at(0, j)] for j in range(n)], [[at(n, j), at(n, j + 1)] for j in range(n)]
    tips = len(corners) + len(squares)
    vertices = np.vstack([corners, corners[squares].mean(axis=1), [[-1.3, 0, 0], [1.3, 0, 0]]])
    triangles = [[len(corners) + k, s[c], s[(c + 1) % 4]] for k, s in enumerate(squares) for c in range(4)]
    triangles += [[tips + end, *edge] for end in (0, 1) for edge in ends[end]]
    surface = strake.Surface(vertices, np.array(triangles, dtype=np.int32))
    return surface if surface.volume > 0 else strake.Surface(vertices, surface.triangles[:, ::-1].copy())


def test_mirror_ties_the_two_sides():
    body = egg()
    lopsided = body.vertices.copy()
    lopsided[:, 2] *= 1 + 0.3 * (lopsided[:, 1] > 0.1)

    def unevenness(**how):
        problem = strake.Problem(body, thickness=0.05, fixed=nose(body), tree=strake.patches(body, patches_per_level=[4]), **how)
        problem.add_target("distance", strake.Surface(lopsided, body.triangles), same_triangles=True)
        problem.minimize("distance")
        problem.options(max_evaluations=6)
        v = strake.run(problem).vertices
        image = v * [1, -1, 1]
        return max(np.linalg.norm(v - each, axis=1).min() for each in image)

    assert unevenness() > 1e-3
    assert unevenness(mirror=True) < 1e-9
    with pytest.raises(strake.InvalidInput, match="mirror: the surface has no plane of symmetry"):
        strake.Problem(strake.Surface(body.vertices + 0.1 * body.vertices[:, [1, 2, 0]] ** 2, body.triangles), mirror=True)


def test_a_run_keeps_the_folder_of_the_program(body, program, tmp_path):
    strake.write_surface(tmp_path / "body.obj", body)
    (tmp_path / "case.yaml").write_text(CASE)
    subprocess.run([program, "run", "case.yaml", "--out", "theirs", "-q"], cwd=tmp_path, check=False, stdout=subprocess.DEVNULL)
    seen = []
    case = strake.load_case(tmp_path / "case.yaml")
    result = strake.run(case, callback=lambda e: seen.append(e.evaluation), output=tmp_path / "ours")
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    for name in ("history.csv", "best.obj", "levels/best.design", "series.pvd"):
        assert (ours / name).read_bytes() == (theirs / name).read_bytes(), name
    assert {f.name for f in ours.iterdir()} == {f.name for f in theirs.iterdir()}
    assert json.loads((ours / "run.json").read_text())["status"] == result.status
    assert seen == list(range(1, result.evaluations + 1))
    told = json.loads(subprocess.run([program, "status", "ours", "--json"], cwd=tmp_path, check=True, stdout=subprocess.PIPE).stdout)
    assert told["evaluations"] == result.evaluations and told["status"] == result.status
    with pytest.raises(strake.OutputError, match="ours"):
        strake.run(case, output=tmp_path / "ours")  # a run is never overwritten


def test_a_stopped_run_in_a_folder_goes_on(body, program, tmp_path):
    strake.write_surface(tmp_path / "body.obj", body)
    (tmp_path / "case.yaml").write_text(CASE)
    case = strake.load_case(tmp_path / "case.yaml")
    whole = strake.run(case)
    stopped = strake.run(case, callback=lambda e: e.evaluation < 3, output=tmp_path / "run")
    assert stopped.status == "interrupted" and stopped.evaluations < whole.evaluations
    out = subprocess.run([program, "resume", "run", "--json", "-q"], cwd=tmp_path, check=False, stdout=subprocess.PIPE)
    told = json.loads(out.stdout)
    assert told["objective"] == whole.objective and told["evaluations"] == whole.evaluations


def test_the_budget_of_a_run_in_a_folder_is_the_one_given(body, program, tmp_path):
    strake.write_surface(tmp_path / "body.obj", body)
    (tmp_path / "case.yaml").write_text(CASE)
    (tmp_path / "less.yaml").write_text(CASE.replace("evaluations: 8", "evaluations: 3"))
    case = strake.load_case(tmp_path / "case.yaml")
    case.options(max_evaluations=3)
    assert strake.run(case, output=tmp_path / "ours").evaluations == 3
    subprocess.run([program, "run", "less.yaml", "--out", "theirs", "-q"], cwd=tmp_path, check=True, stdout=subprocess.DEVNULL)
    ends = []
    for folder in ("ours", "theirs"):
        arguments = [program, "resume", folder, "--evaluations", "8", "--json", "-q"]
        ends.append(json.loads(subprocess.run(arguments, cwd=tmp_path, check=True, stdout=subprocess.PIPE).stdout))
    assert ends[0]["evaluations"] == ends[1]["evaluations"] > 3 and ends[0]["objective"] == ends[1]["objective"]


def test_what_a_folder_cannot_hold_is_refused(body, tmp_path):
    strake.write_surface(tmp_path / "body.obj", body)
    (tmp_path / "case.yaml").write_text(CASE)
    changed = [strake.load_case(tmp_path / "case.yaml") for _ in range(4)]
    changed[0].add_quantity("mine", lambda surface, want_gradient: 1.0, gradient=False)
    changed[1].minimize("area")
    changed[2].constrain("volume", min=0.5, relative=True)
    changed[3].options(seed=3)
    for problem in [*changed, problem_of(body)]:
        with pytest.raises(strake.InvalidInput, match="output"):
            strake.run(problem, output=tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_a_quantity_in_python_is_as_good_as_a_built_in_one(body):
    built_in = problem_of(body)
    own = strake.Problem(body, thickness=0.05, fixed=nose(body), tree=built_in.tree, variables=["normal"])
    asked = []

    def room(surface, want_gradient):
        asked.append(want_gradient)
        value, gradient = scipy_minimize.volume(surface.vertices, surface.triangles)
        return (value, gradient) if want_gradient else value

    own.add_quantity("room", room)
    own.maximize("room")
    own.constrain("area", max=1.01, relative=True)
    own.options(max_evaluations=8)
    one, other = strake.run(built_in), strake.run(own)
    assert any(asked) and one.objective == pytest.approx(other.objective, rel=1e-9)
    assert one.vertices == pytest.approx(other.vertices, abs=1e-9)


def test_exceptions_come_out_of_run(body):
    problem = problem_of(body)

    def broken(surface, want_gradient):
        raise KeyError("mine")

    problem.add_quantity("broken", broken)
    problem.minimize("broken")
    with pytest.raises(KeyError, match="mine"):
        strake.run(problem)

    def stop(evaluation):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        strake.run(problem_of(body), callback=stop)
    again = strake.run(problem_of(body))  # nothing is left over
    assert again.done


def test_a_callback_can_end_the_run(body):
    result = strake.run(problem_of(body), callback=lambda e: e.evaluation < 3)
    assert result.status == "interrupted" and result.evaluations <= 4
    assert len(result.vertices) == body.num_vertices


def test_a_failed_evaluation_shortens_the_step(body):
    problem, failed = problem_of(body), []
    start = body.volume

    def careful(surface, want_gradient):
        value, gradient = scipy_minimize.volume(surface.vertices, surface.triangles)
        if value > 1.02 * start:
            failed.append(value)
            raise strake.EvaluationFailed("too big for me")
        return (value, gradient) if want_gradient else value

    problem.add_quantity("careful", careful)
    problem.maximize("careful")
    seen = []
    result = strake.run(problem, callback=seen.append)
    assert failed and any("too big for me" in e.reason for e in seen)
    assert start < result.objective <= 1.02 * start


def test_not_a_number_from_a_quantity_is_no_value(body):
    problem = problem_of(body)
    problem.add_quantity("odd", lambda surface, want_gradient: float("nan"))
    problem.minimize("odd")
    try:
        result = strake.run(problem)
    except (strake.Error, RuntimeError):
        return
    assert not result.done


FLAT = "flat"


@pytest.mark.parametrize("value, words", [
    (None, r"returned None \(NoneType\)"), ("three", r"returned 'three' \(str\)"), ((1.0,), "returned 1 things"),
    (1 + 2j, r"returned \(1\+2j\) \(complex\)"), (10**400, r"\(int\), which is too large for a float"),
    ([1.0], r"returned \[1.0\] \(list\)"), ((1.0, "steep"), "is not an array of floats"),
    ((1.0, np.zeros((2, 3))), r"gradient has shape \(2, 3\), must be \(\d+, 3\)"),
    (FLAT, r"has shape \(\d+,\), must be \(\d+, 3\).*reshape\(-1, 3\)")])
def test_nonsense_from_a_quantity_is_refused_with_its_name(body, value, words):
    if value is FLAT:
        value = (1.0, np.zeros(3 * body.num_vertices))
    problem = problem_of(body)
    problem.add_quantity("odd", lambda surface, want_gradient: value)
    problem.minimize("odd")
    with pytest.raises(strake.InvalidInput, match="quantity 'odd': the .*" + words):
        strake.run(problem)


def test_old_names_are_read_with_a_warning(body):
    with pytest.warns(DeprecationWarning, match="'load_normal' is now 'normal'; the old name goes at 1.0"):
        strake.Problem(body, fixed=nose(body), variables=["load_normal"])
    with pytest.warns(DeprecationWarning, match="'slsqp' is now 'sqp'"):
        problem_of(body).options(method="slsqp")


def test_half_a_body_is_refused_before_the_optimization(body, tmp_path):
    open_body = strake.Surface(body.vertices, body.triangles[1:])
    strake.write_surface(tmp_path / "open.obj", open_body)
    ended = subprocess.run([sys.executable, scipy_minimize.__file__, tmp_path / "open.obj"], text=True, timeout=60,
                           stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    assert ended.returncode == 1 and "the surface is open" in ended.stdout and "Traceback" not in ended.stdout


def test_a_function_of_other_arguments_is_refused_when_it_is_added(body):
    problem = problem_of(body)
    for wrong in (lambda surface: 1.0, lambda: 1.0, lambda a, b, c: 1.0):
        with pytest.raises(strake.InvalidInput, match=r"quantity 'q': the function must take two arguments, \(surface, want_gradient\)"):
            problem.add_quantity("q", wrong)
    problem.add_quantity("q", lambda surface, want_gradient=False, more=0: 1.0)
    problem.add_quantity("r", max)  # a built-in one does not say what it takes


def test_auto_takes_a_method_that_needs_no_gradients(body):
    def run(method):
        problem = problem_of(body)
        problem.add_quantity("height", lambda surface, want_gradient: float(np.ptp(surface.vertices[:, 2])), gradient=False)
        problem.minimize("height")
        problem.options(method=method, max_evaluations=12)
        return strake.run(problem)

    chosen = run("auto")
    assert chosen.objective < chosen.objective_start
    assert np.array_equal(chosen.vertices, run("model").vertices)


def test_what_there_is_is_listed(body):
    problem = problem_of(body)
    problem.add_quantity("mine", lambda surface, want_gradient: 1.0)
    with pytest.raises(strake.InvalidInput, match="no quantity 'drag'; there are: volume, area, mine; others are added by add_quantity"):
        problem.minimize("drag")
    with pytest.raises(strake.InvalidInput, match="'bfgs' is none of auto, sqp, mma, .*cobyla"):
        problem.options(method="bfgs")
    problem.add_quantity("many", lambda surface, want_gradient: [1.0, np.zeros((100, 3))])
    problem.minimize("many")
    with pytest.raises(strake.InvalidInput) as told:
        strake.run(problem)
    assert "\n" not in str(told.value)


def test_the_import_asks_for_numpy(tmp_path):
    (tmp_path / "numpy.py").write_text("raise ImportError('hidden')")
    ended = subprocess.run([sys.executable, "-c", "import strake"], text=True, timeout=60, stdout=subprocess.PIPE,
                           stderr=subprocess.STDOUT, check=False,
                           env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ["PYTHONPATH"]])})
    assert ended.returncode == 1 and "ImportError: strake needs numpy: install it" in ended.stdout


def test_design_space_gradients(body):
    space = strake.DesignSpace(problem_of(body), level=2)
    assert len(space) == len(space.names) == len(space.units) == space.size > 2
    x = np.full(len(space), 0.2)
    component = explicit_component.ShapeComponent(space)
    component.setup()
    transposed, differences = explicit_component.check(component, x)
    assert transposed < 1e-8 and differences < 1e-5
    with pytest.raises(strake.InvalidInput, match="must be"):
        space.shape(np.zeros(1))
    with pytest.raises(strake.EvaluationFailed):
        space.shape(np.full(len(space), 1e6))
    space.reset()
    with pytest.raises(strake.InvalidInput, match="first"):
        space.gradient(np.zeros_like(body.vertices))
    assert np.abs(space.shape(np.zeros(len(space))) - body.vertices).max() < 1e-12


def test_scipy_drives_it(body):
    found, best = scipy_minimize.optimize(body, iterations=15)
    assert found.fun < 0.98
    assert best.volume > 0.999 * body.volume


def test_fit_recovers_a_known_shape(body):
    space = strake.DesignSpace(problem_of(body), level=1)
    target = body.with_vertices(space.shape(np.full(len(space), 0.4)))
    problem = strake.Problem(body, thickness=0.05, fixed=nose(body), tree=problem_of(body).tree, variables=["normal"])
    problem.add_target("match", target, same_triangles=True)
    result = strake.fit(problem, ["match"])
    assert np.abs(result.vertices - target.vertices).max() < 1e-5


def test_a_case_without_a_shell_moves_by_fields(body, tmp_path):
    strake.write_surface(tmp_path / "body.obj", body)
    changes = [("shell: {thickness: 5%}", "shell: none"),
               ("parameters: {levels: auto, patches_per_level: [2, 4], variables: [normal]}", "parameters: {fields: 12}")]
    text = CASE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "case.yaml").write_text(text)
    problem = strake.load_case(tmp_path / "case.yaml")
    space = strake.DesignSpace(problem, level=0)
    assert len(space) == 12 and space.names[0].startswith("section.")
    x = np.linspace(-0.2, 0.2, 12)
    moved = space.shape(x)
    weights = np.random.default_rng(1).normal(size=moved.shape)
    slope = space.gradient(weights)
    along = np.ones(12)
    assert np.allclose(space.response(along), space.shape(x + along * 1e-3) / 1e-3 - moved / 1e-3, atol=1e-9)
    assert np.isclose(slope @ along, np.sum(weights * space.response(along)), rtol=1e-10)
    with pytest.raises(strake.EvaluationFailed, match="fold|inverted|intersect|collapsed"):
        space.shape(60 * np.ones(12))
    assert strake.run(problem).objective > body.volume
