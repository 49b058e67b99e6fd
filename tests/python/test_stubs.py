"""The stubs say what the module has, and its documentation reads well."""
import ast
import inspect
import pathlib
import pydoc
import re

import strake

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


def arguments_told(function):
    """The same of the compiled function, from the first line of its documentation: name(a: type = value, *, b: type) -> c."""
    inside = re.match(r"\w+\((.*)\) -> ", function.__doc__.splitlines()[0])[1]
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


def test_stubs_have_the_arguments_of_the_module():
    compared = 0
    for node in TREE.body:
        thing = getattr(strake, getattr(node, "name", ""), None)
        if isinstance(node, ast.FunctionDef):
            assert arguments_of(node) == arguments_told(thing), node.name
            compared += 1
        elif isinstance(node, ast.ClassDef) and not issubclass(thing, Exception):
            for member in node.body:
                if isinstance(member, ast.FunctionDef) and not member.decorator_list:
                    told = arguments_told(getattr(thing, member.name))
                    assert arguments_of(member) == told, f"{node.name}.{member.name}"
                    compared += 1
    assert compared > 30


def test_everything_has_a_docstring():
    for name in strake.__all__:
        thing = getattr(strake, name)
        assert inspect.getdoc(thing), name
        assert thing.__module__ == "strake"


def test_help_reads_well():
    text = pydoc.render_doc(strake, renderer=pydoc.plaintext)
    assert "Shape optimization of surface triangulations" in text
    assert "_core" not in text.split("DATA")[0].split("PACKAGE CONTENTS")[-1].replace("\n    _core\n", "\n")
    assert "strake::" not in text and "Eigen" not in text, "names of C++ in the signatures"
    assert strake.__version__[0].isdigit()
