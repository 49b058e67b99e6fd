#!/usr/bin/python3
"""Wave drag of a body beside a wing by Euler's equations: OpenFOAM's rhoCentralFoam on a quarter of the space.

    wing_body_flow.py MACH CELLS BODY.obj WING.obj      D/q of both together, in squares of their unit

CELLS: cells on a length of the body near it, for example 160; the mesh is snappyHexMesh's. Body and wing are symmetric about y = 0 and
z = 0, and the stream is along x; the body goes from x = 0 to 1. Needs: scripts/setup.sh openfoam
"""
import os
import shutil
import sys

sys.dont_write_bytecode = True
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
HERE = os.path.dirname(os.path.realpath(__file__))
sys.path.insert(0, os.path.join(HERE, "../external/openfoam"))
import flow  # noqa: E402
import foam  # noqa: E402

COARSE = 0.1   # cells far away; halved towards the surfaces
STAGES = ((0.4, 1.0), (0.2, 0.5))  # Courant numbers, and steps for each cell on the length
MEAN = 100     # steps: the limiter leaves a ripple, which the mean takes out
STEADY = 1e-2  # largest difference between the means of the last steps and those before

CHANGES = {  # of the supersonic example: two planes of symmetry, sides that waves leave by, a wing
    **{f"0/{name}": [("symmetry { type symmetryPlane; }", "sides { type zeroGradient; }\n    left { type symmetryPlane; }\n    below { type symmetryPlane; }"),
                     ("body     {", "\"(body|wing)\" {")] for name in ("U", "p", "T")},
    "system/controlDict": [("maxCo             0.4;", "maxCo $courant;"), ("rDeltaTSmoothingCoeff 0.1;", "rDeltaTSmoothingCoeff 1;"),
                           ("(body);", "(body wing);"), ("Aref          0.5;", "Aref          0.25;")],
    "system/fvSchemes": [("Kurganov", "Tadmor")],
}

BLOCK = """scale 1;
vertices ((-0.3 0 0) (1.7 0 0) (1.7 1.2 0) (-0.3 1.2 0) (-0.3 0 1.2) (1.7 0 1.2) (1.7 1.2 1.2) (-0.3 1.2 1.2));
blocks (hex (0 1 2 3 4 5 6 7) (%d %d %d) simpleGrading (1 1 1));
edges ();
boundary
(
    inlet  { type patch; faces ((0 4 7 3)); }
    outlet { type patch; faces ((1 2 6 5)); }
    sides  { type patch; faces ((3 7 6 2) (4 5 6 7)); }
    left   { type symmetryPlane; faces ((0 1 5 4)); }
    below  { type symmetryPlane; faces ((0 3 2 1)); }
);
"""

SNAPPY = """castellatedMesh true;
snap            true;
addLayers       false;
geometry
{
    body.stl { type triSurfaceMesh; name body; }
    wing.stl { type triSurfaceMesh; name wing; }
    near     { type searchableBox; min (-0.05 -1 -1); max (1.1 0.3 0.1); }
}
castellatedMeshControls
{
    maxLocalCells 4000000; maxGlobalCells 4000000; minRefinementCells 0; nCellsBetweenLevels 4;
    features ();
    refinementSurfaces { body { level (%(level)d %(level)d); } wing { level (%(level)d %(level)d); } }
    resolveFeatureAngle 30;
    refinementRegions { near { mode inside; levels ((1e15 %(near)d)); } }
    locationInMesh (0.5137 1.0713 1.0331);
    allowFreeStandingZoneFaces true;
}
snapControls { nSmoothPatch 3; tolerance 2; nSolveIter 50; nRelaxIter 5; implicitFeatureSnap true; }
addLayersControls
{
    relativeSizes true; layers {} expansionRatio 1; finalLayerThickness 0.3; minThickness 0.1; nGrow 0; featureAngle 60; nRelaxIter 3;
    nSmoothSurfaceNormals 1; nSmoothNormals 3; nSmoothThickness 10; maxFaceThicknessRatio 0.5; maxThicknessToMedialRatio 0.3;
    minMedialAxisAngle 90; nBufferCellsNoExtrude 0; nLayerIter 50;
}
meshQualityControls
{
    maxNonOrtho 65; maxBoundarySkewness 20; maxInternalSkewness 4; maxConcave 80; minVol 1e-13; minTetQuality 1e-15;
    minArea -1; minTwist 0.02; minDeterminant 0.001; minFaceWeight 0.05; minVolRatio 0.01; minTriangleTwist -1;
    nSmoothScale 4; errorReduction 0.75;
}
mergeTolerance 1e-6;
"""


def write(folder, name, text, kind=None):
    with open(os.path.join(folder, name), "w", encoding="ascii") as file:
        file.write((foam.header(kind, os.path.basename(name)) if kind else "") + text)


def prepare(folder, body, wing, per_length):
    """A case of OpenFOAM's: gas, scheme and forces of the supersonic example with these changes; returns its cells."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(os.path.join(HERE, "../external/openfoam_supersonic/foam"), folder)
    for name, changes in CHANGES.items():
        with open(os.path.join(folder, name), encoding="ascii") as file:
            text = file.read()
        for before, after in changes:
            if before not in text:
                foam.fail(f"{folder}/{name}: no '{before}'")
            text = text.replace(before, after)
        write(folder, name, text)
    os.makedirs(os.path.join(folder, "constant/triSurface"))
    for name, surface in (("body", body), ("wing", wing)):
        foam.write_stl(os.path.join(folder, f"constant/triSurface/{name}.stl"), *surface)
    level = 0
    while COARSE * 2 ** -(level + 1) * per_length >= 0.75:
        level += 1
    cell = 2 ** level / per_length
    write(folder, "system/blockMeshDict", BLOCK % tuple(round(length / cell) for length in (2, 1.2, 1.2)), "dictionary")
    write(folder, "system/snappyHexMeshDict", SNAPPY % {"level": level, "near": level - 2}, "dictionary")
    write(folder, "system/stream", "mach 1.4;\ncourant 0.2;\n")
    flow.steps(folder, 1)
    foam.run(folder, "blockMesh")
    foam.run(folder, "snappyHexMesh", "-overwrite")
    for name in ("cellLevel", "pointLevel", "nSurfaceLayers", "thickness", "thicknessFraction"):
        if os.path.exists(os.path.join(folder, "0", name)):
            os.remove(os.path.join(folder, "0", name))
    return flow.check(folder)


def drag(folder, body, wing, mach, per_length):
    """Time steps to the steady flow, each cell with its own. @return cells, D/q"""
    cells = prepare(folder, body, wing, per_length)
    last_step = 0
    for courant, steps in STAGES:
        last_step += round(per_length * steps) * 4
        write(folder, "system/stream", f"mach {mach!r};\ncourant {courant};\n")
        flow.steps(folder, last_step)
        foam.run(folder, "rhoCentralFoam")
    history = flow.coefficients(folder)
    last, before = history[-MEAN:].mean(), history[-2 * MEAN:-MEAN].mean()
    if not abs(last - before) <= STEADY * abs(last):
        foam.fail(f"not steady after {last_step} steps: drag {before:.6g}, then {last:.6g}")
    return cells, float(last)


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    cells, value = drag("wing_body_case", *(foam.read_obj(name) for name in sys.argv[3:]), float(sys.argv[1]), int(sys.argv[2]))
    print(f"{cells} cells, drag {value:.8f}")


if __name__ == "__main__":
    main()
