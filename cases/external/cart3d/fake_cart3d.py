#!/usr/bin/env python3
"""Stands for Cart3D where it is not installed: reads and writes the files that the package reads and writes, strictly, and has
Newton's impact theory in place of a flow.

    fake_cart3d.py autoInputs|cubes|mgPrep|flowCart [OPTIONS]   as the programs of these names
    fake_cart3d.py components SURFACE.obj OUT.tri               the example's surface with its three components
"""
import math
import os
import re
import sys

sys.dont_write_bytecode = True  # no __pycache__ beside the case
sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), ".."))
from newton import force
from played import mark_of, need, save, stop
from volume import cross, dot, read_obj

SURFACE = "Components.i.tri"


def read_tri(name):
    """Vertices, triangles from 0, component ids: a wetted surface, closed and oriented outward."""
    try:
        with open(name, encoding="ascii") as file:
            numbers = file.read().split()
    except OSError as error:
        stop(f"{name}: {error.strerror}")
    num_vertices, num_triangles = int(numbers[0]), int(numbers[1])
    ends = [2, 2 + 3 * num_vertices, 2 + 3 * num_vertices + 3 * num_triangles]
    if len(numbers) != ends[2] + num_triangles:
        stop(f"{name}: {len(numbers)} numbers; {num_vertices} vertices and {num_triangles} triangles with components are "
             f"{ends[2] + num_triangles}")
    rows = lambda at, end, kind: [tuple(map(kind, numbers[k:k + 3])) for k in range(at, end, 3)]
    vertices = rows(ends[0], ends[1], float)
    triangles = [tuple(k - 1 for k in row) for row in rows(ends[1], ends[2], int)]
    components = list(map(int, numbers[ends[2]:]))
    if any(k < 0 or k >= num_vertices for row in triangles for k in row) or min(components) < 1:
        stop(f"{name}: vertices and components are counted from 1")
    if not all(math.isfinite(x) for v in vertices for x in v):
        stop(f"{name}: a coordinate is not finite")
    watertight(name, vertices, triangles)
    return vertices, triangles, components


def watertight(name, vertices, triangles):
    """Every edge has two triangles, which run along it in opposite directions, and the volume is positive."""
    edges = {(t[k], t[(k + 1) % 3]) for t in triangles for k in range(3)}
    bad = sum(1 for a, b in edges if (b, a) not in edges)
    if bad or len(edges) != 3 * len(triangles):
        stop(f"{name}: not watertight: {bad} open edges")
    if sum(dot(vertices[a], cross(vertices[b], vertices[c])) for a, b, c in triangles) <= 0:
        stop(f"{name}: triangles point into the body")


def write_tri(name, vertices, triangles, components):
    with open(name, "w", encoding="ascii") as file:
        file.write(f"{len(vertices)} {len(triangles)}\n")
        file.writelines("%r %r %r\n" % v for v in vertices)
        file.writelines("%d %d %d\n" % tuple(k + 1 for k in t) for t in triangles)
        file.writelines(f"{k}\n" for k in components)


def need_mesh(name):
    """A mesh of this example holds nothing but the mark of the surface that it was made about."""
    need(name, mark_of(SURFACE), "another surface")


def auto_inputs():
    read_tri(SURFACE)
    save("input.c3d", mark_of(SURFACE))
    save("preSpec.c3d.cntl", mark_of(SURFACE))


def cubes():
    read_tri(SURFACE)
    need_mesh("input.c3d")
    save("Mesh.R.c3d", mark_of(SURFACE))


def prepare_multigrid():
    need_mesh("Mesh.R.c3d")
    save("Mesh.mg.c3d", mark_of(SURFACE))


def labels():
    """{component id: name} of Config.xml."""
    with open("Config.xml", encoding="utf-8") as file:
        text = re.sub(r"<!--.*?-->", "", file.read(), flags=re.DOTALL)
    found = re.findall(r'<Component\s+Name="(\w+)"[^>]*Type="tri"[^>]*>\s*<Data>\s*Face Label=(\d+)\s*</Data>', text)
    return {int(number): name for name, number in found}


def control(key):
    """The first number behind a word in input.cntl."""
    with open("input.cntl", encoding="ascii") as file:
        found = re.search(rf"^{key}\s+(\S+)", file.read(), re.MULTILINE)
    if not found:
        stop(f"input.cntl: no {key}")
    return float(found[1])


def flow():
    vertices, triangles, components = read_tri(SURFACE)
    need_mesh("Mesh.mg.c3d")
    names = labels()
    if set(components) != set(names):
        stop(f"{SURFACE} has the components {sorted(set(components))}, Config.xml {sorted(names)}")
    alpha, area = math.radians(control("alpha")), control("Reference_Area")
    along = {"Drag Force (C_D)": (math.cos(alpha), 0.0, math.sin(alpha)),
             "Lift Force (C_L)": (-math.sin(alpha), 0.0, math.cos(alpha))}
    stream = along["Drag Force (C_D)"]
    parts = {"entire": triangles}
    for number, name in sorted(names.items()):
        parts[name] = [t for t, k in zip(triangles, components) if k == number]
    with open("loadsCC.dat", "w", encoding="ascii") as file:
        file.write("# Forces and moments on components\n")
        for name, part in parts.items():
            for title, direction in along.items():
                value = force(vertices, part, stream, (0, 0, 0), direction, (0, 0, 0))[0] / area
                file.write(f"{name:16s} {title}: {value!r}\n")


def make_components(surface, out):
    """Component 1 is the front fifth of the body, 3 the rear fifth, 2 what is between them."""
    vertices, triangles = read_obj(surface)
    low, high = min(v[0] for v in vertices), max(v[0] for v in vertices)
    middle = [sum(vertices[k][0] for k in t) / 3 for t in triangles]
    components = [1 if x < 0.8 * low + 0.2 * high else 3 if x > 0.2 * low + 0.8 * high else 2 for x in middle]
    write_tri(out, vertices, triangles, components)


if __name__ == "__main__":
    programs = {"autoInputs": auto_inputs, "cubes": cubes, "mgPrep": prepare_multigrid, "flowCart": flow}
    if len(sys.argv) == 4 and sys.argv[1] == "components":
        make_components(*sys.argv[2:])
    elif len(sys.argv) >= 2 and sys.argv[1] in programs:
        programs[sys.argv[1]]()
    else:
        sys.exit(__doc__)
