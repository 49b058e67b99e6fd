"""Your own optimizer: scipy.optimize.minimize makes a body slimmer at fixed volume, with exact gradients.

    scipy_minimize.py SURFACE [OUT]
"""
import sys

import numpy as np
from scipy.optimize import NonlinearConstraint, minimize

import strake


def volume(vertices, triangles):
    """Enclosed volume and its derivative with respect to the vertices (n x 3)."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    gradient = np.zeros_like(vertices)
    for k, (p, q) in enumerate([(b, c), (c, a), (a, b)]):
        np.add.at(gradient, triangles[:, k], np.cross(p, q) / 6)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6, gradient


def height(vertices):
    """Mean square of z, to be minimized."""
    gradient = np.zeros_like(vertices)
    gradient[:, 2] = 2 * vertices[:, 2] / len(vertices)
    return np.mean(vertices[:, 2] ** 2), gradient


class Shapes:
    """Keeps the last shape: scipy asks for value and gradient one after the other. If there is no valid shape it gets a
    value so bad that its line search backtracks."""

    def __init__(self, space):
        self.space, self.x, self.vertices = space, None, None

    def at(self, x):
        if self.x is None or not np.array_equal(x, self.x):
            self.vertices, self.x = self.space.shape(x), np.array(x)
        return self.vertices

    def value(self, measure, x, if_none):
        try:
            return measure(self.at(x))[0]
        except strake.EvaluationFailed:
            return if_none

    def gradient(self, measure, x):
        return self.space.gradient(measure(self.at(x))[1])


def optimize(surface, iterations=8):
    (low, _, _), (high, _, _) = surface.box
    along = (surface.centroids()[:, 0] - low) / (high - low)
    ends = np.nonzero((along < 0.15) | (along > 0.85))[0]
    problem = strake.Problem(surface, fixed=ends, variables=["normal"], max_displacement=0.02,
                             tree=strake.patches(surface, patches_per_level=[6]))
    space = strake.DesignSpace(problem, level=1)
    shapes = Shapes(space)
    room = lambda vertices: volume(vertices, surface.triangles)
    start = room(surface.vertices)[0]
    keep = NonlinearConstraint(lambda x: shapes.value(room, x, 0.0) / start, 1, np.inf,
                               jac=lambda x: shapes.gradient(room, x) / start)
    scale = height(surface.vertices)[0]
    result = minimize(lambda x: shapes.value(height, x, 100 * scale) / scale, np.zeros(len(space)), method="SLSQP",
                      jac=lambda x: shapes.gradient(height, x) / scale, constraints=[keep],
                      bounds=list(zip(space.lower, space.upper)), options={"maxiter": iterations, "ftol": 1e-8})
    return result, surface.with_vertices(shapes.at(result.x))


if __name__ == "__main__":
    start_surface = strake.read_surface(sys.argv[1])
    if not start_surface.is_closed:
        sys.exit(f"{sys.argv[1]}: the surface is open, for example half a body: it has no volume to keep. Give a closed one.")
    found, best = optimize(start_surface)
    print(f"height {found.fun:.4f} of that at the start, volume {best.volume / start_surface.volume:.6f}; {found.message}")
    if len(sys.argv) > 2:
        strake.write_surface(sys.argv[2], best)
