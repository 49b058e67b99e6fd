"""The component for OpenMDAO: by the protocol that OpenMDAO documents, and by OpenMDAO itself where it is installed.

ExplicitComponent's documentation: `setup` declares; `compute` sets outputs; `compute_jacvec_product` adds to what is in d_inputs
(mode "rev") or d_outputs (mode "fwd"), for the names that are there, and may not write the other one; a component without a result raises
AnalysisError. Vectors keep their shape, and what is assigned is copied.
"""
import numpy as np
import pytest

import explicit_component
import strake
from conftest import nose


class Vector:
    """A vector of named arrays in one piece of memory, of which some names are in scope; read-only while told so."""

    def __init__(self, arrays, scope=None):
        self.data = np.concatenate([np.ravel(a) for a in arrays.values()]).astype(float)
        ends = np.cumsum([np.size(a) for a in arrays.values()])
        self.at = {name: (end - np.size(a), end, np.shape(a)) for (name, a), end in zip(arrays.items(), ends)}
        self.scope = set(arrays) if scope is None else scope
        self.read_only = False

    def __contains__(self, name):
        return name in self.scope

    def __getitem__(self, name):
        if name not in self.scope:
            raise KeyError(name)
        begin, end, shape = self.at[name]
        view = self.data[begin:end].reshape(shape)
        if self.read_only:
            view = view.view()
            view.flags.writeable = False
        return view

    def __setitem__(self, name, value):
        assert not self.read_only, f"{name} is written in a mode in which it may only be read"
        self[name][...] = value


class Driven:
    """A component as a problem of OpenMDAO drives it."""

    def __init__(self, component):
        self.component, declared = component, {}
        component.add_input = component.add_output = lambda name, val: declared.update({name: val})
        component.setup()
        self.inputs, self.outputs = Vector({"x": declared["x"]}), Vector({"vertices": declared["vertices"]})

    def run(self, x):
        self.inputs["x"] = x
        self.inputs.read_only = True
        try:
            self.component.compute(self.inputs, self.outputs)
        finally:
            self.inputs.read_only = False
        return np.array(self.outputs["vertices"])

    def product(self, mode, dx, dv, scope=("x", "vertices")):
        d_inputs = Vector({"x": dx}, {"x"} & set(scope))
        d_outputs = Vector({"vertices": dv}, {"vertices"} & set(scope))
        (d_inputs if mode == "fwd" else d_outputs).read_only = True
        self.component.compute_jacvec_product(self.inputs, d_inputs, d_outputs, mode)
        return d_inputs.data, d_outputs.data


def space_of(body):
    problem = strake.Problem(body, thickness=0.05, fixed=nose(body), tree=strake.patches(body, patches_per_level=[2, 4]),
                             variables=["normal"])
    problem.maximize("volume")
    return strake.DesignSpace(problem, level=2)


def test_the_documented_protocol(body):
    space, random = space_of(body), np.random.default_rng(4)
    driven = Driven(explicit_component.ShapeComponent(space))
    x = np.full(len(space), 0.2)
    assert np.abs(driven.run(np.zeros(len(space))) - body.vertices).max() < 1e-12
    at_x = driven.run(x)
    assert np.array_equal(at_x, space.shape(x))

    v, w = random.standard_normal(len(x)), random.standard_normal(body.vertices.shape)
    there_v, there_w = random.standard_normal(len(x)), random.standard_normal(body.vertices.shape)
    forward, back = driven.product("fwd", v, there_w)[1] - there_w.ravel(), driven.product("rev", there_v, w)[0] - there_v
    assert np.vdot(w.ravel(), forward) == pytest.approx(np.vdot(back, v), rel=1e-8)
    ahead, behind = driven.run(x + 1e-4 * v), driven.run(x - 1e-4 * v)
    assert (ahead - behind).ravel() / 2e-4 == pytest.approx(forward, abs=1e-5 * np.abs(forward).max())
    # The products are those of the inputs that they are asked for, wherever the last shape was.
    driven.inputs["x"] = x
    assert driven.product("rev", there_v, w)[0] - there_v == pytest.approx(back, rel=1e-9, abs=1e-9 * np.abs(back).max())

    for mode in ("fwd", "rev"):  # what is out of scope stays as it is
        for scope in (("x",), ("vertices",)):
            dx, dv = driven.product(mode, v, w, scope)
            assert np.array_equal(dx, v) and np.array_equal(dv, w.ravel())


def test_a_shape_that_there_is_not(body):
    component = explicit_component.ShapeComponent(space_of(body))
    outputs, x = {}, np.full(len(component.space), 0.2)
    component.compute({"x": x}, outputs)
    back = {"x": np.zeros(len(x))}
    w = np.random.default_rng(4).standard_normal(body.vertices.shape)
    component.compute_jacvec_product({"x": x}, back, {"vertices": w}, "rev")
    kept = np.array(outputs["vertices"])
    with pytest.raises(explicit_component.AnalysisError):
        component.compute({"x": np.full(len(x), 1e6)}, outputs)
    assert np.array_equal(outputs["vertices"], kept)
    again = {"x": np.zeros(len(x))}  # after the failure the products are those of x, not of what failed
    component.compute_jacvec_product({"x": x}, again, {"vertices": w}, "rev")
    assert again["x"] == pytest.approx(back["x"], rel=1e-9, abs=1e-9 * np.abs(back["x"]).max())


def test_openmdao_itself(body):
    om = pytest.importorskip("openmdao.api", reason="OpenMDAO is not installed")
    problem = om.Problem(reports=False)
    problem.model.add_subsystem("shape", explicit_component.ShapeComponent(space_of(body)), promotes=["*"])
    problem.setup(force_alloc_complex=False)
    problem.set_val("x", np.full(len(problem.get_val("x")), 0.2))
    problem.run_model()
    told = problem.check_partials(out_stream=None, method="fd", form="central", step=1e-4)["shape"]["vertices", "x"]
    for direction in ("J_fwd", "J_rev"):
        assert told[direction] == pytest.approx(told["J_fd"], abs=1e-4 * np.abs(told["J_fd"]).max())
