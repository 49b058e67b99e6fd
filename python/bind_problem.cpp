#include "casefile/build/build_problem.hpp"
#include "casefile/load_case.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/automatic.hpp"
#include "core/patches/mirrored.hpp"
#include "objectives/fit/target_shape.hpp"
#include "objectives/geometry/measures.hpp"
#include "optimize/nlp/program/methods.hpp"
#include "optimize/space/mirror.hpp"
#include "python/evaluation_failed.hpp"
#include "python/problem.hpp"

#include <limits>
#include <variant>

namespace strake::python {
namespace {

using namespace py::literals;

using ThicknessArgument = std::variant<double, Eigen::VectorXd>;

VariableKind kind_named(const std::string& given) {
    const std::string word = current_name(given, "load_normal", "normal", "Problem: variables");
    for (const auto& [name, kind] : {std::pair{"load", VariableKind::load},
                                     {"normal", VariableKind::normal_load},
                                     {"strain", VariableKind::strain},
                                     {"stiffness", VariableKind::stiffness}})
        if (word == name) return kind;
    throw InvalidInput("Problem: variables: '" + given + "' is none of load, normal, strain, stiffness");
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

[[noreturn]] void refuse_answer(const std::string& name, const py::handle& answer, const std::string& why) {
    throw InvalidInput(text("quantity '", name, "': the function returned ", shown(answer), " (",
                            py::str(py::type::of(answer).attr("__name__")).cast<std::string>(), ")", why,
                            "; it must return a float, or with want_gradient a pair: a float and an n x 3 array"));
}

/// @throws InvalidInput naming the quantity for None, text, complex numbers and what no float can hold.
double number_of(const py::handle& answer, const std::string& name) {
    const bool is_text = PyUnicode_Check(answer.ptr()) || PyBytes_Check(answer.ptr());
    if (answer.is_none() || is_text || PyComplex_Check(answer.ptr())) refuse_answer(name, answer, "");
    PyObject* number = PyNumber_Float(answer.ptr());
    if (!number) {
        const bool is_too_large = PyErr_ExceptionMatches(PyExc_OverflowError) != 0;
        PyErr_Clear();
        refuse_answer(name, answer, is_too_large ? ", which is too large for a float" : "");
    }
    return py::reinterpret_steal<py::float_>(number).cast<double>();
}

/// dJ/dv, n x 3. @throws InvalidInput naming the quantity, the shape that came and the one that is expected.
Points gradient_of(const py::object& gradient, const std::string& name, int num_vertices) {
    const py::array array = py::array::ensure(gradient);
    const char kind = array ? array.dtype().kind() : 'O';
    if (kind != 'f' && kind != 'i' && kind != 'u')
        throw InvalidInput(text("quantity '", name, "': the gradient ", shown(gradient), " is not an array of floats; ",
                                "it must be ", num_vertices, " x 3: dJ/dx, dJ/dy, dJ/dz for each vertex"));
    if (array.ndim() == 2 && array.shape(0) == num_vertices && array.shape(1) == 3) return py::cast<Points>(array);
    const bool is_flat = array.ndim() == 1 && array.size() == 3 * static_cast<py::ssize_t>(num_vertices);
    throw InvalidInput(text("quantity '", name, "': the gradient has shape ",
                            py::str(array.attr("shape")).cast<std::string>(), ", must be (", num_vertices,
                            ", 3): dJ/dx, dJ/dy, dJ/dz for each vertex",
                            is_flat ? "; return gradient.reshape(-1, 3) if it lists them vertex by vertex" : ""));
}

/// The result of a Python function: a number, or (number, n x 3 or None).
QuantityResult result_of(const py::object& answer, const std::string& name, int num_vertices, bool wants_gradient) {
    const bool is_pair = py::isinstance<py::tuple>(answer);
    if (is_pair && py::len(answer) != 2)
        throw InvalidInput(text("quantity '", name, "': the function returned ", py::len(answer),
                                " things; it must return a float, or a pair: a float and an n x 3 array"));
    QuantityResult out;
    out.values = {number_of(is_pair ? py::object(answer.cast<py::tuple>()[0]) : answer, name)};
    const py::object gradient = is_pair ? py::object(answer.cast<py::tuple>()[1]) : py::none();
    if (!wants_gradient) return out;
    if (gradient.is_none())
        throw InvalidInput(
            "quantity '" + name +
            "': the function returned no gradient although one was wanted; pass `gradient=False` to add_quantity "
            "and choose a method without gradients");
    out.dJ_dv = {gradient_of(gradient, name, num_vertices)};
    return out;
}

/// @throws InvalidInput where `function` says that it does not take two arguments; some built-in ones say nothing.
void check_arguments(const std::string& name, const py::function& function) {
    try {
        py::module_::import("inspect").attr("signature")(function).attr("bind")(py::none(), true);
    } catch (const py::error_already_set& error) {
        if (error.matches(PyExc_TypeError))
            throw InvalidInput("quantity '" + name +
                               "': the function must take two arguments, (surface, want_gradient)");
        if (!error.matches(PyExc_ValueError)) throw;
    }
}

/// A Python function as a quantity. Exceptions other than EvaluationFailed end the run and are raised again there.
Quantity python_quantity(const std::string& name, const py::function& function, bool has_gradient,
                         const std::shared_ptr<std::exception_ptr>& thrown) {
    Quantity q;
    q.has_sensitivities = has_gradient;
    q.failing_shortens_step = true;
    // The quantity is copied and destroyed without the interpreter's lock.
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

std::vector<std::string> value_names(const PythonProblem& p) {
    std::vector<std::string> names;
    for (const Quantity& q : p.problem.quantities) names.insert(names.end(), q.names.begin(), q.names.end());
    return names;
}

/// As in a case file, a built-in quantity needs no entry.
void need_value(PythonProblem& p, const std::string& name) {
    if (has_value(p.problem, name)) return;
    if (name == "volume" || name == "area") return add_builtin(p, name, name);
    std::vector<std::string> known{"volume", "area"};
    for (const std::string& other : value_names(p))
        if (std::find(known.begin(), known.end(), other) == known.end()) known.push_back(other);
    std::string list;
    for (const std::string& other : known) list += (list.empty() ? "" : ", ") + other;
    throw InvalidInput("Problem: there is no quantity '" + name + "'; there are: " + list +
                       "; others are added by add_quantity, add_target, or come from a case file (load_case)");
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
    if (method && *method == "auto") {
        p.problem.optimize.method = Method::sqp;
        p.problem.optimize.chooses_method = true;
    } else if (method) {
        const MethodFacts* facts = method_named(current_name(*method, "slsqp", "sqp", "Problem.options: method"));
        if (!facts) {
            std::string list = "auto";
            for (const MethodFacts& one : all_methods()) list += text(", ", one.name);
            throw InvalidInput("Problem.options: method '" + *method + "' is none of " + list);
        }
        p.problem.optimize.method = facts->method;
        p.problem.optimize.chooses_method = false;  // as a case may have said
    }
    if (seconds) p.problem.optimize.max_seconds = *seconds;
    if (seed) p.problem.optimize.seed = static_cast<unsigned>(*seed);
    if (method || seed)
        p.the_case.reset();  // a run folder takes the budget from the journal, everything else from the case
    if (p.the_case) p.the_case->optimize = p.problem.optimize;
}

using ProblemClass = py::class_<PythonProblem>;

void bind_quantities(ProblemClass& problem) {
    problem
        .def("add", &add_builtin, "type"_a, "name"_a = "", R"(add(self, type, name='')
--

Adds a built-in quantity. `type`: volume (unit cubed) or area (unit squared). `name`: its name; that of the type if empty.
`minimize`, `maximize` and `constrain` add it automatically.)")
        .def(
            "add_target",
            [](PythonProblem& p, const std::string& name, const TriMesh& target, bool same) {
                add(p, name,
                    same ? target_shape_same(name, p.problem.surface, target)
                         : target_shape_closest(name, p.problem.surface, target));
            },
            "name"_a, "target"_a, "same_triangles"_a = false, R"(add_target(self, name, target, same_triangles=False)
--

Adds a quantity `name`: the mean square distance to the Surface `target`, in unit squared. The distance is to the closest
point, or with `same_triangles`, for a target with the same triangles, to the same vertex.)")
        .def(
            "add_quantity",
            [](PythonProblem& p, const std::string& name, const py::function& function, bool gradient) {
                check_arguments(name, function);
                add(p, name, python_quantity(name, function, gradient, p.thrown));
            },
            "name"_a, "function"_a, "gradient"_a = true, R"(add_quantity(self, name, function, gradient=True)
--

Adds a quantity `name` computed in Python.

`function`: called as function(surface, want_gradient) with a Surface and a bool. It returns a float or, if
`want_gradient` is true, a pair: that float, and its derivative with respect to the vertices (n x 3 floats).
`gradient`: False if it never returns a derivative; `options` must then choose a method that needs none.

An exception in the function ends the run and is raised by `run`, except EvaluationFailed, which means that there is no
value for this shape: the run tries a shorter step.)")
        .def(
            "minimize", [](PythonProblem& p, const std::string& name) { set_goal(p, name, false); }, "quantity"_a,
            R"(minimize(self, quantity)
--

Makes the quantity the objective, to be minimized. `quantity`: volume, area, or one added before.)")
        .def(
            "maximize", [](PythonProblem& p, const std::string& name) { set_goal(p, name, true); }, "quantity"_a,
            R"(maximize(self, quantity)
--

Makes the quantity the objective, to be maximized. `quantity`: volume, area, or one added before.)")
        .def("constrain", &constrain, "quantity"_a, py::kw_only(), "min"_a = py::none(), "max"_a = py::none(),
             "equals"_a = py::none(), "relative"_a = false,
             R"(constrain(self, quantity, *, min=None, max=None, equals=None, relative=False)
--

Limits a quantity. `quantity`: its name. `min`, `max`, `equals`: floats in the unit of the quantity; at least one.
`relative`: they are multiples of its start value.)");
}

void bind_facts(ProblemClass& problem) {
    problem
        .def_property_readonly(
            "surface", [](const PythonProblem& p) { return p.surface; }, "The start Surface.")
        .def_property_readonly(
            "tree", [](const PythonProblem& p) { return p.problem.tree; }, "The PatchTree.")
        .def_property_readonly(
            "fixed", [](const PythonProblem& p) { return p.problem.fixed; },
            "List of ints: the fixed triangles, ascending.")
        .def_property_readonly(
            "name", [](const PythonProblem& p) { return p.problem.name; }, "String: its name, as shown in reports.")
        .def_property_readonly("quantities", &value_names, "List of strings: the names of all values.")
        .def_property_readonly(
            "objective", [](const PythonProblem& p) { return p.problem.objective; },
            "String: the name of the minimized or maximized quantity; empty: none yet.")
        .def_readonly("warnings", &PythonProblem::warnings,
                      "List of strings: the warnings from reading the case file.");
}

}  // namespace

void bind_problem(py::module_& m) {
    ProblemClass problem(m, "Problem",
                         R"(A shape optimization problem: a surface, its supports, its design variables and its goals.

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

`surface`: the start Surface.
`thickness`: of the shell, as a fraction of the diagonal: one float, or one for each of the m triangles.
`fixed`: triangles that do not move, as numbers from 0 or as a mask of m booleans.
`symmetry`: (normal, offset) of the symmetry plane of half a body: normal . x = offset.
`tree`: a PatchTree from `patches`; None: automatic.
`variables`: the design variables of each patch, a list of load, normal, strain, stiffness.
`max_displacement`: the farthest that any point of the surface may move in `run`, as a fraction of the diagonal.
`split`: which patches are refined on the next level: all, sensitivity or gradient.
`mirror`: finds the plane of symmetry, makes mirror-image pairs of patches and ties their variables.
`name`: of the problem.)")
        .def("options", &set_options, py::kw_only(), py::arg("max_evaluations").noconvert() = py::none(),
             "method"_a = py::none(), "max_seconds"_a = py::none(), py::arg("seed").noconvert() = py::none(),
             R"(options(self, *, max_evaluations=None, method=None, max_seconds=None, seed=None)
--

Search options; None leaves an option unchanged.

`max_evaluations`: of the whole run, an int (60 at first). `method`: its name as in a case file, such as sqp (at first)
or cobyla, which needs no gradients; auto chooses, by the budget where a value has no gradient. `max_seconds`: of the
whole run, a float; 0: no limit.
`seed`: an int, for everything random.)")
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
