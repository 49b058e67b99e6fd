"""Shape optimization of surface triangulations that have no CAD behind them.

A surface becomes an elastic skin, patches of it become design variables, and the equilibrium of the skin is the shape. A
whole optimization, of a wing that is to hold more with hardly more skin:

    import numpy as np
    import strake

    wing = strake.read_surface("wing.stl")
    y = wing.vertices[wing.triangles][:, :, 1]          # of the corners of each triangle
    root = (y < 0.05).all(axis=1)                       # a mask: a boolean for each triangle
    problem = strake.Problem(wing, fixed=root, symmetry=((0, 1, 0), 0.0))
    problem.maximize("volume")
    problem.constrain("area", max=1.001, relative=True)
    result = strake.run(problem, callback=print)
    print(result.status, result.reason)
    strake.write_surface("bigger.stl", wing.with_vertices(result.vertices))

What there is, from the outside in:

    load_case, run, fit                   a case file, and whole optimizations
    Problem, Result, Evaluation           one stated in Python, and what comes of it
    DesignSpace                           x -> shape, dJ/dv -> dJ/dx, for an optimizer of your own
    Shell, Motion, traction_forces        one skin: solve, adjoint
    patches, PatchTree                    the tree of patches
    Surface, read_surface, write_surface  surfaces as numpy arrays
    SurfaceMap                            other meshes that move with a surface

Arrays. n is the number of vertices, m that of triangles. Vertices, and derivatives dJ/dv of a number J by them, are
n x 3 floats; triangles are m x 3 ints, numbers of vertices from 0. C-contiguous float64 is taken without a copy, other
numbers are converted; what comes out of a surface is a read-only view of it.

Triangles are chosen by their numbers or by a mask of m booleans. Numbers that are not whole are refused, never rounded.

Units. Lengths are in the unit of the surface, whatever it is; angles are in radians but where a name says `deg`, and in
`angles` of `patches`.

Errors are kinds of `strake.Error`, and also of ValueError, OSError or RuntimeError; they name the argument, the value and
the limit. An argument of a wrong type is a TypeError.

Threads. While a skin is solved other threads of Python run on; one object is to be used from one thread at a time. A
solve takes two threads where there are two processors, or as many as the environment's STRAKE_NUM_THREADS says. The same
input gives the same bits.
"""
from . import _core
from ._core import (CaseError, DesignSpace, Equilibrium, Error, Evaluation, EvaluationFailed, InputError, InvalidInput,
                    Motion, OutputError, Patch, PatchLevel, PatchTree, Problem, Result, Sensitivities, Shell,
                    SolverError, Surface, SurfaceMap, UnheldPart)
from ._core import version as __version__

__all__ = ["CaseError", "DesignSpace", "Equilibrium", "Error", "Evaluation", "EvaluationFailed", "InputError",
           "InvalidInput", "Motion", "OutputError", "Patch", "PatchLevel", "PatchTree", "Problem", "Result",
           "Sensitivities", "Shell", "SolverError", "Surface", "SurfaceMap", "UnheldPart", "fit", "load_case", "patches",
           "read_surface", "run", "traction_forces", "write_surface"]


def read_surface(file):
    """The Surface in `file` (a path): STL, OBJ, PLY, OFF, TRI, VTK, VTP, SU2, Gmsh or NASTRAN, told by what is in it.
    Raises InputError with the place of what is wrong.
    """
    return _core.read_surface(file)


def write_surface(file, surface):
    """Writes the Surface `surface` to `file` (a path) in the format that the ending of its name tells, such as .stl or .obj.
    The file is whole or not there. Raises OutputError, or InvalidInput about an ending that is not known.
    """
    return _core.write_surface(file, surface)


def patches(surface, *, angles=(), patches_per_level=(), min_patch=0.0):
    """Cuts the Surface `surface` into nested patches: a PatchTree.

    `angles`: thresholds in degrees, falling, one a level (20, 10). Without them levels are chosen automatically.
    `patches_per_level`: how many patches there should be on each automatic level, whole numbers; 4, 16, 64 if not given.
    `min_patch`: the smallest patch, in percent of the triangles; with `angles` only.
    """
    return _core.patches(surface, angles=angles, patches_per_level=patches_per_level, min_patch=min_patch)


def traction_forces(surface, traction):
    """Forces at the vertices (n x 3 floats) of `traction`, a force per area on each triangle of the Surface `surface` (m x 3
    floats, in 1 / unit). `traction[mask] = [0, 0, 1e-6]` loads the triangles of a mask.
    """
    return _core.traction_forces(surface, traction)


def load_case(file):
    """The Problem that a case file states. `file`: the path of the YAML. Raises CaseError with all errors of the case, and
    InputError about its surface.
    """
    return _core.load_case(file)


def run(problem, callback=None, output=None):
    """The whole coarse-to-fine optimization of the Problem `problem`: a Result.

    `callback`: is called as callback(evaluation) with an Evaluation after each; where it returns False the run ends, with
    status interrupted.
    `output`: a path; the run keeps a folder there, as `strake run --out` does, with journal, history, designs and report.
    `strake status`, `resume`, `report` and `apply` take it. The problem must then be that of a case file (`load_case`), with
    no more changed than its budget (max_evaluations, max_seconds of its options). None: nothing is written.

    Exceptions of the callback and of quantities, and Ctrl-C, come out of `run` as they are.
    """
    return _core.run(problem, callback, output)


def fit(problem, targets=(), callback=None, output=None):
    """Moves the surface of the Problem `problem` onto targets, by least squares: a Result, whose objective is the mean square
    distance.

    `targets`: names given to `Problem.add_target`; of a problem from a case file, those that it names.
    `callback`, `output`: as in `run`.
    """
    return _core.fit(problem, targets, callback, output)
