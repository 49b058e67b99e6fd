#include "cases/build_problem.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/measures.hpp"
#include "objectives/target_shape.hpp"
#include "optimize/methods.hpp"
#include "python/evaluation_failed.hpp"
#include "python/problem.hpp"

#include <variant>

namespace strake::python {
namespace {

using namespace py::literals;

using ThicknessArgument = std::variant<double, Eigen::VectorXd>;

VariableKind kind_named(const std::string& word) {
    for (const auto& [name, kind] : {std::pair{"load", VariableKind::load},
                                     {"load_normal", VariableKind::load_normal},
                                     {"strain", VariableKind::strain},
                                     {"stiffness", VariableKind::stiffness}})
        if (word == name) return kind;
    throw InvalidInput("Problem: variables: '" + word + "' is none of load, load_normal, strain, stiffness");
}

SplitRule split_named(const std::string& word) {
    for (const auto& [name, rule] : {std::pair{"all", SplitRule::tree},
                                     {"sensitivity", SplitRule::sensitivity},
                                     {"gradient", SplitRule::gradient}})
        if (word == name) return rule;
    throw InvalidInput("Problem: split: '" + word + "' is none of all, sensitivity, gradient");
}

Eigen::VectorXd heights(const TriMesh& surface, const ThicknessArgument& thickness) {
    const double diagonal = box_diagonal(surface);
    Eigen::VectorXd of_triangles;
    if (const auto* one = std::get_if<double>(&thickness))
        of_triangles = Eigen::VectorXd::Constant(surface.num_triangles(), *one * diagonal);
    else
        of_triangles = std::get<Eigen::VectorXd>(thickness) * diagonal;
    if (of_triangles.size() != surface.num_triangles() || !(of_triangles.minCoeff() > 0) || !of_triangles.allFinite())
        throw InvalidInput(text("Problem: thickness must be > 0: one share of the diagonal, or one for each of ",
                                surface.num_triangles(), " triangles"));
    return vertex_heights(surface, of_triangles);
}

PythonProblem make_problem(const SurfacePointer& surface, const ThicknessArgument& thickness,
                           const std::vector<int>& fixed, const std::optional<PlaneTuple>& symmetry,
                           const std::optional<PatchHierarchy>& tree, const std::vector<std::string>& variables,
                           double max_displacement, const std::string& split, const std::string& name) {
    PythonProblem out;
    Problem& p = out.problem;
    p.name = name;
    p.surface = *surface;
    p.tree = tree ? *tree : segment_automatically(*surface, adjacency(*surface));
    for (const PatchLevel& level : p.tree.levels)
        if (static_cast<int>(level.label.size()) != surface->num_triangles())
            throw InvalidInput(
                text("Problem: tree: ", level.label.size(), " triangles, the surface has ", surface->num_triangles()));
    p.prism_height = heights(*surface, thickness);
    p.fixed = triangles_of(fixed, *surface, "Problem: fixed");
    p.symmetry = plane_of(symmetry);
    p.parameters.kinds.clear();
    for (const std::string& word : variables) p.parameters.kinds.push_back(kind_named(word));
    if (!(max_displacement > 0) || !std::isfinite(max_displacement))
        throw InvalidInput(text("Problem: max_displacement = ", max_displacement, " must be > 0"));
    p.parameters.max_displacement = max_displacement;
    p.parameters.split = split_named(split);
    out.surface = surface;
    return out;
}

PythonProblem load(const std::filesystem::path& file) {
    const py::gil_scoped_release release;
    BuiltProblem built = build_problem(load_case(file, Purpose::any));
    PythonProblem out;
    out.warnings = std::move(built.warnings);
    out.problem = std::move(built.problem);
    out.surface = std::make_shared<TriMesh>(out.problem.surface);
    return out;
}

void add(PythonProblem& p, const std::string& name, Quantity quantity) {
    for (const Quantity& other : p.problem.quantities)
        for (const std::string& known : other.names)
            if (known == name) throw InvalidInput("Problem: there is a quantity '" + name + "' already");
    quantity.names = {name};
    p.problem.quantities.push_back(std::move(quantity));
}

/// What a function has returned: a number, or (number, n x 3 or None).
QuantityResult result_of(const py::object& answer, const std::string& name, int num_vertices, bool wants_gradient) {
    const bool is_pair = py::isinstance<py::tuple>(answer);
    if (is_pair && py::len(answer) != 2)
        throw InvalidInput("quantity '" + name + "': must return a number, or a number and its gradient");
    QuantityResult out;
    out.values = {py::cast<double>(is_pair ? py::object(answer.cast<py::tuple>()[0]) : answer)};
    const py::object gradient = is_pair ? py::object(answer.cast<py::tuple>()[1]) : py::none();
    if (!wants_gradient) return out;
    if (gradient.is_none())
        throw InvalidInput("quantity '" + name +
                           "': a gradient was wanted and none returned; give `gradient=False` "
                           "when adding it, and choose a method without gradients");
    const auto rows = py::cast<Points>(gradient);
    if (rows.rows() != num_vertices)
        throw InvalidInput(text("quantity '", name, "': a gradient of ", rows.rows(), " rows, must be ", num_vertices));
    out.dJ_dv = {rows};
    return out;
}

/// A function of Python's. Exceptions end the run and go on there, but for EvaluationFailed.
Quantity python_quantity(const std::string& name, const py::function& function, bool has_gradient,
                         const std::shared_ptr<std::exception_ptr>& thrown) {
    Quantity q;
    q.has_sensitivities = has_gradient;
    q.failing_shortens_step = true;
    // Copies of the quantity are made and dropped without the interpreter's lock.
    const std::shared_ptr<py::function> held(new py::function(function), [](py::function* f) {
        const py::gil_scoped_acquire acquire;
        delete f;
    });
    q.evaluate = [held, name, has_gradient, thrown](const QuantityRequest& request) {
        const py::gil_scoped_acquire acquire;
        const bool wants = request.want_sensitivities && has_gradient;
        try {
            const auto surface = std::make_shared<TriMesh>(request.surface);
            return result_of((*held)(surface, wants), name, surface->num_vertices(), wants);
        } catch (const py::error_already_set& error) {
            if (is_evaluation_failed(error)) {
                QuantityResult failed;
                failed.failure = Failure{"undefined", py::str(error.value()).cast<std::string>()};
                return failed;
            }
            *thrown = std::current_exception();
        } catch (...) {
            *thrown = std::current_exception();
        }
        throw Interrupted{};
    };
    return q;
}

void add_builtin(PythonProblem& p, const std::string& type, const std::string& name) {
    if (type == "volume")
        add(p, name.empty() ? type : name, volume(p.problem.surface, p.problem.symmetry));
    else if (type == "area")
        add(p, name.empty() ? type : name, area());
    else
        throw InvalidInput("Problem.add: '" + type + "' is none of volume, area; others come from a case file");
}

bool has_value(const Problem& p, const std::string& name) {
    for (const Quantity& q : p.quantities)
        if (std::find(q.names.begin(), q.names.end(), name) != q.names.end()) return true;
    return false;
}

/// As in a case file: a built-in quantity needs no entry.
void need_value(PythonProblem& p, const std::string& name) {
    if (has_value(p.problem, name)) return;
    if (name == "volume" || name == "area") return add_builtin(p, name, name);
    throw InvalidInput("Problem: there is no quantity '" + name + "'; add it first");
}

void set_goal(PythonProblem& p, const std::string& name, bool maximize) {
    need_value(p, name);
    p.problem.objective = name;
    p.problem.maximize = maximize;
}

void constrain(PythonProblem& p, const std::string& name, const std::optional<double>& min,
               const std::optional<double>& max, const std::optional<double>& equals, bool relative) {
    need_value(p, name);
    if (!min && !max && !equals) throw InvalidInput("Problem.constrain: give min, max or equals");
    p.problem.constraints.push_back({name, min, max, equals, relative});
}

std::vector<std::string> value_names(const PythonProblem& p) {
    std::vector<std::string> names;
    for (const Quantity& q : p.problem.quantities) names.insert(names.end(), q.names.begin(), q.names.end());
    return names;
}

}  // namespace

void bind_problem(py::module_& m) {
    py::class_<PythonProblem>(
        m, "Problem",
        "A shape optimization problem: a surface, what holds it, its design variables and goals.\n\n"
        "Defaults are those of a case file; the same problem gives the same bits either way.")
        .def(
            py::init(&make_problem), "surface"_a, py::kw_only(), "thickness"_a = 0.02, "fixed"_a = std::vector<int>{},
            "symmetry"_a = py::none(), "tree"_a = py::none(), "variables"_a = std::vector<std::string>{"load"},
            "max_displacement"_a = 0.05, "split"_a = "all", "name"_a = "python",
            "`thickness`: of the skin, as a share of the diagonal, or m of them. `fixed`: triangles that stay.\n"
            "`symmetry`: (normal, offset) of half a body's plane. `tree`: from `patches`; None: automatic.\n"
            "`variables`: load, load_normal, strain, stiffness. `max_displacement`: how far one variable may move the\n"
            "surface, as a share of the diagonal. `split`: all, sensitivity or gradient.")
        .def_property_readonly(
            "surface", [](const PythonProblem& p) { return p.surface; }, "At the start.")
        .def_property_readonly("tree", [](const PythonProblem& p) { return p.problem.tree; })
        .def_property_readonly(
            "fixed", [](const PythonProblem& p) { return p.problem.fixed; }, "Triangles.")
        .def_property_readonly("name", [](const PythonProblem& p) { return p.problem.name; })
        .def_property_readonly("quantities", &value_names, "Names of all values.")
        .def_property_readonly("objective", [](const PythonProblem& p) { return p.problem.objective; })
        .def_readonly("warnings", &PythonProblem::warnings, "Of the case file.")
        .def("add", &add_builtin, "type"_a, "name"_a = "", "A built-in quantity: volume or area.")
        .def(
            "add_target",
            [](PythonProblem& p, const std::string& name, const TriMesh& target, bool same) {
                add(p, name,
                    same ? target_shape_same(name, p.problem.surface, target)
                         : target_shape_closest(name, p.problem.surface, target));
            },
            "name"_a, "target"_a, "same_triangles"_a = false, "Mean square distance from a target surface.")
        .def(
            "add_quantity",
            [](PythonProblem& p, const std::string& name, const py::function& function, bool gradient) {
                add(p, name, python_quantity(name, function, gradient, p.thrown));
            },
            "name"_a, "function"_a, "gradient"_a = true,
            "A quantity in Python: `function(surface, want_gradient)` returns a number or (number, dJ/dv), dJ/dv n x "
            "3.\n"
            "`gradient=False`: it never has one. An exception ends the run and comes out of `run`; EvaluationFailed\n"
            "says that there is no value for this shape: the run tries a shorter step.")
        .def(
            "minimize", [](PythonProblem& p, const std::string& name) { set_goal(p, name, false); }, "quantity"_a)
        .def(
            "maximize", [](PythonProblem& p, const std::string& name) { set_goal(p, name, true); }, "quantity"_a)
        .def("constrain", &constrain, "quantity"_a, py::kw_only(), "min"_a = py::none(), "max"_a = py::none(),
             "equals"_a = py::none(), "relative"_a = false,
             "Limits of a quantity; `relative`: as multiples of its value at the start.")
        .def(
            "options",
            [](PythonProblem& p, const std::optional<int>& evaluations, const std::optional<std::string>& method,
               const std::optional<double>& seconds, const std::optional<unsigned>& seed) {
                if (evaluations && *evaluations < 1)
                    throw InvalidInput(text("Problem.options: max_evaluations = ", *evaluations, " must be >= 1"));
                if (evaluations) p.problem.optimize.max_evaluations = *evaluations;
                if (method) {
                    const MethodFacts* facts = method_named(*method);
                    if (!facts) throw InvalidInput("Problem.options: method '" + *method + "' is not known");
                    p.problem.optimize.method = facts->method;
                }
                if (seconds) p.problem.optimize.max_seconds = *seconds;
                if (seed) p.problem.optimize.seed = *seed;
            },
            py::kw_only(), "max_evaluations"_a = py::none(), "method"_a = py::none(), "max_seconds"_a = py::none(),
            "seed"_a = py::none(), "How to search. What is not given stays; methods are those of a case file.")
        .def("__repr__", [](const PythonProblem& p) {
            return text("<strake.Problem '", p.problem.name, "': ", p.problem.surface.num_triangles(), " triangles, ",
                        p.problem.objective.empty()
                            ? "no objective"
                            : (p.problem.maximize ? "maximize " : "minimize ") + p.problem.objective,
                        ">");
        });
    m.def("load_case", &load, "file"_a,
          "The problem of a case file (YAML). Raises CaseError with all its errors, InputError about the surface.");
}

}  // namespace strake::python
