#!/usr/bin/python3
"""Checks the includes of the sources against the order of the folders: check_structure.py [ROOT] [--self-test]

Fails, one line each, where
- a folder includes from a folder above it (ORDER), or the folders inside of one folder include each other in a circle,
- more than three units include each other in a circle,
- a folder has more than thirty units.
A unit is a name in a folder with all of its headers and sources: mesh.hpp and mesh.cpp are one.
Exit status: 0 nothing found, 1 something found, 2 wrong usage.
"""

import collections
import os
import re
import sys
import tempfile

# From the lowest folder to the highest; a folder may include those before it. One line is one floor: those on the same
# floor do not know each other. Folders that are not listed here must not form circles.
ORDER = {
    "": [["core"], ["objectives", "cases"], ["optimize"], ["casefile"], ["viewer"], ["report"], ["studio"], ["cli", "python", "bench"]],
    "optimize": [["nlp"], ["problem"], ["least_squares", "space"], ["journal"], ["evaluate"], ["run"], ["check"]],
    "casefile": [["yaml"], ["schema"], ["model"], ["read"], ["check"], ["build"], ["propose"]],
}
MAX_CIRCLE = 3
MAX_UNITS = 30
MAY_BE_LARGE = {"cli"}  # a file a command


def sources(root):
    for top in (name for floor in ORDER[""] for name in floor):
        for folder, _, names in os.walk(os.path.join(root, top)):
            for name in names:
                if name.endswith((".cpp", ".hpp")):
                    yield os.path.relpath(os.path.join(folder, name), root)


def includes(root, files):
    """{(unit, unit): "file:line"} of the first include from the one in the other."""
    include = re.compile(r'\s*#\s*include\s*"([^"]+)"')
    found = {}
    for file in sorted(files):
        with open(os.path.join(root, file), encoding="utf-8") as lines:
            for number, line in enumerate(lines, 1):
                match = include.match(line)
                if not match:
                    continue
                beside = os.path.normpath(os.path.join(os.path.dirname(file), match.group(1)))
                target = beside if beside in files else os.path.normpath(match.group(1))
                if target in files and unit(target) != unit(file):
                    found.setdefault((unit(file), unit(target)), f"{file}:{number}")
    return found


def unit(file):
    return os.path.splitext(file)[0]


def circles(pairs):
    """Sets of more than one node that reach each other (Tarjan's strongly connected components)."""
    following = collections.defaultdict(list)
    for a, b in sorted(pairs):
        following[a].append(b)
    number, low, stack, found = {}, {}, [], []

    def visit(node):
        number[node] = low[node] = len(number)
        stack.append(node)
        for other in following.get(node, ()):
            if other not in number:
                visit(other)
            if other in stack:
                low[node] = min(low[node], low[other])
        if low[node] == number[node]:
            members = []
            while node not in members:
                members.append(stack.pop())
            if len(members) > 1:
                found.append(sorted(members))

    sys.setrecursionlimit(10000)
    for node in sorted(following):
        if node not in number:
            visit(node)
    return found


def common_folder(a, b):
    """The innermost folder of both units, and the folder (or "." for its own files) of each inside of it."""
    a, b = a.split("/"), b.split("/")
    depth = 0
    while a[depth] == b[depth]:
        depth += 1
    part = lambda path: path[depth] if len(path) > depth + 1 else "."
    return "/".join(a[:depth]), part(a), part(b)


def check(root):
    files = set(sources(root))
    found = includes(root, files)
    problems = []
    between = collections.defaultdict(dict)  # of each folder: {(folder inside, folder inside): "file:line includes unit"}
    for (a, b), place in sorted(found.items()):
        parent, one, other = common_folder(a, b)
        if one == other:
            continue
        floors = {name: level for level, floor in enumerate(ORDER.get(parent, [])) for name in floor}
        if one in floors and other in floors:
            if floors[one] <= floors[other]:
                problems.append(f"{place} includes {b}: {one}/ is not above {other}/ (ORDER in scripts/check_structure.py)")
        else:
            between[parent].setdefault((one, other), f"{place} includes {b}")
    for parent, pairs in sorted(between.items()):
        for members in circles(pairs):
            inside = [place for (a, b), place in sorted(pairs.items()) if a in members and b in members]
            names = ", ".join(f"{parent}/{name}" if name != "." else f"{parent}/'s own files" for name in members)
            problems.append(f"circle of folders: {names}: " + "; ".join(inside))
    for members in circles(found):
        if len(members) > MAX_CIRCLE:
            inside = [f"{place} includes {b}" for (a, b), place in sorted(found.items()) if a in members and b in members]
            problems.append(f"circle of {len(members)} units (limit: {MAX_CIRCLE}): {', '.join(members)}: " + "; ".join(inside))
    count = collections.Counter(os.path.dirname(name) for name in {unit(file) for file in files})
    for folder, units in sorted(count.items()):
        if units > MAX_UNITS and folder not in MAY_BE_LARGE:
            problems.append(f"{folder}/ has {units} units (limit: {MAX_UNITS}): split it by what belongs together")
    return problems, len(count), len({unit(file) for file in files})


def self_test():
    """Small trees, each with what must (or must not) be found."""
    def tree(*pairs):
        return {a: [b for x, b in pairs if x == a] for a in {name for pair in pairs for name in pair}}

    ring = lambda n, folder: [(f"{folder}/u{i}.hpp", f"{folder}/u{(i + 1) % n}.hpp") for i in range(n)]
    cases = [
        ("a good tree", tree(("cli/run.cpp", "optimize/run/run.hpp"), ("optimize/run/run.cpp", "optimize/nlp/nlp.hpp"),
                             ("optimize/nlp/nlp.hpp", "core/mesh/mesh.hpp"), ("core/mesh/mesh.hpp", "core/error.hpp")), None),
        ("from core to optimize", tree(("core/mesh/mesh.cpp", "optimize/nlp/nlp.hpp")), "core/mesh/mesh.cpp:1 includes optimize/nlp/nlp"),
        ("from nlp to run", tree(("optimize/nlp/sqp/sqp.cpp", "optimize/run/run.hpp")), "nlp/ is not above run/"),
        ("on one floor", tree(("cli/run.cpp", "bench/table.hpp")), "cli/ is not above bench/"),
        ("a circle of folders", tree(("core/mesh/a.hpp", "core/primo/b.hpp"), ("core/primo/c.hpp", "core/mesh/d.hpp")),
         "circle of folders: core/mesh, core/primo"),
        ("a circle of folders below", tree(("core/a/x/p.hpp", "core/a/y/q.hpp"), ("core/a/y/r.hpp", "core/a/x/s.hpp")),
         "circle of folders: core/a/x, core/a/y"),
        ("a folder and its own files", tree(("core/a/p.hpp", "core/q.hpp"), ("core/r.hpp", "core/a/s.hpp")), "core/'s own files"),
        ("three units in a circle", tree(*ring(3, "core/mesh")), None),
        ("four units in a circle", tree(*ring(4, "core/mesh")), "circle of 4 units"),
        ("a circle through a header and a source", tree(*ring(4, "core/mesh")[:-1], ("core/mesh/u3.cpp", "core/mesh/u0.hpp")),
         "circle of 4 units"),
        ("thirty units", {f"core/mesh/u{i}.cpp": [] for i in range(30)}, None),
        ("thirty-one units", {f"core/mesh/u{i}.cpp": [] for i in range(31)}, "core/mesh/ has 31 units"),
        ("commands", {f"cli/u{i}.cpp": [] for i in range(40)}, None),
    ]
    failed = 0
    for name, files, expected in cases:
        with tempfile.TemporaryDirectory() as root:
            for file, targets in files.items():
                os.makedirs(os.path.dirname(os.path.join(root, file)), exist_ok=True)
                with open(os.path.join(root, file), "w", encoding="utf-8") as out:
                    out.writelines(f'#include "{target}"\n' for target in targets)
            problems, _, _ = check(root)
        good = not problems if expected is None else any(expected in problem for problem in problems)
        if not good:
            failed += 1
            print(f"self-test '{name}': expected {expected or 'nothing'}, found: {problems or 'nothing'}")
    print(f"self-test: {len(cases)} trees, {failed} wrong")
    return failed


def main():
    arguments = sys.argv[1:]
    if "--self-test" in arguments:
        arguments.remove("--self-test")
        if self_test():
            return 1
    if len(arguments) > 1 or any(argument.startswith("-") for argument in arguments):
        print(__doc__.split("\n")[0], file=sys.stderr)
        return 2
    root = arguments[0] if arguments else os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    problems, folders, units = check(root)
    print(*problems, sep="\n", end="\n" if problems else "")
    print(f"{units} units in {folders} folders, {len(problems)} problems")
    if units == 0:
        print(f"{root}: no sources", file=sys.stderr)
        return 2
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
