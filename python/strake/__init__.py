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

Threads. While a skin is solved other threads of Python run on; one object is to be used from one thread at a time. The
same input gives the same bits.
"""
from ._core import (CaseError, DesignSpace, Equilibrium, Error, Evaluation, EvaluationFailed, InputError, InvalidInput,
                    Motion, OutputError, Patch, PatchLevel, PatchTree, Problem, Result, Sensitivities, Shell,
                    SolverError, Surface, SurfaceMap, UnheldPart, fit, load_case, patches, read_surface, run,
                    traction_forces, write_surface)
from ._core import version as __version__

__all__ = ["CaseError", "DesignSpace", "Equilibrium", "Error", "Evaluation", "EvaluationFailed", "InputError",
           "InvalidInput", "Motion", "OutputError", "Patch", "PatchLevel", "PatchTree", "Problem", "Result",
           "Sensitivities", "Shell", "SolverError", "Surface", "SurfaceMap", "UnheldPart", "fit", "load_case", "patches",
           "read_surface", "run", "traction_forces", "write_surface"]
