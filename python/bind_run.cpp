#include "core/error.hpp"
#include "optimize/coarse_to_fine.hpp"
#include "optimize/fit.hpp"
#include "optimize/validity.hpp"
#include "python/evaluation_failed.hpp"
#include "python/problem.hpp"

namespace strake::python {
namespace {

using namespace py::literals;

/// The design variables of one level, with the skin that they deform.
class Space {
public:
    Space(const PythonProblem& p, int level)
        : surface_(p.surface),
          rest_(rest_facts(p.problem)),
          space_(design_space(rest_, level)),
          guard_(rest_->surface, rest_->adjacent, {p.problem.fixed, p.problem.symmetry}) {}

    const DesignSpace& space() const { return space_; }
    const SurfacePointer& surface() const { return surface_; }

    Points shape(const Eigen::VectorXd& x) {
        check(x);
        const ShellDemand wanted = demand(space_, x);
        if (!shell_ || height_ != wanted.prism_height) {
            ShellOptions options = rest_->setup.options;
            options.pin = space_.pin;
            options.prism_height = height_ = wanted.prism_height;
            shell_ = std::make_unique<PrimoShell>(rest_->surface, options);
            if (poses_) shell_->set_poses(*poses_);
        }
        SolveOptions options;
        options.keep_factor = true;
        x_.resize(0);
        const Equilibrium end = shell_->solve(wanted.loads, wanted.motions, options);
        if (end.status != SolveStatus::converged) throw EvaluationFailed(to_string(end.status) + ": " + end.reason);
        const Points vertices = shell_->vertices();
        const std::string defect = guard_.defect(vertices, shell_->poses());
        if (!defect.empty()) {
            if (poses_) shell_->set_poses(*poses_);
            throw EvaluationFailed(defect);
        }
        poses_ = shell_->poses();
        x_ = x;
        return vertices;
    }

    Eigen::VectorXd gradient(const Rows& dJ_dv) {
        check_rows(dJ_dv, surface_->num_vertices(), "DesignSpace.gradient: dJ_dv");
        need_shape();
        return design_gradient(space_, x_, shell_->adjoint({dJ_dv}).at(0));
    }

    Points response(const Eigen::VectorXd& dx) {
        check(dx);
        need_shape();
        Points out = Points::Zero(surface_->num_vertices(), 3);
        design_response(space_, *shell_, [&](int j, const Points& dv) {
            if (dx[j] != 0) out += dx[j] * dv;
        });
        return out;
    }

    void reset() {
        poses_.reset();
        shell_.reset();
        x_.resize(0);
    }

private:
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
    ValidityGuard guard_;
    std::unique_ptr<PrimoShell> shell_;
    Eigen::VectorXd height_, x_;  ///< x_: of the present shape; empty: none
    std::optional<Poses> poses_;
};

/// One at a time, and never the interpreter's lock while the skin is being solved.
template <class Work>
auto unlocked(const Work& work) {
    const py::gil_scoped_release release;
    return work();
}

RunResult run(PythonProblem& p, const py::object& callback, bool is_fit) {
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
        result = is_fit ? fit(p.problem, events) : optimize(p.problem, events);
    }
    if (const std::exception_ptr thrown = std::exchange(*p.thrown, nullptr)) std::rethrow_exception(thrown);
    return result;
}

py::object best_x(const RunResult& r) {
    if (r.best_evaluation == 0) return py::none();
    return py::cast(r.x);
}

void bind_space(py::module_& m) {
    py::class_<Space>(
        m, "DesignSpace",
        "The design variables of one level of a problem: x <-> loads, strains, heights <-> a shape.\n\n"
        "x is scaled: 1 moves the surface by about `max_displacement`. To be used from one thread at a time;\n"
        "other threads of Python run on while it solves.")
        .def(py::init([](const PythonProblem& p, int level) {
                 return unlocked([&] { return std::make_unique<Space>(p, level); });
             }),
             "problem"_a, "level"_a = 1)
        .def_property_readonly(
            "size", [](const Space& s) { return s.space().size(); }, "How many variables.")
        .def("__len__", [](const Space& s) { return s.space().size(); })
        .def_property_readonly(
            "names",
            [](const Space& s) {
                std::vector<std::string> names;
                for (const Variable& v : s.space().variables) names.push_back(v.name);
                return names;
            },
            "patch.component")
        .def_property_readonly(
            "units",
            [](const Space& s) {
                Eigen::VectorXd units(s.space().size());
                for (int j = 0; j < s.space().size(); ++j)
                    units[j] = s.space().variables[static_cast<std::size_t>(j)].unit;
                return units;
            },
            "Physical value of each variable at x = 1.")
        .def_property_readonly("lower", [](const Space& s) { return s.space().lower; })
        .def_property_readonly("upper", [](const Space& s) { return s.space().upper; })
        .def_property_readonly(
            "surface", [](const Space& s) { return s.surface(); }, "At the start.")
        .def(
            "shape", [](Space& s, const Eigen::VectorXd& x) { return unlocked([&] { return s.shape(x); }); }, "x"_a,
            "Vertices (n x 3) of the equilibrium at x, sought from the last shape. Raises EvaluationFailed where "
            "there\n"
            "is none, or the surface is no valid one (inverted, folded, crossing itself).")
        .def(
            "gradient", [](Space& s, const Rows& dJ_dv) { return unlocked([&] { return s.gradient(dJ_dv); }); },
            "dJ_dv"_a, "dJ/dx at the last shape, from dJ/dv (n x 3): one adjoint solve, however many variables.")
        .def(
            "response", [](Space& s, const Eigen::VectorXd& dx) { return unlocked([&] { return s.response(dx); }); },
            "dx"_a, "dv (n x 3) of a small change dx at the last shape; a solve for each variable.")
        .def("reset", &Space::reset, "Forgets the last shape: the next one is sought from rest.")
        .def("__repr__", [](const Space& s) {
            return text("<strake.DesignSpace: level ", s.space().level, ", ", s.space().size(), " variables>");
        });
}

void bind_records(py::module_& m) {
    py::class_<EvaluationRecord>(m, "Evaluation", "One evaluation of a run, as its callback is given it.")
        .def_readonly("evaluation", &EvaluationRecord::evaluation, "From 1.")
        .def_readonly("level", &EvaluationRecord::level)
        .def_readonly("status", &EvaluationRecord::status, "ok, or why there is no value.")
        .def_readonly("reason", &EvaluationRecord::reason)
        .def_readonly("objective", &EvaluationRecord::objective, "NaN when not ok.")
        .def_readonly("values", &EvaluationRecord::values, "Of all quantities.")
        .def_readonly("max_violation", &EvaluationRecord::max_violation)
        .def_readonly("accepted", &EvaluationRecord::accepted, "The best design so far.")
        .def_readonly("max_displacement", &EvaluationRecord::max_displacement, "From the start, length.")
        .def_readonly("seconds", &EvaluationRecord::seconds)
        .def("__repr__", [](const EvaluationRecord& r) {
            return text("<strake.Evaluation ", r.evaluation, ": ", r.status, ", objective ", r.objective, ">");
        });
    py::class_<RunResult>(m, "Result", "How a run has ended, and its best design.")
        .def_readonly("status", &RunResult::status, "converged, budget, progress, infeasible, interrupted, ...")
        .def_readonly("reason", &RunResult::reason, "Why it stopped, and what to do next.")
        .def_property_readonly("done", &RunResult::is_done,
                               "There is a feasible design, and the run ended as it should.")
        .def_readonly("level", &RunResult::level)
        .def_readonly("evaluations", &RunResult::evaluations)
        .def_readonly("best_evaluation", &RunResult::best_evaluation, "0: there is no design.")
        .def_readonly("objective", &RunResult::objective, "Of the best design.")
        .def_readonly("objective_start", &RunResult::objective_start)
        .def_readonly("max_violation", &RunResult::max_violation)
        .def_readonly("names", &RunResult::names, "Of all values.")
        .def_readonly("values", &RunResult::values, "Of the best design.")
        .def_readonly("values_start", &RunResult::values_start)
        .def_property_readonly(
            "vertices", [](const RunResult& r) -> const Points& { return r.vertices; },
            py::return_value_policy::reference_internal,
            "Of the best design, n x 3, read-only view; 0 rows: there is none.")
        .def_property_readonly("x", &best_x, "The best design in the variables of its level.")
        .def("__repr__", [](const RunResult& r) {
            return text("<strake.Result: ", r.status, " after ", r.evaluations, " evaluations, objective ", r.objective,
                        ">");
        });
}

}  // namespace

void bind_run(py::module_& m) {
    bind_space(m);
    bind_records(m);
    m.def(
        "run", [](PythonProblem& p, const py::object& callback) { return run(p, callback, false); }, "problem"_a,
        "callback"_a = py::none(),
        "The whole coarse-to-fine optimization. `callback(evaluation)` is called after each evaluation; False ends "
        "the\n"
        "run (status interrupted). Exceptions of the callback and of quantities, and Ctrl-C, come out of it.");
    m.def(
        "fit",
        [](PythonProblem& p, const std::vector<std::string>& targets, const py::object& callback) {
            if (!targets.empty()) p.problem.fit = targets;
            return run(p, callback, true);
        },
        "problem"_a, "targets"_a = std::vector<std::string>{}, "callback"_a = py::none(),
        "Moves the surface onto targets (`Problem.add_target`), by least squares.");
}

}  // namespace strake::python
