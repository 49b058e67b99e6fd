#include "casefile/build/build_problem.hpp"
#include "core/error.hpp"
#include "optimize/evaluate/shape_solver.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/fit.hpp"
#include "optimize/run/samples.hpp"
#include "optimize/space/shape_map.hpp"
#include "python/evaluation_failed.hpp"
#include "python/problem.hpp"
#include "report/recorded_run.hpp"
#include "report/run_report.hpp"

namespace strake::python {
namespace {

using namespace py::literals;

constexpr double response_tolerance = 1e-11;

/// An optimizer of the user's own knows bounds of variables only: within these each alone keeps to `max_displacement`.
Problem boxed(Problem problem) {
    problem.parameters.limits_variables = true;
    return problem;
}

/// The design variables of one level, with the shell that they deform.
class Space {
public:
    Space(const PythonProblem& p, int level)
        : surface_(p.surface),
          rest_(rest_facts(boxed(p.problem))),
          space_(design_space(rest_, level)),
          guard_(guard_of(p.problem, rest_)) {}

    const DesignSpace& space() const { return space_; }
    const SurfacePointer& surface() const { return surface_; }

    Points shape(const Eigen::VectorXd& x) {
        check(x);
        const ShellDemand wanted = demand(space_, x);
        if (!rest_->has_shell) return shape_by_fields(x, wanted);
        if (!shell_ || height_ != wanted.prism_height) {
            ShellOptions options = rest_->setup.options;
            options.pin = space_.pin;
            options.prism_height = height_ = wanted.prism_height;
            shell_ = std::make_unique<PrimoShell>(rest_->elastic(), options);
            if (poses_) shell_->set_poses(*poses_);
        }
        SolveOptions options;
        options.keep_factor = true;
        x_.resize(0);
        const Equilibrium end = shell_->solve(wanted.loads, wanted.motions, options);
        if (end.status != SolveStatus::converged) throw EvaluationFailed(to_string(end.status) + ": " + end.reason);
        const Points vertices = with_fields(*rest_, wanted, shell_->vertices());
        const std::string defect = defect_of(guard_, *rest_, wanted, vertices, shell_.get());
        if (!defect.empty()) {
            if (poses_) shell_->set_poses(*poses_);
            throw EvaluationFailed(defect);
        }
        poses_ = shell_->poses();
        x_ = x;
        vertices_ = vertices;
        return vertices;
    }

    Eigen::VectorXd gradient(const Rows& dJ_dv) {
        check_rows(dJ_dv, surface_->num_vertices(), "DesignSpace.gradient: dJ_dv");
        need_shape();
        const Points about = beside_planform(*rest_, demand(space_, x_), vertices_);
        return design_gradient(space_, x_, surface_adjoint(*rest_, shell_.get(), {dJ_dv}, {}, &about).at(0));
    }

    Points response(const Eigen::VectorXd& dx) {
        check(dx);
        need_shape();
        const Points about = beside_planform(*rest_, demand(space_, x_), vertices_);
        Points out = Points::Zero(surface_->num_vertices(), 3);
        design_response(
            space_, shell_.get(),
            [&](int j, const Points& dv) {
                if (dx[j] != 0) out += dx[j] * dv;
            },
            response_tolerance, &about, &x_);
        return out;
    }

    void reset() {
        poses_.reset();
        shell_.reset();
        x_.resize(0);
    }

private:
    Points shape_by_fields(const Eigen::VectorXd& x, const ShellDemand& wanted) {
        x_.resize(0);
        Points vertices = with_fields(*rest_, wanted, rest_->surface.vertices);
        const std::string defect = defect_of(guard_, *rest_, wanted, vertices, nullptr);
        if (!defect.empty()) throw EvaluationFailed(defect);
        x_ = x;
        return vertices;
    }
    void check(const Eigen::VectorXd& x) const {
        if (x.size() != space_.size())
            throw InvalidInput(text("DesignSpace: x has ", x.size(), " numbers, must be ", space_.size()));
        if (!x.allFinite()) throw InvalidInput("DesignSpace: x is not finite");
    }
    void need_shape() const {
        if (x_.size() != space_.size()) throw InvalidInput("DesignSpace: call shape(x) first");
    }

    SurfacePointer surface_;
    std::shared_ptr<const RestFacts> rest_;
    DesignSpace space_;
    ShapeGuard guard_;
    std::unique_ptr<PrimoShell> shell_;
    Eigen::VectorXd height_, x_;  ///< x_: of the present shape; empty: none
    Points vertices_;             ///< of x_
    std::optional<Poses> poses_;
};

/// Releases the interpreter's lock while the shell is being solved.
template <class Work>
auto unlocked(const Work& work) {
    const py::gil_scoped_release release;
    return work();
}

/// In a run folder, from the case file: the problem is built again, because its programs must run in that folder.
RunResult run_in_folder(const PythonProblem& p, const std::filesystem::path& output, const RunEvents& events,
                        bool is_fit) {
    Case the_case = *p.the_case;
    the_case.output.dir = output;
    check_run_folder(output);
    const BuiltProblem built = build_problem(the_case, is_fit ? Purpose::fit : Purpose::run);
    RunFolder folder(output);
    RunResult result = recorded_run(built, the_case, folder, is_fit, events);
    if (the_case.output.report && has_report_page()) folder.list_file("report.html");
    folder.finish(result);
    if (the_case.output.report) make_report(built, the_case, output);
    return result;
}

void check_output(const PythonProblem& p, const std::optional<std::filesystem::path>& output) {
    if (output && !p.the_case)
        throw InvalidInput(
            "run: output: a run folder needs an unchanged problem from load_case (only its budget may be changed), and "
            "this "
            "problem is not one; omit output");
}

RunResult run(PythonProblem& p, const py::object& callback, const std::optional<std::filesystem::path>& output,
              bool is_fit) {
    check_output(p, output);
    *p.thrown = nullptr;
    bool stops = false;
    RunEvents events;
    const auto guarded = [&](const auto& work) {
        const py::gil_scoped_acquire acquire;
        try {
            work();
        } catch (...) {
            if (!*p.thrown) *p.thrown = std::current_exception();
            stops = true;
        }
    };
    events.stop_wanted = [&] {
        guarded([] {
            if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        });
        return stops;
    };
    if (!callback.is_none())
        events.evaluation = [&](const EvaluationRecord& record) {
            guarded([&] {
                const py::object answer = callback(record);
                if (!answer.is_none() && !answer.cast<bool>()) stops = true;
            });
        };
    RunResult result;
    {
        const py::gil_scoped_release release;
        if (output)
            result = run_in_folder(p, *output, events, is_fit);
        else
            result = is_fit             ? fit(p.problem, events)
                     : p.problem.sample ? sample(p.problem, events)
                                        : optimize(p.problem, events);
    }
    if (const std::exception_ptr thrown = std::exchange(*p.thrown, nullptr)) std::rethrow_exception(thrown);
    return result;
}

py::object best_x(const RunResult& r) {
    if (r.best_evaluation == 0) return py::none();
    return py::cast(r.x);
}

void bind_space(py::module_& m) {
    py::class_<Space> space(
        m, "DesignSpace",
        R"(The design variables of one level of a Problem: x -> shape, dJ/dv -> dJ/dx, for your own optimizer.

    space = strake.DesignSpace(problem, level=1)
    vertices = space.shape(x)
    dJ_dx = space.gradient(dJ_dv)

x has one number for each variable; a value of 1 moves the surface by about `max_displacement`. Use an object from only one
thread at a time; other Python threads keep running while it solves.)");
    space
        .def(py::init([](const PythonProblem& p, int level) {
                 return unlocked([&] { return std::make_unique<Space>(p, level); });
             }),
             "problem"_a, py::arg("level").noconvert() = 1, R"(__init__(self, problem, level=1)
--

`problem`: a Problem. `level`: of its tree, an int; 1 is the coarsest with variables.)")
        .def_property_readonly(
            "size", [](const Space& s) { return s.space().size(); }, "Int: the number of variables, as len().")
        .def(
            "__len__", [](const Space& s) { return s.space().size(); }, R"(__len__(self)
--

The number of variables.)")
        .def_property_readonly(
            "names",
            [](const Space& s) {
                std::vector<std::string> names;
                for (const Variable& v : s.space().variables) names.push_back(v.name);
                return names;
            },
            "List of strings: patch.component for each variable.")
        .def_property_readonly(
            "units",
            [](const Space& s) {
                Eigen::VectorXd units(s.space().size());
                for (int j = 0; j < s.space().size(); ++j)
                    units[j] = s.space().variables[static_cast<std::size_t>(j)].unit;
                return units;
            },
            "A float for each variable: its physical value at x = 1.")
        .def_property_readonly(
            "lower", [](const Space& s) { return s.space().lower; }, "A float for each variable: the lower bound of x.")
        .def_property_readonly(
            "upper", [](const Space& s) { return s.space().upper; }, "A float for each variable: the upper bound of x.")
        .def_property_readonly(
            "surface", [](const Space& s) { return s.surface(); }, "The start Surface.")
        .def(
            "shape", [](Space& s, const Eigen::VectorXd& x) { return unlocked([&] { return s.shape(x); }); }, "x"_a,
            R"(shape(self, x)
--

Vertices (n x 3 floats) of the equilibrium at `x` (a float for each variable), solved from the last shape. Raises
EvaluationFailed if there is none, or if the surface is invalid (inverted, folded, self-intersecting).)")
        .def(
            "gradient", [](Space& s, const Rows& dJ_dv) { return unlocked([&] { return s.gradient(dJ_dv); }); },
            "dJ_dv"_a, R"(gradient(self, dJ_dv)
--

dJ/dx (a float for each variable) at the last shape, from `dJ_dv`, the derivative with respect to the vertices (n x 3
floats): one adjoint solve, whatever the number of variables.)")
        .def(
            "response", [](Space& s, const Eigen::VectorXd& dx) { return unlocked([&] { return s.response(dx); }); },
            "dx"_a, R"(response(self, dx)
--

Displacement of the vertices (n x 3 floats) for a small change `dx` of the variables at the last shape: one solve for each
variable.)")
        .def("reset", &Space::reset, R"(reset(self)
--

Forgets the last shape: the next one is solved from rest.)")
        .def(
            "__repr__",
            [](const Space& s) {
                return text("<strake.DesignSpace: level ", s.space().level, ", ", s.space().size(), " variables>");
            },
            repr_doc);
}

void bind_records(py::module_& m) {
    py::class_<EvaluationRecord>(m, "Evaluation", "One evaluation of a run, as passed to its callback.")
        .def_readonly("evaluation", &EvaluationRecord::evaluation, "Int: its number, from 1.")
        .def_readonly("level", &EvaluationRecord::level, "Int: its level of patches.")
        .def_readonly("status", &EvaluationRecord::status, "String: ok, or one word for why there is no value.")
        .def_readonly("reason", &EvaluationRecord::reason, "String: an explanation; empty when ok.")
        .def_readonly("objective", &EvaluationRecord::objective, "Float: value of the objective; NaN unless ok.")
        .def_readonly("values", &EvaluationRecord::values,
                      "List of floats: values of all quantities, in the order of `Problem.quantities`.")
        .def_readonly("max_violation", &EvaluationRecord::max_violation,
                      "Float: the largest violation of a constraint, scaled; 0: feasible.")
        .def_readonly("accepted", &EvaluationRecord::accepted, "True if this is the best design so far.")
        .def_readonly("max_displacement", &EvaluationRecord::max_displacement,
                      "Float: the largest displacement of a vertex from its start, in the surface's unit.")
        .def_readonly("seconds", &EvaluationRecord::seconds, "Float: how long it took.")
        .def(
            "__repr__",
            [](const EvaluationRecord& r) {
                return text("<strake.Evaluation ", r.evaluation, ": ", r.status, ", objective ", r.objective, ">");
            },
            repr_doc);
    py::class_<RunResult>(m, "Result", "How a run ended, and its best design.")
        .def_readonly("status", &RunResult::status,
                      "String: converged, budget, sampled, progress, roundoff, no_valid_step, conflict, infeasible,\n"
                      "gradient_inconsistent, failed, evaluation_failed or interrupted.")
        .def_readonly("reason", &RunResult::reason, "String: why it stopped, and what to do next.")
        .def_property_readonly("done", &RunResult::is_done,
                               "True if there is a feasible design and the run converged or reached a limit.")
        .def_readonly("level", &RunResult::level, "Int: the last level of patches.")
        .def_readonly("evaluations", &RunResult::evaluations, "Int: the number of evaluations.")
        .def_readonly("best_evaluation", &RunResult::best_evaluation,
                      "Int: the evaluation number of the best design; 0: there is no design.")
        .def_readonly("objective", &RunResult::objective, "Float: of the best design.")
        .def_readonly("objective_start", &RunResult::objective_start, "Float: at the start.")
        .def_readonly("max_violation", &RunResult::max_violation,
                      "Float: the largest violation of a constraint by the best design, scaled; 0: feasible.")
        .def_readonly("names", &RunResult::names, "List of strings: names of all values.")
        .def_readonly("values", &RunResult::values,
                      "List of floats: values of the best design, in the order of `names`.")
        .def_readonly("values_start", &RunResult::values_start,
                      "List of floats: values at the start, in the order of `names`.")
        .def_property_readonly(
            "vertices", [](const RunResult& r) -> const Points& { return r.vertices; },
            py::return_value_policy::reference_internal,
            "n x 3 floats: vertices of the best design, a read-only view; 0 x 3 if there is none.")
        .def_property_readonly("x", &best_x,
                               "The best design, a float for each variable of its level; None if there is none.")
        .def(
            "__repr__",
            [](const RunResult& r) {
                return text("<strake.Result: ", r.status, " after ", r.evaluations, " evaluations, objective ",
                            r.objective, ">");
            },
            repr_doc);
}

}  // namespace

void bind_run(py::module_& m) {
    bind_space(m);
    bind_records(m);
    m.def(
        "run",
        [](PythonProblem& p, const py::object& callback, const std::optional<std::filesystem::path>& output) {
            return run(p, callback, output, false);
        },
        "problem"_a, "callback"_a = py::none(), "output"_a = py::none());
    m.def(
        "fit",
        [](PythonProblem& p, const std::vector<std::string>& targets, const py::object& callback,
           const std::optional<std::filesystem::path>& output) {
            if (!targets.empty() && targets != p.problem.fit) {
                p.problem.fit = targets;
                p.the_case.reset();
            }
            return run(p, callback, output, true);
        },
        "problem"_a, "targets"_a = std::vector<std::string>{}, "callback"_a = py::none(), "output"_a = py::none());
}

}  // namespace strake::python
