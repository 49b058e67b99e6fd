#include "bench/coarse_to_fine/solve.hpp"
#include "bench/published/lattice.hpp"
#include "core/fields/invariance.hpp"

#include "derivatives.hpp"
#include "tests/core/planform/lofted_wing.hpp"

#include <gtest/gtest.h>

namespace strake::evidence {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// Rings about x, one end open.
TriMesh tube() {
    constexpr int rings = 21, around = 12;
    TriMesh mesh;
    mesh.vertices.resize(rings * around, 3);
    mesh.triangles.resize(2 * (rings - 1) * around, 3);
    for (int i = 0; i < rings; ++i)
        for (int k = 0; k < around; ++k) {
            const double t = 2 * std::numbers::pi * k / around, r = 0.2 + 0.1 * std::sin(0.15 * i);
            mesh.vertices.row(i * around + k) << 0.05 * i, r * std::cos(t), r * std::sin(t);
        }
    for (int i = 0, m = 0; i + 1 < rings; ++i)
        for (int k = 0; k < around; ++k) {
            const int a = i * around + k, b = i * around + (k + 1) % around;
            mesh.triangles.row(m++) << a, b, a + around;
            mesh.triangles.row(m++) << b, b + around, a + around;
        }
    return mesh;
}

Problem revolved() {
    Problem problem;
    problem.surface = tube();
    problem.parameters.max_displacement = 0.05;
    problem.fixed = {0, 1, 2, 3};  // of the first row
    for (int t = 0; t < 24; ++t) problem.fixed.push_back(t);
    problem.parameters.invariance = std::make_shared<const Invariance>(
        problem.surface, ShapeKind{.type = ShapeKind::Type::revolved, .axis = Vector3d::UnitX()});
    return problem;
}

TEST(LatticeBox, KeepsTheKindOfShapeAndWhatIsHeld) {
    const Problem problem = revolved();
    const ComparedMotion motion = lattice_box(problem, {.points = {9, 2, 2}, .moves = "yz"});
    EXPECT_EQ(motion.size(), 8) << "one for each layer but the held one: its corners move together";
    const VectorXd x = random_vector(motion.size(), 3);
    const Points u = motion.vertices(x) - problem.surface.vertices;
    EXPECT_GT(u.cwiseAbs().maxCoeff(), 1e-3);
    EXPECT_LT(problem.parameters.invariance->deviation(u), 1e-12);
    EXPECT_EQ(u.topRows(24).cwiseAbs().maxCoeff(), 0) << "two rings are held";
    const Points w = Points::Random(u.rows(), 3);
    const auto J = [&](const VectorXd& at) {
        const Points v = motion.vertices(at);
        return v.cwiseProduct(w).sum() + v.array().square().sum();
    };
    const VectorXd p = random_vector(motion.size(), 4), g = motion.gradient(x, w + 2 * motion.vertices(x));
    EXPECT_NEAR(taylor_order(J, x, g, p, 0.2), 2, 0.15);
    EXPECT_NEAR(taylor_order(J, x, 1.1 * g, p, 1e-3), 1, 0.1) << "the control must fail";
}

/// A half model moves along its plane there, not off it; one point along an axis does not vary along it.
TEST(LatticeBox, StaysOnThePlaneOfSymmetry) {
    Loft loft;
    loft.panels = 20;
    Problem problem;
    problem.surface = lofted(loft);
    problem.symmetry = SymmetryPlane{Vector3d::UnitY(), 0};
    const ComparedMotion motion = lattice_box(problem, {.points = {2, 4, 1}, .moves = "yz"});
    EXPECT_EQ(motion.size(), 2 * 4 + 2 * 3);
    const Points u = motion.vertices(random_vector(motion.size(), 5)) - problem.surface.vertices;
    double off = 0, along = 0;
    for (int v = 0; v < problem.surface.num_vertices(); ++v)
        if (std::abs(problem.surface.vertices(v, 1)) < 1e-9) {
            off = std::max(off, std::abs(u(v, 1)));
            along = std::max(along, std::abs(u(v, 2)));
        }
    EXPECT_EQ(off, 0);
    EXPECT_GT(along, 1e-3);
}

/// J = (mean height - p)^2 + (p - 0.3)^2: least where both agree. Without the derivative by p the search would stay at
/// p = 0.
TEST(LatticeBox, ParametersOfProgramsAreVariables) {
    EvidenceProblem evidence;
    Problem& problem = evidence.problem;
    Loft loft;
    loft.panels = 20;
    problem.surface = lofted(loft);
    problem.parameters.max_displacement = 0.2;
    problem.program_parameters = {{.name = "p", .start = 0, .min = -1, .max = 1}};
    const double rest = problem.surface.vertices.col(2).mean(), count = problem.surface.num_vertices();
    double last = 0;
    Quantity quantity;
    quantity.names = {"J"};
    quantity.evaluate = [&](const QuantityRequest& request) {
        const double p = last = request.parameters.at(0).second;
        const double off = request.surface.vertices.col(2).mean() - rest - p;
        QuantityResult result{.values = {off * off + (p - 0.3) * (p - 0.3)}, .dJ_dv = {}, .failure = {}};
        Points slope = Points::Zero(request.surface.num_vertices(), 3);
        slope.col(2).setConstant(2 * off / count);
        result.dJ_dv = {slope};
        result.dJ_dp = {VectorXd::Constant(1, -2 * off + 2 * (p - 0.3))};
        return result;
    };
    problem.quantities = {quantity};
    problem.objective = "J";
    const Solve found = solve(evidence, lattice_box(problem, {.points = {2, 2, 1}, .moves = "z"}), Method::sqp, 30);
    EXPECT_EQ(found.variables, 5);
    EXPECT_LT(found.final, 1e-6);
    EXPECT_NEAR(last, 0.3, 2e-2);
}

}  // namespace
}  // namespace strake::evidence
