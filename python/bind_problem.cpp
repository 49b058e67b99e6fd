#include "cases/build_problem.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/mirrored.hpp"
#include "objectives/measures.hpp"
#include "objectives/target_shape.hpp"
#include "optimize/methods.hpp"
#include "optimize/mirror.hpp"
#include "python/evaluation_failed.hpp"
#include "python/problem.hpp"

#include <limits>
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

PythonProblem make_problem(const SurfacePointer& surface, const ThicknessArgument& thickness, const py::object& fixed,
                           const std::optional<PlaneTuple>& symmetry, const std::optional<PatchHierarchy>& tree,
                           const std::vector<std::string>& variables, double max_displacement, const std::string& split,
                           bool mirror, const std::string& name) {
    PythonProblem out;
    Problem& p = out.problem;
    p.name = name;
    p.surface = *surface;
    p.tree = tree ? *tree : segment_automatically(*surface, adjacency(*surface));
    for (const PatchLevel& level : p.tree.levels)
        if (static_cast<int>(level.label.size()) != surface->num_triangles())
            throw InvalidInput(
                text("Problem: tree: ", level.label.size(), " triangles, the surface has ", surface->num_triangles()));
    if (mirror) {
        const auto plane = plane_of_symmetry(*surface);
        if (!plane)
            throw InvalidInput("Problem: mirror: the surface has no plane of symmetry (to 1e-3 of the diagonal)");
        p.parameters.mirror = true;
        p.tree = mirrored(p.tree, *surface, adjacency(*surface), *plane);
    }
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
    PythonProblem out;
    out.the_case = load_case(file, Purpose::any);
    BuiltProblem built = build_problem(*out.the_case);
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
    p.the_case.reset();
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
    p.the_case.reset();
    p.problem.objective = name;
    p.problem.maximize = maximize;
}

void constrain(PythonProblem& p, const std::string& name, const std::optional<double>& min,
               const std::optional<double>& max, const std::optional<double>& equals, bool relative) {
    need_value(p, name);
    if (!min && !max && !equals) throw InvalidInput("Problem.constrain: give min, max or equals");
    p.the_case.reset();
    p.problem.constraints.push_back({name, min, max, equals, relative});
}

std::vector<std::string> value_names(const PythonProblem& p) {
    std::vector<std::string> names;
    for (const Quantity& q : p.problem.quantities) names.insert(names.end(), q.names.begin(), q.names.end());
    return names;
}

void set_options(PythonProblem& p, const std::optional<int>& evaluations, const std::optional<std::string>& method,
                 const std::optional<double>& seconds, const std::optional<long long>& seed) {
    if (evaluations && *evaluations < 1)
        throw InvalidInput(text("Problem.options: max_evaluations = ", *evaluations, " must be >= 1"));
    constexpr long long most = std::numeric_limits<unsigned>::max();
    if (seed && (*seed < 0 || *seed > most))
        throw InvalidInput(text("Problem.options: seed = ", *seed, ", limits 0 and ", most));
    if (seconds && !(*seconds >= 0))
        throw InvalidInput(text("Problem.options: max_seconds = ", *seconds, " must be >= 0"));
    if (evaluations) p.problem.optimize.max_evaluations = *evaluations;
    if (method) {
        const MethodFacts* facts = method_named(*method);
        if (!facts) throw InvalidInput("Problem.options: method '" + *method + "' is not known");
        p.problem.optimize.method = facts->method;
    }
    if (seconds) p.problem.optimize.max_seconds = *seconds;
    if (seed) p.problem.optimize.seed = static_cast<unsigned>(*seed);
    if (method || seed) p.the_case.reset();  // of a folder the journal has the budget, and the case all else
    if (p.the_case) p.the_case->optimize = p.problem.optimize;
}

using ProblemClass = py::class_<PythonProblem>;

void bind_quantities(ProblemClass& problem) {
    problem
        .def("add", &add_builtin, "type"_a, "name"_a = "", R"(add(self, type, name='')
--

Adds a built-in quantity. `type`: volume (unit cubed) or area (unit squared). `name`: its name; that of the type if empty.
`minimize`, `maximize` and `constrain` do so by themselves.)")
        .def(
            "add_target",
            [](PythonProblem& p, const std::string& name, const TriMesh& target, bool same) {
                add(p, name,
                    same ? target_shape_same(name, p.problem.surface, target)
                         : target_shape_closest(name, p.problem.surface, target));
            },
            "name"_a, "target"_a, "same_triangles"_a = false, R"(add_target(self, name, target, same_triangles=False)
--

Adds a quantity `name`: the mean square distance from the Surface `target`, in unit squared. It is that of closest
points, or with `same_triangles`, where both have the same triangles, that of each vertex from its own place there.)")
        .def(
            "add_quantity",
            [](PythonProblem& p, const std::string& name, const py::function& function, bool gradient) {
                add(p, name, python_quantity(name, function, gradient, p.thrown));
            },
            "name"_a, "function"_a, "gradient"_a = true, R"(add_quantity(self, name, function, gradient=True)
--

Adds a quantity `name` that is computed in Python.

`function`: is called as function(surface, want_gradient) with a Surface and a bool. It returns a float or, when
`want_gradient` is true, a pair: that float, and its derivative by the vertices (n x 3 floats).
`gradient`: False says that it never has a derivative; `options` must then choose a method that needs none.

An exception of the function ends the run and comes out of `run`. EvaluationFailed says that there is no value for this
shape: the run tries a shorter step.)")
        .def(
            "minimize", [](PythonProblem& p, const std::string& name) { set_goal(p, name, false); }, "quantity"_a,
            R"(minimize(self, quantity)
--

Makes the quantity of that name the objective: as small as possible. `quantity`: volume, area, or one that was added.)")
        .def(
            "maximize", [](PythonProblem& p, const std::string& name) { set_goal(p, name, true); }, "quantity"_a,
            R"(maximize(self, quantity)
--

Makes the quantity of that name the objective: as large as possible. `quantity`: volume, area, or one that was added.)")
        .def("constrain", &constrain, "quantity"_a, py::kw_only(), "min"_a = py::none(), "max"_a = py::none(),
             "equals"_a = py::none(), "relative"_a = false,
             R"(constrain(self, quantity, *, min=None, max=None, equals=None, relative=False)
--

Limits a quantity. `quantity`: its name. `min`, `max`, `equals`: floats in the unit of the quantity; one at least.
`relative`: they are multiples of its value at the start.)");
}

void bind_facts(ProblemClass& problem) {
    problem
        .def_property_readonly(
            "surface", [](const PythonProblem& p) { return p.surface; }, "The Surface at the start.")
        .def_property_readonly(
            "tree", [](const PythonProblem& p) { return p.problem.tree; }, "The PatchTree.")
        .def_property_readonly(
            "fixed", [](const PythonProblem& p) { return p.problem.fixed; },
            "List of ints: the triangles that stay, ascending.")
        .def_property_readonly(
            "name", [](const PythonProblem& p) { return p.problem.name; }, "String: its name, as reports tell it.")
        .def_property_readonly("quantities", &value_names, "List of strings: the names of all values.")
        .def_property_readonly(
            "objective", [](const PythonProblem& p) { return p.problem.objective; },
            "String: the name of the quantity that is minimized or maximized; empty: none yet.")
        .def_readonly("warnings", &PythonProblem::warnings, "List of strings: what reading the case file warned of.");
}

}  // namespace

void bind_problem(py::module_& m) {
    ProblemClass problem(m, "Problem",
                         R"(A shape optimization problem: a surface, what holds it, its design variables and its goals.

    problem = strake.Problem(surface, fixed=root, max_displacement=0.03)
    problem.maximize("volume")
    problem.constrain("area", max=1.001, relative=True)
    result = strake.run(problem)

Defaults are those of a case file, and the same problem gives the same bits either way.)");
    problem
        .def(
            py::init(&make_problem), "surface"_a, py::kw_only(), "thickness"_a = 0.02, "fixed"_a = py::tuple(),
            "symmetry"_a = py::none(), "tree"_a = py::none(), "variables"_a = std::vector<std::string>{"load"},
            "max_displacement"_a = 0.05, "split"_a = "all", "mirror"_a = false, "name"_a = "python",
            R"(__init__(self, surface, *, thickness=0.02, fixed=(), symmetry=None, tree=None, variables=['load'], max_displacement=0.05, split='all', mirror=False, name='python')
--

`surface`: the Surface at the start.
`thickness`: of the skin, as a share of the diagonal: one float, or one for each of the m triangles.
`fixed`: triangles that stay, as numbers from 0 or as a mask of m booleans.
`symmetry`: (normal, offset) of the plane, where the surface is half a body: normal . x = offset.
`tree`: a PatchTree made by `patches`; None: automatic.
`variables`: what each patch is driven by, a list of load, load_normal, strain, stiffness.
`max_displacement`: how far one variable may move the surface, as a share of the diagonal.
`split`: which patches are refined on the next level: all, sensitivity or gradient.
`mirror`: patches come in mirror images about the plane of symmetry, which is found; what moves them is tied.
`name`: of the problem.)")
        .def("options", &set_options, py::kw_only(), py::arg("max_evaluations").noconvert() = py::none(),
             "method"_a = py::none(), "max_seconds"_a = py::none(), py::arg("seed").noconvert() = py::none(),
             R"(options(self, *, max_evaluations=None, method=None, max_seconds=None, seed=None)
--

How to search; what is None stays as it is.

`max_evaluations`: of the whole run, an int (60 at first). `method`: its name as in a case file, such as slsqp (at first)
or cobyla, which needs no gradients. `max_seconds`: of the whole run, a float; 0: no limit.
`seed`: an int, of all that is random.)")
        .def(
            "__repr__",
            [](const PythonProblem& p) {
                return text("<strake.Problem '", p.problem.name, "': ", p.problem.surface.num_triangles(),
                            " triangles, ",
                            p.problem.objective.empty()
                                ? "no objective"
                                : (p.problem.maximize ? "maximize " : "minimize ") + p.problem.objective,
                            ">");
            },
            repr_doc);
    bind_facts(problem);
    bind_quantities(problem);
    m.def("load_case", &load, "file"_a);
}

}  // namespace strake::python
