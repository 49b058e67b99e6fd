#include "report/paraview_script.hpp"

namespace strake {

std::string paraview_script() {
    return R"PY("""Before and after: the start shape on the left, the designs on the right, coloured by displacement.

    paraview --script=series.py      from this folder, or File > Load State

The time slider steps through the accepted designs (time is the evaluation number). Colour by patch_level_1, ...,
load or objective_sensitivity in the toolbar.
"""
import os

from paraview.simple import *

try:
    here = os.path.dirname(os.path.abspath(__file__))
except NameError:  # pasted into ParaView's shell
    here = os.getcwd()
series = PVDReader(registrationName="designs", FileName=os.path.join(here, "series.pvd"))
series.UpdatePipeline()
times = list(series.TimestepValues) if hasattr(series.TimestepValues, "__len__") else [series.TimestepValues]
scene = GetAnimationScene()
scene.UpdateAnimationUsingDataTimeSteps()

# Subtracting the displacement gives the start shape at any time.
start = Calculator(registrationName="start", Input=series)
start.CoordinateResults = 1
start.Function = "coords - displacement"

layout = CreateLayout("before and after")
left, right = (CreateView("RenderView", detachedFromLayout=True) for _ in range(2))
layout.SplitHorizontal(0, 0.5)
layout.AssignView(1, left)
layout.AssignView(2, right)
for view, source, words in ((left, start, "start"), (right, series, "design")):
    view.UseColorPaletteForBackground = 0
    view.Background = [1, 1, 1]
    view.OrientationAxesLabelColor = [0, 0, 0]
    shown = Show(source, view)
    ColorBy(shown, ("POINTS", "displacement", "Magnitude"))
    shown.SetScalarBarVisibility(view, view is right)
    if view is right:
        bar = GetScalarBar(GetColorTransferFunction("displacement"), view)
        bar.TitleColor = bar.LabelColor = [0, 0, 0]
        bar.Orientation, bar.WindowLocation = "Horizontal", "Lower Center"
    title = Text(registrationName=words + " (title)", Text=words)
    heading = Show(title, view)
    heading.WindowLocation = "Upper Center"
    heading.Color = [0, 0, 0]

scene.AnimationTime = times[-1]
colors = GetColorTransferFunction("displacement")
colors.ApplyPreset("Viridis (matplotlib)", True)
colors.RescaleTransferFunctionToDataRange = 0
series.UpdatePipeline(times[-1])
colors.RescaleTransferFunction(0, max(series.PointData["displacement"].GetRange(-1)[1], 1e-300))
for view in (left, right):
    SetActiveView(view)
    view.CameraPosition = [-1, -1.1, 0.8]
    view.CameraFocalPoint = [0, 0, 0]
    view.CameraViewUp = [0, 0, 1]
    ResetCamera(view)
AddCameraLink(left, right, "before and after")
SetActiveSource(series)
RenderAllViews()
)PY";
}

}  // namespace strake
