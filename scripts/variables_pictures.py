#!/usr/bin/python3
"""Makes the pictures of docs/variables.md with VTK (run it under xvfb-run): variables_pictures.py BIN OUT_FOLDER

BIN holds strake and make_surface. Pictures: variables-fields.png, what six of the first fields do to a wing; -patches.png, the displacement
by a load on one patch of each level; -hold.png, where fields move a wing that is held in three ways; -can_make.svg, the shares of
typical motions that fields and loads make, as `strake check` has them.
"""
import collections
import json
import pathlib
import subprocess
import sys
import tempfile
import types

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from render import aim, read, save, window_of  # noqa: E402
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy  # noqa: E402
from vtkmodules.vtkCommonCore import vtkLookupTable, vtkPoints  # noqa: E402
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData  # noqa: E402
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals  # noqa: E402
from vtkmodules.vtkFiltersHybrid import vtkPolyDataSilhouette  # noqa: E402
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer, vtkTextActor  # noqa: E402

WIDTH = 460  # of a pane; three beside each other
INK, ORANGE, GREY = (0, 0, 0), (0.85, 0.33, 0.08), (0.80, 0.83, 0.87)
BLUES = [(0.94, 0.95, 0.96), (0.66, 0.81, 0.91), (0.30, 0.58, 0.82), (0.06, 0.30, 0.60)]
BANDS = 10
LEVELS = [4, 16, 64]  # patches
HALF_WING = """surface: {file: wing.obj, units: m}
symmetry: {plane: y, at: 0}
regions:
  root: {box: [[-1, -1, -1], [3, 0.05, 1]]}
objective: {maximize: volume}
optimize: {budget: {evaluations: 12}}
"""
BODY = """surface: {file: body.obj, units: m}
regions:
  nose: {box: [[-1, -4, -4], [0.8, 4, 4]]}
  base: {plane: {normal: [1, 0, 0], at: 7.84}, side: above}
fixed: [nose, base]
objective: {maximize: volume}
optimize: {budget: {evaluations: 12}}
"""
# What the field does to a wing, its name, and the value of its variable.
FIELDS = [("sweep", "section.move_x.0", 2), ("bend", "section.move_z.2", 2), ("twist", "section.twist.0", 1.3),
          ("taper", "section.scale_x.0", -1.5), ("thickness", "section.scale_z.0", 0.5), ("span", "section.move_y.1", 2)]
PATCHES = ["p2", "p2.2", "p2.2.1"]  # one a level, each a part of the one before: the body's middle, its upper left side, the front of that
HOLDS = {"fixed: [root]": "hold: fixed (default)", "hold: point": "hold: point", "hold: none": "hold: none"}


class Modes:
    """The surface of a case and the displacement by each variable at x = 1."""

    def __init__(self, folder, words, level=1):
        (folder / "case.yaml").write_text("case: pictures\n" + words)
        self.facts = json.loads(strake(folder, "check", "case.yaml", "--level", level, "--modes", "modes.vtp", "--json"))
        self.data = read(str(folder / "modes.vtp"))
        self.points = vtk_to_numpy(self.data.GetPoints().GetData()).astype(float)
        self.triangles = vtk_to_numpy(self.data.GetPolys().GetConnectivityArray()).reshape(-1, 3)

    def by(self, variable):
        return vtk_to_numpy(self.data.GetPointData().GetArray(variable)).astype(float)

    def patch_of_triangle(self):
        return vtk_to_numpy(self.data.GetCellData().GetArray("patch"))


def strake(folder, *words):
    return subprocess.run([BIN / "strake", *map(str, words)], cwd=folder, check=True, stdout=subprocess.PIPE, text=True).stdout


def surface_of(points, triangles, scalars=None):
    surface, corners, cells = vtkPolyData(), vtkPoints(), vtkCellArray()
    corners.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=1))
    surface.SetPoints(corners)
    for triangle in triangles.tolist():
        cells.InsertNextCell(3, triangle)
    surface.SetPolys(cells)
    if scalars is not None:
        surface.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(scalars), deep=1))
    return surface


def blue_bands():
    table = vtkLookupTable()
    table.SetNumberOfTableValues(BANDS)
    for k in range(BANDS):
        at = k / (BANDS - 1) * (len(BLUES) - 1)
        low = min(int(at), len(BLUES) - 2)
        table.SetTableValue(k, *(a + (at - low) * (b - a) for a, b in zip(BLUES[low], BLUES[low + 1])), 1)
    return table


def shaded(surface, colour=GREY):
    """Its scalars from 0 to 1 in bands of blue, where it has any."""
    normals = vtkPolyDataNormals()
    normals.SetInputData(surface)
    normals.SetFeatureAngle(60)
    normals.ConsistencyOff()
    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputConnection(normals.GetOutputPort())
    mapper.SetScalarVisibility(surface.GetPointData().GetScalars() is not None)
    mapper.InterpolateScalarsBeforeMappingOn()
    mapper.SetLookupTable(blue_bands())
    mapper.SetScalarRange(0, 1)
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*colour)
    return actor


def drawn(mapper, colour, width):
    mapper.ScalarVisibilityOff()
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0, -8)
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*colour)
    actor.GetProperty().SetLineWidth(width)
    actor.GetProperty().LightingOff()
    return actor


def outline(surface, camera, colour, width=2):
    silhouette, mapper = vtkPolyDataSilhouette(), vtkPolyDataMapper()
    silhouette.SetInputData(surface)
    silhouette.SetCamera(camera)
    silhouette.SetEnableFeatureAngle(0)
    silhouette.BorderEdgesOn()
    mapper.SetInputConnection(silhouette.GetOutputPort())
    return drawn(mapper, colour, width)


def border(points, triangles, colour, width):
    """The edges around a set of triangles."""
    count = collections.Counter(tuple(sorted(edge)) for a, b, c in triangles.tolist() for edge in ((a, b), (b, c), (c, a)))
    edges, lines, mapper = surface_of(points, triangles[:0]), vtkCellArray(), vtkPolyDataMapper()
    for edge, times in count.items():
        if times == 1:
            lines.InsertNextCell(2, edge)
    edges.SetLines(lines)
    mapper.SetInputData(edges)
    return drawn(mapper, colour, width)


def titled(title):
    pane, label = vtkRenderer(), vtkTextActor()
    pane.SetBackground(1, 1, 1)
    label.SetInput(title)
    label.GetTextProperty().SetColor(*INK)
    label.GetTextProperty().SetFontSize(22)
    label.SetPosition(16, 12)
    pane.AddActor2D(label)
    return pane


def picture(name, panes, surfaces, view, height, raised, over=()):
    """@param raised the surfaces above the middle, in halves of a pane; @param over a drawing for each pane that nothing hides"""
    window = window_of(panes, 3, WIDTH, height)
    aim(panes, surfaces, types.SimpleNamespace(view=view, up="z", centre="", zoom=1.0), WIDTH, height)
    window.SetNumberOfLayers(2)
    for pane in panes:
        pane.GetActiveCamera().SetWindowCenter(0, -raised)
    for pane, actor in zip(panes, over):
        above = vtkRenderer()
        above.SetLayer(1)
        above.SetViewport(pane.GetViewport())
        above.SetActiveCamera(pane.GetActiveCamera())
        above.AddActor(actor)
        window.AddRenderer(above)
    save(window, OUT / name)
    print(OUT / name)


def fields(folder):
    modes = Modes(folder, HALF_WING + """fixed: [root]
parameters: {fields: {number: 12, axis: y}, variables: [], max_displacement: 6%}
""")
    start, panes, surfaces, over = surface_of(modes.points, modes.triangles), [], [], []
    for word, name, value in FIELDS:
        moved, pane = surface_of(modes.points + value * modes.by(name), modes.triangles), titled(f"{word}: {name}")
        pane.AddActor(shaded(moved))
        pane.AddActor(outline(moved, pane.GetActiveCamera(), INK))
        over.append(outline(start, pane.GetActiveCamera(), ORANGE))
        panes.append(pane)
        surfaces.append(moved)
    picture("variables-fields.png", panes, surfaces, "-0.7,1,0.8", 270, 0.13, over)


def patches(folder):
    tree = json.loads(strake(folder, "patches", "body.obj", "--angle", "auto", "--patches-per-level", ",".join(map(str, LEVELS)), "--json"))
    panes, surfaces = [], []
    for level, name in enumerate(PATCHES, 1):
        modes = Modes(folder, BODY + f"parameters: {{patches_per_level: {LEVELS}, variables: [normal], fields: none}}\n", level)
        number = {patch["name"]: patch["id"] for patch in tree["levels"][level - 1]["patches"]}[name]
        by_load = modes.by(f"{name}.load_normal")
        far = np.linalg.norm(by_load, axis=1)
        moved, pane = surface_of(modes.points + by_load, modes.triangles, far / far.max()), titled(f"level {level}: {name}.load_normal")
        pane.AddActor(shaded(moved))
        pane.AddActor(outline(moved, pane.GetActiveCamera(), INK))
        pane.AddActor(border(modes.points + by_load, modes.triangles[modes.patch_of_triangle() == number], INK, 3))
        panes.append(pane)
        surfaces.append(moved)
    picture("variables-patches.png", panes, surfaces, "-1,-1,0.8", 370, 0.1)


def held_triangles(modes, held):
    """Whether each triangle is held, by this line of the case."""
    corners = modes.points[modes.triangles]
    if held == "hold: none":
        return np.zeros(len(corners), bool)
    if held != "hold: point":
        low, high = np.array(next(region["box"] for region in modes.facts["regions"] if region["name"] == "root"))
        return ((corners >= low) & (corners <= high)).all((1, 2))
    point = corners[modes.facts["supports"]].mean((0, 1))
    return np.linalg.norm(corners.mean(1) - point, axis=1) < 0.035  # one triangle would hardly be seen


def hold(folder):
    found = [Modes(folder, HALF_WING + held + "\nparameters: {fields: 27, variables: []}\n") for held in HOLDS]
    far = [np.sqrt(np.mean([np.sum(modes.by(name) ** 2, axis=1) for name in modes.facts["fields"]], axis=0)) for modes in found]
    largest = max(np.quantile(f, 0.95) for f in far)
    panes, surfaces = [], []
    for held, modes, f in zip(HOLDS, found, far):
        surface, pane = surface_of(modes.points, modes.triangles, np.minimum(f / largest, 1)), titled(HOLDS[held])
        pane.AddActor(shaded(surface))
        pane.AddActor(outline(surface, pane.GetActiveCamera(), INK))
        pane.AddActor(shaded(surface_of(modes.points, modes.triangles[held_triangles(modes, held)]), ORANGE))
        panes.append(pane)
        surfaces.append(surface)
    picture("variables-hold.png", panes, surfaces, "-1,-0.6,0.55", 330, 0.13)


def shares_of_motions(folder):
    """Rows of (motion, shares): by 12 and 27 fields, then by loads on each level of patches; and the head of each column."""
    columns = []
    for words, levels in (("fields: 12, variables: []", 1), ("fields: 27, variables: []", 1), ("fields: none, variables: [normal]", 3),
                          ("fields: none, variables: [load]", 3)):
        (folder / "case.yaml").write_text("case: pictures\n" + HALF_WING + "fixed: [root]\n"
                                          f"parameters: {{patches_per_level: {LEVELS}, {words}}}\n")
        made = json.loads(strake(folder, "check", "case.yaml", "--json"))["can_make"]
        for k in range(levels):
            columns.append((made["levels"][k]["variables"], {m["motion"]: m["share"][k] for m in made["motions"]}))
    motions = [motion for motion in columns[0][1] if not motion.startswith("soft mode")]
    return [count for count, _ in columns], [(motion, [shares[motion] for _, shares in columns]) for motion in motions]


def can_make(folder):
    counts, rows = shares_of_motions(folder)
    groups = [("fields", 2, [""] * 2), ("variables: [normal]", 3, LEVELS), ("variables: [load]", 3, LEVELS)]
    cell, high, left, top, gap = 62, 24, 118, 78, 14
    places = [left + cell * k + gap * sum(k >= edge for edge in (2, 5)) for k in range(len(counts))]
    lines = [f'<text x="{left - 10}" y="{y}" text-anchor="end" fill="#555">{word}</text>' for y, word in ((48, "patches"), (68, "variables"))]
    first = 0
    for word, width, patch_counts in groups:
        middle = (places[first] + places[first + width - 1] + cell) / 2
        lines.append(f'<text x="{middle:.0f}" y="22" text-anchor="middle" font-weight="bold">{word}</text>')
        for x, patch_count, count in zip(places[first:], patch_counts, counts[first:]):
            lines += [f'<text x="{x + cell / 2:.0f}" y="{y}" text-anchor="middle" fill="#555">{number}</text>'
                      for y, number in ((48, patch_count), (68, count)) if number != ""]
        first += width
    for row, (motion, shares) in enumerate(rows):
        y = top + high * row
        lines.append(f'<text x="{left - 10}" y="{y + 17}" text-anchor="end">{motion}</text>')
        for x, share in zip(places, shares):
            colour = "#" + "".join(f"{round(255 * (a + share * (b - a))):02x}" for a, b in zip((1, 1, 1), BLUES[-1]))
            lines.append(f'<rect x="{x}" y="{y}" width="{cell - 2}" height="{high - 2}" fill="{colour}" stroke="#d5dde5"/>'
                         f'<text x="{x + cell / 2 - 1:.0f}" y="{y + 16}" text-anchor="middle" fill="{"white" if share > 0.45 else "black"}">'
                         f"{int(100 * share)}</text>")
    width, height = places[-1] + cell + 10, top + high * len(rows) + 8
    (OUT / "variables-can_make.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="13">'
        '\n<rect width="100%" height="100%" fill="white"/>\n' + "\n".join(lines) + "\n</svg>\n", encoding="utf-8")
    print(OUT / "variables-can_make.svg")


BIN, OUT = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for kind, file in (("wing", "wing.obj"), ("lifting_body", "body.obj")):
            subprocess.run([BIN / "make_surface", kind, "--triangles", "12000", "-o", folder / file], check=True, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL)
        fields(folder)
        patches(folder)
        hold(folder)
        can_make(folder)
