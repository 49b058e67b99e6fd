"""Shape optimization of triangulated surfaces without CAD.

A surface becomes an elastic shell, its patches carry the design variables, and the equilibrium of the shell is the shape.
A whole optimization: more volume in a wing with almost no additional area:

    import numpy as np
    import strake

    wing = strake.read_surface("wing.stl")
    y = wing.vertices[wing.triangles][:, :, 1]          # at the corners of each triangle
    root = (y < 0.05).all(axis=1)                       # a mask: a boolean for each triangle
    problem = strake.Problem(wing, fixed=root, symmetry=((0, 1, 0), 0.0))
    problem.maximize("volume")
    problem.constrain("area", max=1.001, relative=True)
    result = strake.run(problem, callback=print)
    print(result.status, result.reason)
    strake.write_surface("bigger.stl", wing.with_vertices(result.vertices))

Contents, from the outside in:

    load_case, run, fit                   a case file, and whole optimizations
    Problem, Result, Evaluation           a problem stated in Python, and its result
    DesignSpace                           x -> shape, dJ/dv -> dJ/dx, for your own optimizer
    Shell, Motion, traction_forces        one shell: solve, adjoint
    patches, PatchTree                    the patch tree
    Surface, read_surface, write_surface  surfaces as numpy arrays
    SurfaceMap                            moves other meshes with a surface

Arrays. n is the number of vertices, m the number of triangles. Vertices, and derivatives dJ/dv of a number J with respect
to them, are n x 3 floats; triangles are m x 3 ints, vertex numbers from 0. C-contiguous float64 is taken without a copy,
other numbers are converted; arrays returned by a surface are read-only views of it.

Select triangles by their numbers or by a mask of m booleans. Numbers that are not whole are refused, never rounded.

Units. Lengths are in the unit of the surface, whatever it is; angles are in radians, except where a name says `deg`, and
in `angles` of `patches`.

Errors derive from `strake.Error`, and also from ValueError, OSError or RuntimeError; they name the argument, the value and
the limit. An argument of the wrong type is a TypeError.

Threads. Other Python threads keep running while a shell is solved; use an object from only one thread at a time. A solve
uses two threads if there are two processors, or the number in the environment variable STRAKE_NUM_THREADS. The same input
gives the same bits.
"""
try:
    import numpy as _numpy
except ImportError as _missing:
    raise ImportError("strake needs numpy: install it, for example by `apt install python3-numpy` or "
                      "`pip install numpy`") from _missing
from . import _core
if not _core.numpy_2 and int(_numpy.__version__.split(".", maxsplit=1)[0]) > 1:
    raise ImportError(f"this build of strake knows NumPy 1 (its pybind11 is older than 2.12), and here is NumPy "
                      f"{_numpy.__version__}: `pip install 'numpy<2'`, or build strake with pybind11 2.12 or later")
from ._core import (CaseError, DesignSpace, Equilibrium, Error, Evaluation, EvaluationFailed, InputError, InvalidInput,
                    Motion, OutputError, Patch, PatchLevel, PatchTree, Problem, Result, Sensitivities, Shell,
                    SolverError, Surface, SurfaceMap, UnheldPart)
from ._core import version as __version__

__all__ = ["CaseError", "DesignSpace", "Equilibrium", "Error", "Evaluation", "EvaluationFailed", "InputError",
           "InvalidInput", "Motion", "OutputError", "Patch", "PatchLevel", "PatchTree", "Problem", "Result",
           "Sensitivities", "Shell", "SolverError", "Surface", "SurfaceMap", "UnheldPart", "fit", "load_case", "patches",
           "read_surface", "run", "traction_forces", "write_surface"]


def read_surface(file):
    """The Surface in `file` (a path): STL, OBJ, PLY, OFF, TRI, VTK, VTP, SU2, Gmsh or NASTRAN, recognized by its
    contents. Raises InputError naming the place of the error.
    """
    return _core.read_surface(file)


def write_surface(file, surface):
    """Writes the Surface `surface` to `file` (a path) in the format of its extension, for example .stl or .obj. The file is
    written completely or not at all. Raises OutputError, or InvalidInput for an unknown extension.
    """
    return _core.write_surface(file, surface)


def patches(surface, *, angles=(), patches_per_level=(), min_patch=0.0):
    """Segments the Surface `surface` into nested patches: a PatchTree.

    `angles`: thresholds in degrees, decreasing, one for each level (20, 10). Without them levels are chosen automatically.
    `patches_per_level`: target number of patches on each automatic level, whole numbers; default 4, 16, 64.
    `min_patch`: the smallest patch, in percent of the triangles; only with `angles`.
    """
    return _core.patches(surface, angles=angles, patches_per_level=patches_per_level, min_patch=min_patch)


def traction_forces(surface, traction):
    """Forces at the vertices (n x 3 floats) of `traction`, a force per area on each triangle of the Surface `surface` (m x 3
    floats, in 1 / unit). `traction[mask] = [0, 0, 1e-6]` loads the triangles of a mask.
    """
    return _core.traction_forces(surface, traction)


def load_case(file):
    """The Problem of a case file. `file`: the path of the YAML file. Raises CaseError with all errors of the case, and InputError
    for its surface.
    """
    return _core.load_case(file)


def run(problem, callback=None, output=None):
    """Runs the whole coarse-to-fine optimization of the Problem `problem`: a Result.

    `callback`: called as callback(evaluation) with an Evaluation after each; if it returns False, the run ends with status
    interrupted.
    `output`: the path of a run folder, as for `strake run --out`, with journal, history, designs and report, which `strake
    status`, `resume`, `report` and `apply` accept. The problem must then come from a case file (`load_case`), with at most
    its budget changed (max_evaluations, max_seconds of its options). None: nothing is written.

    Exceptions of the callback and of quantities, and Ctrl-C, are raised by `run` unchanged.
    """
    return _core.run(problem, callback, output)


def fit(problem, targets=(), callback=None, output=None):
    """Fits the surface of the Problem `problem` to targets by least squares: a Result, whose objective is the mean square
    distance.

    `targets`: names passed to `Problem.add_target`; default: those of the case file.
    `callback`, `output`: as for `run`.
    """
    return _core.fit(problem, targets, callback, output)
