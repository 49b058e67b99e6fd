#pragma once
#include "core/mesh/temp_folder.hpp"
#include "core/text/file.hpp"
#include "derivatives.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "optimize/problem/problem.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/mixed_design.hpp"
#include "optimize/run/stored_design.hpp"

#include <gtest/gtest.h>

namespace strake {

/// A problem with all that is needed to ask for its volume (where it has one) and area.
struct Evaluated {
    Problem problem;
    std::shared_ptr<const RestFacts> rest;
    ShapeEvaluator evaluator;
    DesignSpace space;

    /// @param level of the design space; none: 1, or 0 where there is no shell
    explicit Evaluated(Problem p, std::optional<int> level = {})
        : problem(std::move(p)),
          rest(rest_facts(problem)),
          evaluator(problem, rest, asked(problem)),
          space(design_space(rest, level.value_or(problem.has_shell ? 1 : 0))) {
        evaluator.enter(space);
    }
    ShapeEvaluation at(const Eigen::VectorXd& x) {
        ShapeEvaluation e = evaluator.evaluate(x, 1);
        EXPECT_EQ(e.status, EvaluationStatus::ok) << e.reason;
        return e;
    }

private:
    static std::vector<std::string> asked(const Problem& problem) {
        for (const Quantity& quantity : problem.quantities)
            for (const std::string& name : quantity.names)
                if (name == "volume") return {"volume", "area"};
        return {"area"};
    }
};

/// Gradients of volume and area at x against the values along p, which leave a remainder of second order; with a
/// control.
inline ShapeEvaluation expect_exact_gradients(Evaluated& e, const Eigen::VectorXd& x, const Eigen::VectorXd& p) {
    ShapeEvaluation here = e.at(x);
    if (here.status != EvaluationStatus::ok) return here;
    e.evaluator.differentiate(here);
    for (int i = 0; i < 2; ++i) {
        const Eigen::VectorXd g = here.gradients.row(i);
        const auto J = [&](const Eigen::VectorXd& y) { return e.at(y).values.at(i); };
        EXPECT_NEAR(taylor_order(J, x, g, p, 1e-2), 2, 0.15) << i;
        EXPECT_NEAR(taylor_order(J, x, 1.1 * g, p, 1e-3), 1, 0.15) << "the control must fail, " << i;
    }
    return here;
}

/// A run gains, and from its design as it was stored another one starts where it ended; mixed with itself it is itself.
/// @param gain of the objective, over one; @param rounding of the mixed shape
inline void expect_run_is_stored(Problem problem, double gain, double rounding) {
    std::optional<StoredDesign> best;
    RunEvents events;
    const TempFolder folder;
    events.accepted = [&](const AcceptedDesign& design) {
        write_atomically(folder / "best.design", design_bytes(stored_design(design)));
        best = read_design(folder / "best.design");
    };
    const RunResult r = optimize(problem, events);
    EXPECT_TRUE(r.is_done()) << r.status << ": " << r.reason;
    EXPECT_GT(r.objective, (1 + gain) * r.objective_start);
    ASSERT_TRUE(best.has_value());
    EXPECT_EQ(best->poses.rotation.empty(), !problem.has_shell);
    Problem again = problem;
    again.optimize.max_evaluations = 4;
    start_from(again, std::make_shared<const StoredDesign>(*best));
    const RunResult more = optimize(again);
    EXPECT_GE(more.objective, (1 - 1e-9) * r.objective) << more.reason;
    const auto design = std::make_shared<const StoredDesign>(*best);
    const MixedDesign same = mixed_design({problem, design}, {problem, design}, 0.3);
    EXPECT_EQ(same.defect, "");
    EXPECT_LT((same.vertices - design->vertices).cwiseAbs().maxCoeff(), rounding);
}

}  // namespace strake
