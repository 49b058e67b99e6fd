#include "optimize/evaluate/evaluation.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>
#include <iomanip>

/// Numbers of one deformed surface, stored: another compiler or optimization level may change them by rounding only.
namespace strake {
namespace {

TEST(StoredValues, OfADeformedEllipsoidToEightDigits) {
    Problem problem = ellipsoid_problem(2, 2);
    problem.parameters.kinds = {VariableKind::load, VariableKind::stiffness};
    const auto rest = rest_facts(problem);
    const DesignSpace space = design_space(rest, 2);
    ShapeEvaluator evaluator(problem, rest, {"volume", "area"});
    evaluator.enter(space);
    ShapeEvaluation e = evaluator.evaluate(0.4 * random_vector(space.size(), 11), 1);
    ASSERT_EQ(e.status, EvaluationStatus::ok) << e.reason;
    evaluator.differentiate(e);
    const std::vector<double> got{e.values[0], e.values[1], e.gradients.row(0).norm(), e.gradients.row(1).norm(),
                                  e.max_displacement};
    const std::vector<double> stored{0.969981430102277, 5.27280674671646, 0.0120017816763793, 0.107079862472491,
                                     0.075753165561827};  // GCC 12.2 -O3, 21 November 2026
    for (std::size_t i = 0; i < stored.size(); ++i) {
        SCOPED_TRACE(i);
        EXPECT_NEAR(got[i], stored[i], 1e-8 * std::abs(stored[i])) << std::setprecision(15) << got[i];
    }
}

}  // namespace
}  // namespace strake
