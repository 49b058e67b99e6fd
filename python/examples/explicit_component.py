"""A design space as an explicit component of OpenMDAO: inputs x, outputs vertices, and products with the Jacobian in both
directions, never the matrix. Without OpenMDAO a stand-in takes its place, with what is used here.

    explicit_component.py SURFACE
"""
import sys

import numpy as np

import strake

try:
    from openmdao.api import AnalysisError, ExplicitComponent
except ImportError:
    class AnalysisError(Exception):
        """What a component raises where it has no result: drivers of OpenMDAO that can go on then do."""

    class ExplicitComponent:
        """What this file uses of OpenMDAO's."""

        def __init__(self):
            self.declared = {}

        def add_input(self, name, val):
            self.declared[name] = val

        add_output = add_input


class ShapeComponent(ExplicitComponent):
    """x -> vertices of the equilibrium of the shell."""

    def __init__(self, space, **options):
        super().__init__(**options)
        self.space = space
        self.at = None

    def setup(self):
        self.add_input("x", val=np.zeros(len(self.space)))
        self.add_output("vertices", val=np.array(self.space.surface.vertices))

    def compute(self, inputs, outputs):
        self.at = None
        try:
            outputs["vertices"] = self.space.shape(inputs["x"])
        except strake.EvaluationFailed as none:
            raise AnalysisError(str(none)) from none
        self.at = np.array(inputs["x"])

    def compute_jacvec_product(self, inputs, d_inputs, d_outputs, mode):
        """mode "rev": d_inputs += J^T d_outputs, one adjoint solve; "fwd": d_outputs += J d_inputs."""
        if "x" not in d_inputs or "vertices" not in d_outputs:
            return
        if self.at is None or not np.array_equal(inputs["x"], self.at):
            self.compute(inputs, {})
        if mode == "rev":
            d_inputs["x"] += self.space.gradient(d_outputs["vertices"])
        else:
            d_outputs["vertices"] += self.space.response(d_inputs["x"])


def check(component, x, seed=1):
    """<w, J v> = <J^T w, v>, and J v by differences: the largest relative errors of both."""
    random = np.random.default_rng(seed)
    v, w = random.standard_normal(len(x)), random.standard_normal(component.space.surface.vertices.shape)
    inputs, outputs = {"x": x}, {}
    component.compute(inputs, outputs)
    forward, back = {"vertices": np.zeros_like(w)}, {"x": np.zeros_like(x)}
    component.compute_jacvec_product(inputs, {"x": v}, forward, "fwd")
    component.compute_jacvec_product(inputs, back, {"vertices": w}, "rev")
    product = np.vdot(w, forward["vertices"])
    step, ends = 1e-4, []
    for sign in (1, -1):
        end = {}
        component.compute({"x": x + sign * step * v}, end)
        ends.append(end["vertices"])
    differences = (ends[0] - ends[1]) / (2 * step)
    scale = np.linalg.norm(forward["vertices"])
    return abs(product - np.vdot(back["x"], v)) / abs(product), np.linalg.norm(differences - forward["vertices"]) / scale


if __name__ == "__main__":
    surface = strake.read_surface(sys.argv[1])
    problem = strake.Problem(surface, fixed=[0], variables=["load"], tree=strake.patches(surface, patches_per_level=[4]))
    shape = ShapeComponent(strake.DesignSpace(problem))
    shape.setup()
    transposed, by_differences = check(shape, np.full(len(shape.space), 0.1))
    print(f"{len(shape.space)} inputs, {surface.vertices.size} outputs; transpose to {transposed:.1e}, "
          f"differences to {by_differences:.1e}")
