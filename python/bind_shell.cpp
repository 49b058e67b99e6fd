#include "core/error.hpp"
#include "core/primo/shell.hpp"
#include "python/bindings.hpp"

#include <variant>

namespace strake::python {
namespace {

using namespace py::literals;

/// The shell with its rest surface.
struct Shell {
    SurfacePointer rest;
    PrimoShell shell;
};

using HeightArgument = std::variant<double, Eigen::VectorXd>;

std::unique_ptr<Shell> make_shell(const SurfacePointer& surface, const HeightArgument& height, const py::object& fixed,
                                  const std::vector<py::object>& moved, const std::optional<PlaneTuple>& symmetry,
                                  bool couple_nonmanifold) {
    ShellOptions options;
    if (const auto* one = std::get_if<double>(&height))
        options.prism_height = Eigen::VectorXd::Constant(surface->num_vertices(), *one);
    else
        options.prism_height = std::get<Eigen::VectorXd>(height);
    options.pin.assign(static_cast<std::size_t>(surface->num_triangles()), free_prism);
    for (std::size_t k = 0; k < moved.size(); ++k)
        for (const int t : triangles_of(moved[k], *surface, text("Shell: moved[", k, "]"))) {
            int& pin = options.pin[static_cast<std::size_t>(t)];
            if (pin != free_prism) throw InvalidInput(text("Shell: moved: triangle ", t, " is in two motions"));
            pin = static_cast<int>(k) + 1;
        }
    for (const int t : triangles_of(fixed, *surface, "Shell: fixed"))
        options.pin[static_cast<std::size_t>(t)] = fixed_prism;
    options.symmetry = plane_of(symmetry);
    options.couple_nonmanifold = couple_nonmanifold;
    const py::gil_scoped_release release;
    return std::make_unique<Shell>(Shell{surface, PrimoShell(*surface, options)});
}

Loads loads_of(const Shell& s, const std::optional<Rows>& force, const std::optional<Eigen::VectorXd>& spring) {
    Loads loads;
    if (force) {
        check_rows(*force, s.rest->num_vertices(), "Shell: force");
        loads.force = *force;
    }
    if (spring) loads.spring = *spring;
    return loads;
}

Equilibrium solve(Shell& s, const std::optional<Rows>& force, const std::optional<Eigen::VectorXd>& spring,
                  const std::vector<RigidMotion>& motions, double min_step, int max_iterations) {
    const Loads loads = loads_of(s, force, spring);
    SolveOptions options;
    options.min_step = min_step;
    options.max_iterations = max_iterations;
    const py::gil_scoped_release release;
    return s.shell.solve(loads, motions, options);
}

ShellSensitivities adjoint(Shell& s, const Rows& dJ_dv) {
    check_rows(dJ_dv, s.rest->num_vertices(), "Shell.adjoint: dJ_dv");
    const py::gil_scoped_release release;
    return s.shell.adjoint({dJ_dv}).at(0);
}

void bind_results(py::module_& m) {
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    py::class_<RigidMotion>(m, "Motion",
                            "A rigid motion: x becomes about + exp(rotation) (x - about) + translation.\n\n"
                            "    up = strake.Motion(translation=[0, 0, 0.1])")
        .def(py::init(
                 [](const Eigen::Vector3d& rotation, const Eigen::Vector3d& translation, const Eigen::Vector3d& about) {
                     return RigidMotion{rotation, translation, about};
                 }),
             "rotation"_a = zero, "translation"_a = zero, "about"_a = zero,
             R"(__init__(self, rotation=(0, 0, 0), translation=(0, 0, 0), about=(0, 0, 0))
--

`rotation`: axis times angle in radians, 3 floats. `translation`: 3 floats, in the surface's unit.
`about`: the fixed point of the rotation, 3 floats.)")
        .def_readwrite("rotation", &RigidMotion::rotation, "3 floats: axis times angle in radians.")
        .def_readwrite("translation", &RigidMotion::translation, "3 floats, in the surface's unit.")
        .def_readwrite("about", &RigidMotion::about, "3 floats: the fixed point of the rotation.");
    py::class_<Equilibrium>(m, "Equilibrium", "How a solve of a Shell ended.")
        .def_property_readonly(
            "status", [](const Equilibrium& e) { return to_string(e.status); },
            "String: converged, not_converged, unstable or cancelled.")
        .def_property_readonly(
            "converged", [](const Equilibrium& e) { return e.status == SolveStatus::converged; },
            "True if `status` is converged: the shell is in a stable equilibrium.")
        .def_readonly("reason", &Equilibrium::reason, "String: the status in words.")
        .def_readonly("energy", &Equilibrium::energy, "Float: energy at the end, in unit squared.")
        .def_readonly("relative_gradient", &Equilibrium::relative_gradient,
                      "Float: the residual force, relative to the applied ones.")
        .def_readonly("iterations", &Equilibrium::iterations, "Int: Newton iterations.")
        .def_readonly("stable", &Equilibrium::stable, "True if the Hessian of the energy is positive definite.")
        .def(
            "__repr__",
            [](const Equilibrium& e) {
                return text("<strake.Equilibrium: ", to_string(e.status), ", ", e.reason, ">");
            },
            repr_doc);
    py::class_<ShellSensitivities>(
        m, "Sensitivities", "Derivatives of one functional J with respect to the inputs of a Shell, at an equilibrium.")
        .def_readonly("force", &ShellSensitivities::force, "n x 3 floats: dJ/d(force at each vertex).")
        .def_readonly("spring", &ShellSensitivities::spring, "n floats: dJ/d(spring at each vertex).")
        .def_readonly("height", &ShellSensitivities::prism_height, "n floats: dJ/d(height at each vertex).")
        .def_readonly("motion", &ShellSensitivities::motion,
                      "List of 6 floats for each motion: dJ/d(rotation), then dJ/d(translation).");
}

void bind_solves(py::class_<Shell>& shell) {
    shell
        .def("solve", &solve, "force"_a = py::none(), "spring"_a = py::none(), "motions"_a = std::vector<RigidMotion>{},
             py::kw_only(), "min_step"_a = SolveOptions{}.min_step,
             py::arg("max_iterations").noconvert() = SolveOptions{}.max_iterations,
             R"(solve(self, force=None, spring=None, motions=(), *, min_step=1e-09, max_iterations=60)
--

Moves the shell from its present shape to the equilibrium and returns how that ended: an Equilibrium.

`force`: at each vertex, n x 3 floats. `spring`: stiffness pulling each vertex back to rest, n floats, >= 0.
`motions`: a Motion for each set of triangles in `moved`.
`min_step`: converged when no prism moves farther than this, in diagonals. `max_iterations`: of Newton's method.

Not converging is a result, not an exception; the shell then keeps its shape. Raises UnheldPart if nothing holds a part of
the surface. Other Python threads keep running.)")
        .def("adjoint", &adjoint, "dJ_dv"_a, R"(adjoint(self, dJ_dv)
--

Sensitivities of a functional J at the equilibrium of the last converged `solve`, from its derivative `dJ_dv` with respect
to the vertices (n x 3 floats): one back-substitution.)")
        .def(
            "linear_response",
            [](Shell& s, const std::optional<Rows>& force, const std::vector<RigidMotion>& motions) {
                const Loads loads = loads_of(s, force, {});
                const py::gil_scoped_release release;
                return s.shell.linear_response(loads, motions);
            },
            "force"_a = py::none(), "motions"_a = std::vector<RigidMotion>{},
            R"(linear_response(self, force=None, motions=())
--

Vertices (n x 3 floats) after a single linear solve from rest, as in the paper. `force` and `motions` are those of
`solve`. The shell itself does not move.)")
        .def(
            "reset", [](Shell& s) { s.shell.reset(); }, R"(reset(self)
--

Returns the shell to rest.)")
        .def(
            "energy",
            [](const Shell& s, const std::optional<Rows>& force) { return s.shell.energy(loads_of(s, force, {})); },
            "force"_a = py::none(), R"(energy(self, force=None)
--

Energy (float, in unit squared) of the present shape under `force` (n x 3 floats).)");
}

}  // namespace

void bind_shell(py::module_& m) {
    bind_results(m);
    py::class_<Shell> shell(
        m, "Shell",
        R"(A surface as an elastic shell of rigid prisms (Berkenstock and Aftosmis 2008; Botsch et al. 2006).

    shell = strake.Shell(surface, height=0.02 * surface.diagonal, fixed=root)
    end = shell.solve(strake.traction_forces(surface, traction))
    gradients = shell.adjoint(dJ_dv)

For n vertices and m triangles. Energies are in unit squared, forces in units of length, tractions in 1 / unit.)");
    shell.def(py::init(&make_shell), "surface"_a, py::kw_only(), "height"_a, "fixed"_a = py::tuple(),
              "moved"_a = std::vector<py::object>{}, "symmetry"_a = py::none(), "couple_nonmanifold"_a = false,
              R"(__init__(self, surface, *, height, fixed=(), moved=(), symmetry=None, couple_nonmanifold=False)
--

`surface`: the Surface at rest.
`height`: full thickness of the shell, in the surface's unit: one float, or one for each of the n vertices. Thicker shells
bend less.
`fixed`: triangles that do not move, as numbers from 0 or as a mask of m booleans.
`moved`: a list of such sets of triangles; the first follows the first of the motions passed to `solve`, and so on.
`symmetry`: (normal, offset) of the symmetry plane of half a body: normal . x = offset.
`couple_nonmanifold`: if more than two triangles share an edge, couple each pair; otherwise they are refused.)");
    bind_solves(shell);
    shell
        .def_property_readonly(
            "vertices", [](const Shell& s) { return s.shell.vertices(); },
            "n x 3 floats: the present shape of the shell.")
        .def_property_readonly(
            "surface",
            [](const Shell& s) { return std::make_shared<TriMesh>(with_vertices(*s.rest, s.shell.vertices())); },
            "The present shape of the shell as a Surface.");
    m.def(
        "traction_forces",
        [](const TriMesh& surface, const Rows& traction) {
            check_rows(traction, surface.num_triangles(), "traction_forces: traction");
            return traction_forces(surface, traction);
        },
        "surface"_a, "traction"_a);
}

}  // namespace strake::python
