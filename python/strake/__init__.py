"""Shape optimization of surface triangulations without CAD.

A surface becomes an elastic skin; patches of it become design variables; the skin's equilibrium is the shape.

    import strake
    surface = strake.read_surface("wing.stl")
    problem = strake.Problem(surface, fixed=root, symmetry=((0, 1, 0), 0.0))
    problem.maximize("volume")
    problem.constrain("area", max=1.001, relative=True)
    result = strake.run(problem, callback=print)
    strake.write_surface("bigger.stl", surface.with_vertices(result.vertices))

What there is, from the outside in:

    run, fit, load_case         whole optimizations, stated in Python or in a case file
    Problem, Result, Evaluation
    DesignSpace                 x -> shape, dJ/dv -> dJ/dx, for an optimizer of your own
    Shell, Motion, traction_forces
                                one skin: solve, adjoint
    patches, PatchTree          the tree of patches
    Surface, read_surface, write_surface, SurfaceMap
                                surfaces as numpy arrays, and other meshes that move with them

Arrays are float64 and C-contiguous: vertices n x 3, gradients dJ/dv n x 3, triangles m x 3 from 0. Such arrays are taken
without a copy; those that come out of a surface are read-only views of it. Lengths are in the surface's own unit, angles
in radians but for `angles` of patches. While a skin is solved other threads of Python run on; one object is to be used
from one thread at a time. All errors are kinds of `strake.Error`, and also of ValueError, OSError or RuntimeError.
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
