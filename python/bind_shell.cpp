#include "core/error.hpp"
#include "core/primo/shell.hpp"
#include "python/bindings.hpp"

#include <variant>

namespace strake::python {
namespace {

using namespace py::literals;

/// The shell with the surface that it was made of.
struct Shell {
    SurfacePointer rest;
    PrimoShell shell;
};

using HeightArgument = std::variant<double, Eigen::VectorXd>;

std::unique_ptr<Shell> make_shell(const SurfacePointer& surface, const HeightArgument& height,
                                  const std::vector<int>& fixed, const std::vector<std::vector<int>>& moved,
                                  const std::optional<PlaneTuple>& symmetry, bool couple_nonmanifold) {
    ShellOptions options;
    if (const auto* one = std::get_if<double>(&height))
        options.prism_height = Eigen::VectorXd::Constant(surface->num_vertices(), *one);
    else
        options.prism_height = std::get<Eigen::VectorXd>(height);
    options.pin.assign(static_cast<std::size_t>(surface->num_triangles()), free_prism);
    for (std::size_t k = 0; k < moved.size(); ++k)
        for (const int t : triangles_of(moved[k], *surface, "Shell: moved")) {
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
    py::class_<RigidMotion>(m, "Motion", "x -> about + exp(rotation) (x - about) + translation.")
        .def(py::init(
                 [](const Eigen::Vector3d& rotation, const Eigen::Vector3d& translation, const Eigen::Vector3d& about) {
                     return RigidMotion{rotation, translation, about};
                 }),
             "rotation"_a = Eigen::Vector3d(Eigen::Vector3d::Zero()),
             "translation"_a = Eigen::Vector3d(Eigen::Vector3d::Zero()),
             "about"_a = Eigen::Vector3d(Eigen::Vector3d::Zero()), "Rotation vector in radians, lengths.")
        .def_readwrite("rotation", &RigidMotion::rotation)
        .def_readwrite("translation", &RigidMotion::translation)
        .def_readwrite("about", &RigidMotion::about);
    py::class_<Equilibrium>(m, "Equilibrium", "How a solve has ended.")
        .def_property_readonly(
            "status", [](const Equilibrium& e) { return to_string(e.status); },
            "converged, not_converged, unstable or cancelled.")
        .def_property_readonly("converged", [](const Equilibrium& e) { return e.status == SolveStatus::converged; })
        .def_readonly("reason", &Equilibrium::reason, "The same in words.")
        .def_readonly("energy", &Equilibrium::energy, "Length squared.")
        .def_readonly("relative_gradient", &Equilibrium::relative_gradient)
        .def_readonly("iterations", &Equilibrium::iterations, "Newton iterations.")
        .def_readonly("stable", &Equilibrium::stable, "The exact Hessian is positive definite.")
        .def("__repr__", [](const Equilibrium& e) {
            return text("<strake.Equilibrium: ", to_string(e.status), ", ", e.reason, ">");
        });
    py::class_<ShellSensitivities>(m, "Sensitivities", "dJ/d(everything) of one functional at an equilibrium.")
        .def_readonly("force", &ShellSensitivities::force, "dJ/dF, n x 3.")
        .def_readonly("spring", &ShellSensitivities::spring, "dJ/d(spring), n.")
        .def_readonly("height", &ShellSensitivities::prism_height, "dJ/d(height), n.")
        .def_readonly("motion", &ShellSensitivities::motion,
                      "Per motion: dJ/d(rotation vector, translation), six numbers each.");
}

}  // namespace

void bind_shell(py::module_& m) {
    bind_results(m);
    py::class_<Shell>(
        m, "Shell",
        "A surface as an elastic skin of rigid prisms (Berkenstock and Aftosmis 2008; Botsch et al. 2006).\n\n"
        "    shell = strake.Shell(surface, height=0.02 * surface.diagonal, fixed=root)\n"
        "    end = shell.solve(strake.traction_forces(surface, traction))\n"
        "    gradients = shell.adjoint(dJ_dv)\n\n"
        "Energies are lengths squared, forces lengths, tractions 1/length.")
        .def(py::init(&make_shell), "surface"_a, py::kw_only(), "height"_a, "fixed"_a = std::vector<int>{},
             "moved"_a = std::vector<std::vector<int>>{}, "symmetry"_a = py::none(), "couple_nonmanifold"_a = false,
             "`height`: full thickness, one length or n of them. `fixed`: triangles that stay. `moved`: lists of\n"
             "triangles that follow the motions given to `solve`. `symmetry`: (normal, offset) of half a body's plane.")
        .def("solve", &solve, "force"_a = py::none(), "spring"_a = py::none(), "motions"_a = std::vector<RigidMotion>{},
             py::kw_only(), "min_step"_a = SolveOptions{}.min_step, "max_iterations"_a = SolveOptions{}.max_iterations,
             "Moves the skin to the equilibrium under forces (n x 3) and springs (n), from where it is now. Not to\n"
             "converge is a result (`status`), no exception; the skin then stays where it was. Other threads run on.")
        .def(
            "adjoint", &adjoint, "dJ_dv"_a,
            "Sensitivities of a functional J at the equilibrium of the last converged `solve`, from its derivative by\n"
            "the vertices (n x 3): one back-substitution.")
        .def(
            "linear_response",
            [](Shell& s, const std::optional<Rows>& force, const std::vector<RigidMotion>& motions) {
                const Loads loads = loads_of(s, force, {});
                const py::gil_scoped_release release;
                return s.shell.linear_response(loads, motions);
            },
            "force"_a = py::none(), "motions"_a = std::vector<RigidMotion>{},
            "Vertices (n x 3) displaced by the linear response at rest: the paper's single solve.")
        .def_property_readonly(
            "vertices", [](const Shell& s) { return s.shell.vertices(); }, "n x 3, where the skin is now.")
        .def_property_readonly(
            "surface",
            [](const Shell& s) { return std::make_shared<TriMesh>(with_vertices(*s.rest, s.shell.vertices())); },
            "The surface where the skin is now.")
        .def(
            "reset", [](Shell& s) { s.shell.reset(); }, "Back to rest.")
        .def(
            "energy",
            [](const Shell& s, const std::optional<Rows>& force) { return s.shell.energy(loads_of(s, force, {})); },
            "force"_a = py::none(), "At the present place, length squared.");
    m.def(
        "traction_forces",
        [](const TriMesh& surface, const Rows& traction) {
            check_rows(traction, surface.num_triangles(), "traction_forces: traction");
            return traction_forces(surface, traction);
        },
        "surface"_a, "traction"_a, "Forces at the vertices (n x 3) of a force per area on the triangles (m x 3).");
}

}  // namespace strake::python
