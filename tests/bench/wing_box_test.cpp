#include "bench/wings/wing_box.hpp"
#include "bench/coarse_to_fine/solve.hpp"

#include "derivatives.hpp"
#include "tests/core/planform/lofted_wing.hpp"

#include <gtest/gtest.h>

namespace strake::evidence {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = std::numbers::pi / 180;

struct Boxed {
    TriMesh mesh;
    std::shared_ptr<const Wing> wing;
    ComparedMotion motion;
};

Boxed boxed(const WingBox& box) {
    Loft loft;
    loft.panels = 40;
    Boxed one{lofted(loft), {}, {}};
    WingDeclaration declared;
    declared.symmetry = SymmetryPlane{Vector3d::UnitY(), 0};
    declared.stations = {0, 0.5, 1};
    one.wing = std::make_shared<const Wing>(one.mesh, declared);
    one.motion = wing_box(one.mesh, *one.wing, box);
    return one;
}

TEST(WingBox, GradientsAreExact) {
    for (const bool downstream : {false, true}) {
        const Boxed one = boxed({.points = {5, 4, 2}, .moves_downstream = downstream, .root_held = downstream});
        const int points = 5 * (downstream ? 3 : 4) * 2;
        ASSERT_EQ(one.motion.size(), (downstream ? 2 : 1) * points + 3);
        EXPECT_LT((one.motion.vertices(VectorXd::Zero(one.motion.size())) - one.mesh.vertices).cwiseAbs().maxCoeff(),
                  1e-14);
        const VectorXd flat = random_vector(one.mesh.vertices.size(), 4);
        const Points w = Eigen::Map<const Points>(flat.data(), one.mesh.num_vertices(), 3);
        const auto J = [&](const VectorXd& x) {
            const Points v = one.motion.vertices(x);
            return v.cwiseProduct(w).sum() + v.array().square().sum();
        };
        const VectorXd x = 0.5 * random_vector(one.motion.size(), 2), p = random_vector(one.motion.size(), 3);
        const VectorXd g = one.motion.gradient(x, w + 2 * one.motion.vertices(x));
        EXPECT_NEAR(taylor_order(J, x, g, p, 0.2), 2, 0.15);
        EXPECT_NEAR(taylor_order(J, x, 1.1 * g, p, 1e-3), 1, 0.1) << "the control must fail";
    }
}

/// Twist is what sections show, and the root keeps its own.
TEST(WingBox, TwistIsNoseUpAboutTheQuarterChord) {
    const Boxed one = boxed({.points = {4, 2, 2}, .twist = 4 * degree});
    VectorXd x = VectorXd::Zero(one.motion.size());
    x[x.size() - 1] = 1;  // two planes: linear along the span
    const TriMesh now = with_vertices(one.mesh, one.motion.vertices(x));
    for (const double station : {0.0, 0.25, 0.5, 0.9}) {
        const StationFacts a = one.wing->station(one.mesh, station), b = one.wing->station(now, station);
        EXPECT_NEAR(b.twist.value - a.twist.value, 4 * degree * station, 0.03 * degree) << station;
        EXPECT_NEAR(b.chord.value, a.chord.value, 2e-3 * a.chord.value);
        const Vector3d before = 0.75 * a.leading_edge + 0.25 * a.trailing_edge,
                       after = 0.75 * b.leading_edge + 0.25 * b.trailing_edge;
        EXPECT_LT((after - before).norm(), 2e-3 * a.chord.value);
    }
}

/// A number of the vertices that counts how often it is asked for; a program if it has a name.
Quantity counted(const std::string& name, const std::string& program, int& asked,
                 std::function<double(const Points&)> value) {
    Quantity quantity;
    quantity.names = {name};
    quantity.program = program;
    quantity.has_sensitivities = false;
    quantity.evaluate = [&asked, value = std::move(value)](const QuantityRequest& request) {
        ++asked;
        return QuantityResult{.values = {value(request.surface.vertices)}, .dJ_dv = {}, .failure = {}};
    };
    return quantity;
}

/// As in Strake's own runs: a design is proposed where the constraints that need no program hold.
TEST(WingBox, ConstraintsThatNeedNoProgramAreKnownBesideIt) {
    const Boxed one = boxed({.points = {3, 3, 2}});
    const auto lift = [&](const Points& v) { return (v - one.mesh.vertices).col(2).mean(); };
    int flows = 0, shapes = 0;
    EvidenceProblem evidence;
    evidence.has_gradients = false;
    Problem& problem = evidence.problem;
    problem.surface = one.mesh;
    problem.quantities = {
        counted("drag", "flow", flows, [&](const Points& v) { return std::pow(1 - 30 * lift(v), 2); }),
        counted("height", "", shapes, [&](const Points& v) { return 1 + lift(v); })};
    problem.objective = "drag";
    problem.constraints = {{.quantity = "height", .min = {}, .max = 1.001, .equals = {}}};
    const Solve found = solve(evidence, one.motion, Method::model, 40);
    EXPECT_LE(flows, found.evaluations);  // the others fold
    EXPECT_GT(shapes, flows) << "the constraint is asked for where no flow is";
    EXPECT_NEAR(found.final, 0.97 * 0.97, 1e-3);
    EXPECT_LT(lift(found.vertices), 0.001 + 1e-5);
}

}  // namespace
}  // namespace strake::evidence
