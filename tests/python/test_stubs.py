"""The stubs say what the module has, and its documentation reads well."""
import ast
import inspect
import pathlib
import pydoc
import re

import pytest

import strake
from conftest import ROOT

TREE = ast.parse(pathlib.Path(strake.__file__).with_name("__init__.pyi").read_text())


def members(node):
    return {n.name for n in node.body if isinstance(n, ast.FunctionDef)} | {
        n.target.id for n in node.body if isinstance(n, ast.AnnAssign)}


def test_stubs_name_everything_and_nothing_else():
    stubs = {n.name: n for n in TREE.body if isinstance(n, (ast.ClassDef, ast.FunctionDef))}
    assert set(stubs) == set(strake.__all__)
    for name, node in stubs.items():
        if isinstance(node, ast.ClassDef) and not issubclass(getattr(strake, name), Exception):
            own = {m for m in vars(getattr(strake, name)) if not m.startswith("_")}
            assert own == {m for m in members(node) if not m.startswith("_")}, name


def arguments_of(node):
    """(name, kind, has a default) of each argument but self, of a stub."""
    a = node.args
    plain = [x.arg for x in a.posonlyargs + a.args]
    defaults = [False] * (len(plain) - len(a.defaults)) + [True] * len(a.defaults)
    found = list(zip(plain, ["plain"] * len(plain), defaults))
    found += [(x.arg, "keyword", d is not None) for x, d in zip(a.kwonlyargs, a.kw_defaults)]
    return [f for f in found if f[0] != "self"]


def arguments_shown(function):
    """The same as `help` shows them."""
    kinds = {inspect.Parameter.POSITIONAL_OR_KEYWORD: "plain", inspect.Parameter.KEYWORD_ONLY: "keyword"}
    return [(p.name, kinds[p.kind], p.default is not inspect.Parameter.empty)
            for p in inspect.signature(function).parameters.values() if p.name != "self"]


def refusal(name, function):
    """What the compiled function says to arguments that it cannot have."""
    if name.endswith(".__init__"):
        function = getattr(strake, name.split(".", maxsplit=1)[0])
    elif "." not in name:
        function = getattr(strake._core, name)  # that of the package only hands over to it
    with pytest.raises(TypeError) as caught:
        function(no_such_argument=0)
    return str(caught.value)


def arguments_taken(name, function):
    """The same as the compiled function tells them when it refuses a call: 1. (a: type = value, *, b: type) -> c."""
    inside = re.search(r"1\. (?:[\w.]+)?\((.*)\)(?: -> .*)?$", refusal(name, function), re.M)[1]
    parts, depth, start = [], 0, 0
    for at, letter in enumerate(inside + ","):
        depth += (letter in "[(<") - (letter in "])>")
        if letter == "," and depth == 0:
            parts.append(inside[start:at].strip())
            start = at + 1
    found, kind = [], "plain"
    for part in filter(None, parts):
        if part == "*":
            kind = "keyword"
        elif not part.startswith("self:"):
            found.append((part.split(":")[0], kind, " = " in part))
    return found


def functions():
    """(name, the stub, the function) of every function and method."""
    for node in TREE.body:
        thing = getattr(strake, getattr(node, "name", ""), None)
        if isinstance(node, ast.FunctionDef):
            yield node.name, node, thing
        elif isinstance(node, ast.ClassDef) and not issubclass(thing, Exception):
            for member in node.body:
                if isinstance(member, ast.FunctionDef) and not member.decorator_list:
                    yield f"{node.name}.{member.name}", member, getattr(thing, member.name)


def documented():
    """(name, docstring) of the module, its functions and classes, and all their public members."""
    yield "strake", strake.__doc__
    for name in strake.__all__:
        thing = getattr(strake, name)
        yield name, thing.__doc__
        if inspect.isclass(thing) and not issubclass(thing, Exception):
            for member, value in vars(thing).items():
                if not member.startswith("_") or (member == "__init__" and f"{name}.__init__" in dict(STUBBED)):
                    yield f"{name}.{member}", inspect.getattr_static(thing, member).__doc__ if isinstance(
                        value, property) else getattr(thing, member).__doc__


STUBBED = [(name, node) for name, node, _ in functions()]


def test_stubs_help_and_module_have_the_same_arguments():
    compared = 0
    for name, node, function in functions():
        assert arguments_of(node) == arguments_shown(function) == arguments_taken(name, function), name
        compared += 1
    assert compared > 30


def test_defaults_that_help_shows_are_those_that_are_taken():
    compared = 0
    for name, _, function in functions():
        told = refusal(name, function)
        for p in inspect.signature(function).parameters.values():
            if isinstance(p.default, (int, float, str, list)):  # bool is an int
                assert re.search(rf"\b{p.name}: [\w.\[\], ]+ = {re.escape(repr(p.default))}[,)]", told), (name, p, told)
                compared += 1
    assert compared > 12


def test_everything_has_a_docstring():
    described = list(documented())
    for name, words in described:
        assert words and words.strip(), f"{name} has no docstring"
        assert words.strip().endswith((".", ")")), f"{name}: {words!r}"
    assert len(described) > 120
    for name in strake.__all__:
        assert getattr(strake, name).__module__ == "strake"


def test_every_argument_is_described():
    for name, node, function in functions():
        for argument, _, _ in arguments_of(node):
            assert f"`{argument}`" in function.__doc__, f"{name}: {argument}"


CPLUSPLUS = re.compile(r"::|\bstd\b|Eigen|\b_core\b|<lambda|pybind|numpy\.(ndarray|float64|int32)|\b(bool|int|double) const\b|&&|"
                       r"\b(vector|shared_ptr|unique_ptr|TriMesh|PatchHierarchy|PrimoShell|RigidMotion|RunResult|Points)\b")


def test_no_docstring_speaks_cplusplus():
    for name, words in documented():
        assert not CPLUSPLUS.search(words), f"{name}: {CPLUSPLUS.search(words)[0]}"
    for name, _, function in functions():
        assert not re.search(r"::|Eigen|\bstd\b|PythonProblem", refusal(name, function)), name


def test_help_reads_well():
    text = pydoc.render_doc(strake, renderer=pydoc.plaintext)
    assert "Shape optimization of triangulated surfaces" in text
    assert "_core" not in text.split("DATA")[0].split("PACKAGE CONTENTS")[-1].replace("\n    _core\n", "\n")
    assert not re.findall(r"(?<![_\w])(?!add_note|with_traceback)[a-z]\w*\(\.\.\.\)", text)  # signatures that cannot be shown
    assert "PyCapsule" not in text and "    run(problem, callback=None, output=None)\n" in text
    on_one_line = re.sub(r"[\s|]+", " ", text).replace("( ", "(").replace(" )", ")")  # Python 3.13 breaks long signatures
    assert "solve(self, force=None, spring=None, motions=(), *, min_step=1e-09, max_iterations=60)" in on_one_line
    assert strake.__version__[0].isdigit()


def test_the_reference_page_is_that_of_the_module(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "scripts"))
    import python_reference  # pylint: disable=import-outside-toplevel
    page = python_reference.reference()
    for name in strake.__all__:
        assert f"### {name}\n" in page or f"| `{name}` |" in page, name
    kept = (ROOT / "docs/python-reference.md").read_text(encoding="utf-8")
    assert page == kept, "scripts/python_reference.py > docs/python-reference.md writes it anew"


def test_the_example_of_the_module_runs(body, tmp_path, monkeypatch, capsys):
    example = re.search(r"\n    import numpy as np\n.*?(?=\n\nContents, from)", strake.__doc__, re.S)[0]
    wing = body.with_vertices(body.vertices + [0, 0.6, 0])
    strake.write_surface(tmp_path / "wing.stl", wing)
    monkeypatch.chdir(tmp_path)
    lines = [line[4:] for line in example.splitlines()]
    code = "\n".join(lines).replace("y < 0.05", "y < 0.25").replace("symmetry=((0, 1, 0), 0.0)", "tree=strake.patches(wing, patches_per_level=[2])")
    code = code.replace("result =", "problem.options(max_evaluations=4)\nresult =")
    exec(compile(code, "the module's docstring", "exec"), {})  # pylint: disable=exec-used
    assert (tmp_path / "bigger.stl").stat().st_size > 0 and "Evaluation 1" in capsys.readouterr().out
