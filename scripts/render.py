#!/usr/bin/python3
"""Renders surfaces to a PNG with VTK, off screen (run it under xvfb-run where there is no display).

    render.py OUT.png FILE[:SCALARS] ... [--view front|top|side|left|rear|iso|below|DX,DY,DZ] [--edges] [--columns N]
              [--titles "before|after"] [--zoom Z] [--centre X,Y,Z] [--size W,H] [--feature-angle DEG] [--up y|z]

Each FILE (.obj .stl .ply .vtp) gets its own pane. `:SCALARS` colours by that cell or point field of a .vtp; integer
fields (patches) get one colour a value.
"""
import argparse
import colorsys
import sys

from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkFiltersCore import vtkFeatureEdges, vtkPolyDataNormals
from vtkmodules.vtkIOGeometry import vtkOBJReader, vtkSTLReader
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkIOPLY import vtkPLYReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import (vtkActor, vtkLightKit, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkTextActor,
                                         vtkWindowToImageFilter)
import vtkmodules.vtkRenderingFreeType  # noqa: F401 (registers the fonts)
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 (registers the back end)

VIEWS = {"front": (-1, 0, 0), "rear": (1, 0, 0), "top": (0, 0, 1), "below": (0, 0, -1), "side": (0, 1, 0),
         "left": (0, -1, 0), "iso": (-1, -1, 0.7)}
READERS = {"obj": vtkOBJReader, "stl": vtkSTLReader, "ply": vtkPLYReader, "vtp": vtkXMLPolyDataReader}


def read(path):
    ending = path.rsplit(".", 1)[-1].lower()
    if ending not in READERS:
        sys.exit(f"render.py: {path}: cannot read .{ending}; known: {', '.join(READERS)}")
    reader = READERS[ending]()
    reader.SetFileName(path)
    reader.Update()
    surface = reader.GetOutput()
    if surface.GetNumberOfCells() == 0:
        sys.exit(f"render.py: {path}: no triangles")
    return surface


def distinct_colours(count):
    """One colour a value; neighbours in number are far apart in hue."""
    table = vtkLookupTable()
    table.SetNumberOfTableValues(count)
    for k in range(count):
        red, green, blue = colorsys.hsv_to_rgb((k * 0.61803398875) % 1, 0.45 + 0.25 * (k % 2), 0.95 - 0.2 * (k % 3) / 2)
        table.SetTableValue(k, red, green, blue, 1)
    table.SetTableRange(0, count - 1)
    return table


def colour_by(mapper, surface, name, pane):
    data, in_cells = surface.GetCellData(), True
    if not data.HasArray(name):
        data, in_cells = surface.GetPointData(), False
    array = data.GetArray(name)
    if array is None:
        names = [d.GetArrayName(k) for d in (surface.GetCellData(), surface.GetPointData())
                 for k in range(d.GetNumberOfArrays())]
        sys.exit(f"render.py: no field '{name}'; fields: {', '.join(names) or 'none'}")
    data.SetActiveScalars(name)
    (mapper.SetScalarModeToUseCellData if in_cells else mapper.SetScalarModeToUsePointData)()
    low, high = array.GetRange(-1 if array.GetNumberOfComponents() > 1 else 0)
    if array.GetDataTypeAsString() in ("int", "long", "long long"):
        mapper.SetLookupTable(distinct_colours(int(high) + 1))
        mapper.SetScalarRange(0, max(int(high), 1))
        return
    table = vtkLookupTable()
    table.SetHueRange(0.667, 0)
    if array.GetNumberOfComponents() > 1:
        table.SetVectorModeToMagnitude()
    mapper.SetLookupTable(table)
    mapper.SetScalarRange(low, high if high > low else low + 1)
    bar = vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetTitle(name)
    bar.SetNumberOfLabels(4)
    bar.SetPosition(0.86, 0.1)
    bar.SetWidth(0.12)
    bar.SetHeight(0.5)
    pane.AddActor2D(bar)


def lines(surface, angle):
    """Boundaries and sharp edges, in black."""
    features = vtkFeatureEdges()
    features.SetInputData(surface)
    features.SetFeatureAngle(angle)
    features.ColoringOff()
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(features.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(0, 0, 0)
    actor.GetProperty().SetLineWidth(1.5)
    return actor


def pane_of(spec, options, title):
    path, _, scalars = spec.partition(":")
    surface = read(path)
    pane = vtkRenderer()
    pane.SetBackground(1, 1, 1)
    normals = vtkPolyDataNormals()
    normals.SetInputData(surface)
    normals.SetFeatureAngle(options.feature_angle)
    normals.ConsistencyOff()
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(normals.GetOutputPort())
    mapper.ScalarVisibilityOff()
    if scalars:
        mapper.ScalarVisibilityOn()
        normals.Update()
        mapper.SetInputData(normals.GetOutput())
        colour_by(mapper, normals.GetOutput(), scalars, pane)
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(0.80, 0.83, 0.87)
    actor.GetProperty().SetSpecular(0.25)
    actor.GetProperty().SetSpecularPower(30)
    if options.edges:
        actor.GetProperty().EdgeVisibilityOn()
        actor.GetProperty().SetEdgeColor(0.25, 0.25, 0.3)
    pane.AddActor(actor)
    pane.AddActor(lines(surface, options.feature_angle))
    if title:
        label = vtkTextActor()
        label.SetInput(title)
        label.GetTextProperty().SetColor(0, 0, 0)
        label.GetTextProperty().SetFontSize(20)
        label.SetPosition(14, 12)
        pane.AddActor2D(label)
    return pane, surface


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = sum(c * c for c in a) ** 0.5
    return tuple(c / length for c in a)


def frame_of(surfaces, direction, sky):
    """Extents of all surfaces in the picture's plane: ((left, right), (low, high)), and the plane's axes."""
    right = unit(cross(sky, direction))
    up = cross(direction, right)
    extents = []
    for axis in (right, up):
        values = [sum(x * a for x, a in zip(surface.GetPoint(k), axis))
                  for surface in surfaces for k in range(0, surface.GetNumberOfPoints())]
        extents.append((min(values), max(values)))
    return extents, right, up


def aim(panes, surfaces, options, width, height):
    """One camera for all panes, so that before and after are seen at the same scale."""
    direction = unit(VIEWS.get(options.view) or tuple(float(c) for c in options.view.split(",")))
    sky = (0, 1, 0) if options.up == "y" or abs(direction[2]) > 0.95 else (0, 0, 1)
    ((left, right_end), (low, high)), right, up = frame_of(surfaces, direction, sky)
    middle = tuple((left + right_end) / 2 * r + (low + high) / 2 * u for r, u in zip(right, up))
    if options.centre:
        middle = tuple(float(c) for c in options.centre.split(","))
    scale = 0.54 * max(high - low, (right_end - left) * height / width) / options.zoom
    reach = 10 * (right_end - left + high - low)
    for pane in panes:
        camera = pane.GetActiveCamera()
        camera.ParallelProjectionOn()
        camera.SetFocalPoint(*middle)
        camera.SetPosition(*(m + reach * d for m, d in zip(middle, direction)))
        camera.SetViewUp(*sky)
        camera.SetParallelScale(scale)
        pane.ResetCameraClippingRange()
        lights = vtkLightKit()
        lights.SetKeyLightIntensity(0.9)
        lights.AddLightsToRenderer(pane)


def window_of(panes, columns, width, height):
    """A window off screen with the panes row by row, each so wide and high."""
    rows = -(-len(panes) // columns)
    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(4)
    window.SetSize(width * columns, height * rows)
    for k, pane in enumerate(panes):
        row, column = divmod(k, columns)
        pane.SetViewport(column / columns, 1 - (row + 1) / rows, (column + 1) / columns, 1 - row / rows)
        window.AddRenderer(pane)
    return window


def save(window, out):
    window.Render()
    picture = vtkWindowToImageFilter()
    picture.SetInput(window)
    picture.ReadFrontBufferOff()
    writer = vtkPNGWriter()
    writer.SetInputConnection(picture.GetOutputPort())
    writer.SetFileName(str(out))
    writer.Write()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out")
    parser.add_argument("surfaces", nargs="+")
    parser.add_argument("--view", default="iso")
    parser.add_argument("--edges", action="store_true")
    parser.add_argument("--columns", type=int, default=0)
    parser.add_argument("--titles", default="")
    parser.add_argument("--up", choices="yz", default="z")
    parser.add_argument("--zoom", type=float, default=1.0)
    parser.add_argument("--centre", default="")
    parser.add_argument("--size", default="800,600")
    parser.add_argument("--feature-angle", type=float, default=35)
    options = parser.parse_args()
    width, height = (int(c) for c in options.size.split(","))
    titles = options.titles.split("|") if options.titles else []
    columns = options.columns or min(len(options.surfaces), 3)
    panes = [pane_of(spec, options, titles[k] if k < len(titles) else "") for k, spec in enumerate(options.surfaces)]
    window = window_of([pane for pane, _ in panes], columns, width, height)
    aim([pane for pane, _ in panes], [surface for _, surface in panes], options, width, height)
    save(window, options.out)


if __name__ == "__main__":
    main()
