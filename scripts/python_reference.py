#!/usr/bin/python3
"""The reference of the Python module, as Markdown: PYTHONPATH=build/release/python scripts/python_reference.py > docs/python-reference.md

Signatures with types from the stubs, words from the docstrings; a test compares the page with the module.
"""
import ast
import inspect
import pathlib
import re

import strake

STUBS = ast.parse(pathlib.Path(strake.__file__).with_name("__init__.pyi").read_text(encoding="utf-8"))
HEAD = """# Python reference

Made by `scripts/python_reference.py` from the module itself; `help(strake)` says the same. [Strake from Python](python.md) is where to begin.
Arrays are described by their shape: n vertices, m triangles. `Floats` and `Ints` are NumPy arrays of float64 and int32; `Triangles` are numbers of triangles, or a mask of
booleans; a `Plane` is (normal, offset); a `Path` is a string or an `os.PathLike`.
"""


def words(thing):
    """A docstring as Markdown: its examples, which are indented, stay code; signs of Markdown in sentences do not count."""
    out = []
    for line in (inspect.getdoc(thing) or "").splitlines():
        code = line.startswith("    ")
        out.append(line if code else re.sub(r"(?<!`)([*_<])(?![^`]*`(?:[^`]*`[^`]*`)*[^`]*$)", r"\\\1", line))
    return "\n".join(out)


def signature(name, node):
    """`name(arguments) -> type` by the stub, without self."""
    arguments = ast.unparse(node.args)
    arguments = re.sub(r"^self(, )?", "", arguments)
    result = f" -> {ast.unparse(node.returns)}" if node.returns and ast.unparse(node.returns) != "None" else ""
    return f"`{name}({arguments}){result}`".replace("'", '"')


def is_property(node):
    return any(ast.unparse(d) == "property" for d in node.decorator_list)


def class_reference(name, node):
    of = getattr(strake, name)
    lines = [f"### {name}", "", words(of), ""]
    for member in node.body:
        if isinstance(member, ast.AnnAssign):
            lines += [f"**`{member.target.id}: {ast.unparse(member.annotation)}`**", "", words(getattr(of, member.target.id)), ""]
        elif isinstance(member, ast.FunctionDef) and member.name == "__init__":
            lines += [f"**{signature(name, member)}**", "", words(of.__init__), ""]
        elif isinstance(member, ast.FunctionDef) and not member.name.startswith("_"):
            title = f"`{member.name}: {ast.unparse(member.returns)}`" if is_property(member) else signature(member.name, member)
            lines += [f"**{title}**", "", words(getattr(of, member.name)), ""]
    return lines


def reference():
    stubs = {n.name: n for n in STUBS.body if isinstance(n, (ast.ClassDef, ast.FunctionDef))}
    is_error = {name: isinstance(getattr(strake, name), type) and issubclass(getattr(strake, name), Exception) for name in stubs}
    lines = [HEAD, "## Functions", ""]
    for name, node in stubs.items():
        if isinstance(node, ast.FunctionDef):
            lines += [f"### {name}", "", f"**{signature(name, node)}**", "", words(getattr(strake, name)), ""]
    lines += ["## Classes", ""]
    for name, node in stubs.items():
        if isinstance(node, ast.ClassDef) and not is_error[name]:
            lines += class_reference(name, node)
    lines += ["## Errors", "", "| error | is also | when |", "|---|---|---|"]
    for name, node in stubs.items():
        if is_error[name]:
            bases = ", ".join(f"`{ast.unparse(b)}`" for b in node.bases)
            lines.append(f"| `{name}` | {bases} | {words(getattr(strake, name))} |")
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).rstrip() + "\n"


if __name__ == "__main__":
    print(reference(), end="")
