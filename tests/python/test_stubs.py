"""The stubs say what the module has, and its documentation reads well."""
import ast
import inspect
import pathlib
import pydoc

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
