#include "core/fields/displacement_fields.hpp"
#include "core/mesh/geometry.hpp"
#include "evaluated.hpp"
#include "optimize/check/border_turn.hpp"
#include "optimize/evaluate/edge_folds.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/space/field_conditions.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

using namespace strake;

/// `Parameters::keeps_smooth_border`: no design turns normals beside what is held by more than two degrees.
namespace {

constexpr double degree = std::numbers::pi / 180;

/// Two triangles about the x axis; the first is held, the second is turned.
TriMesh turned(double degrees, double along = 0) {
    const double a = degrees * degree;
    TriMesh mesh;
    mesh.vertices.resize(4, 3);
    mesh.vertices << 0, 0, 0, 1, 0, 0, 0.4, -0.8, 0, 0.6 + along, 0.7 * std::cos(a), 0.7 * std::sin(a);
    mesh.triangles.resize(2, 3);
    mesh.triangles << 0, 2, 1, 1, 3, 0;
    return mesh;
}

Problem held_body(bool is_kept, bool has_shell, bool has_fields) {
    Problem problem = ellipsoid_problem(3, 3);
    problem.has_shell = has_shell;
    problem.parameters.kinds = {VariableKind::normal_load};
    if (!has_shell) problem.parameters.kinds.clear();
    problem.parameters.keeps_smooth_border = true;
    problem.parameters.lets_border_turn = !is_kept;
    problem.parameters.max_displacement = 0.1;
    if (has_fields)
        add_fields(problem.parameters, std::make_shared<const DisplacementFields>(
                                           problem.surface, field_conditions(problem), FieldOptions{60, {}}));
    maximize_volume(problem);
    return problem;
}

/// Of the surface, degrees. @param v its vertices
double turn(const RestFacts& rest, const Points& v) {
    const Points motion = v - rest.surface.vertices;
    const double size = motion.rowwise().norm().maxCoeff();
    return border_turn(rest, rest.adjacent, pinned_triangles(rest), motion, size).degrees;
}

}  // namespace

TEST(SmoothBorder, TurnsAreThoseOfTheFreeTriangle) {
    const TriMesh rest = turned(10);
    const EdgeFolds folds =
        EdgeFolds(std::make_shared<const TriMesh>(rest)).with_border(adjacency(rest), {1, 0}, rest.vertices);
    EXPECT_FALSE(folds.is_none());
    for (const double by : {-30.0, -2.01, -1.99, 0.0, 1.1, 1.99, 2.01, 25.0}) {
        const Points v = turned(10 + by, 0.3).vertices;  // a corner along the edge turns nothing
        EXPECT_EQ(folds.any_above(EdgeFolds::kept, v), std::abs(by) > 2) << by;
        const auto rows = folds.rows(v, EdgeFolds::kept - 8, 5);
        ASSERT_EQ(rows.size(), std::abs(by) > 1.2 ? 1u : 0u) << by;
        if (rows.empty()) continue;
        EXPECT_NEAR(rows[0].angle, EdgeFolds::kept + 10 * (std::abs(by) - 2), 1e-9);
        EXPECT_EQ(folds.triangles(rows[0].edge), (std::array{0, 1}));
        // One degree more, by the corner along the normal.
        const Points n = triangle_normals(turned(10 + by, 0.3));
        EXPECT_EQ(rows[0].vertices[3], 3);
        EXPECT_NEAR(rows[0].gradient.row(3).dot(n.row(1)) * 0.7 * degree, by < 0 ? -10 : 10, 1e-8);
        EXPECT_NEAR(rows[0].gradient.row(3).norm() * 0.7 * degree, 10, 1e-8);
        EXPECT_TRUE(rows[0].gradient.topRows(3).isZero(0)) << "these are held";
    }
    EXPECT_TRUE(folds.any_above(EdgeFolds::folded, turned(10 + 2.01).vertices)) << "nor at a start";
    EXPECT_TRUE(
        EdgeFolds(std::make_shared<const TriMesh>(rest)).with_border(adjacency(rest), {1, 1}, rest.vertices).is_none());
}

TEST(SmoothBorder, ConditionsOnDesignsAreThoseOfTheTurn) {
    Evaluated e(held_body(true, true, true), 2);
    e.evaluator.limit_motion();
    Eigen::VectorXd x = 0.3 * random_vector(e.space.size(), 4);
    constexpr double none = 1e9;
    const MotionConditions at = e.evaluator.motion_conditions(x, none, {EdgeFolds::kept - 8, EdgeFolds::kept - 1});
    ASSERT_TRUE(at.rows.empty());
    ASSERT_GE(at.folds.size(), 3u);
    const Eigen::VectorXd p = random_vector(e.space.size(), 5);
    const auto free_triangle = [&](const EdgeFolds::Row& row) {
        for (int t = 0; t < e.problem.surface.num_triangles(); ++t) {
            const auto corners = e.problem.surface.triangles.row(t).array();
            if ((corners == row.vertices[0]).any() && (corners == row.vertices[1]).any() &&
                (corners == row.vertices[3]).any())
                return t;
        }
        throw std::out_of_range("no such triangle");
    };
    const Points before = triangle_normals(e.problem.surface);
    const auto angles = [&](const Eigen::VectorXd& y) {
        const Points n = triangle_normals(with_vertices(e.problem.surface, e.evaluator.equilibrium(y)));
        Eigen::VectorXd found(at.values.size());
        for (std::size_t i = 0; i < at.folds.size(); ++i) {
            const int t = free_triangle(at.folds[i]);
            found[static_cast<Eigen::Index>(i)] =
                10 * (dihedral(n.row(t), before.row(t)) - EdgeFolds::max_turn * degree);
        }
        return found;
    };
    EXPECT_LT((angles(x).array() + degree - at.values.array()).abs().maxCoeff(), 1e-9) << "it aims at a tenth less";
    std::vector<double> error;
    for (const double h : {2e-3, 1e-3}) {
        const Eigen::VectorXd change = (angles(x + h * p) - angles(x - h * p)) / (2 * h);
        error.push_back((change - at.slopes * p).norm() / change.norm());
        EXPECT_GT((change - 1.01 * at.slopes * p).norm(), 3e-3 * change.norm()) << "the test can fail";
    }
    EXPECT_LT(error[1], 0.3 * error[0] + 1e-7) << "of second order";
    EXPECT_LT(error[1], 1e-3);
}

TEST(SmoothBorder, DesignsTurnItByTwoDegreesAtMost) {
    for (const bool has_shell : {true, false}) {
        Evaluated kept(held_body(true, has_shell, true), has_shell ? 2 : 0),
            free(held_body(false, has_shell, true), has_shell ? 2 : 0);
        for (Evaluated* e : {&kept, &free}) {
            e->evaluator.limit_motion();
            e->at(Eigen::VectorXd::Zero(e->space.size()));  // a run has begun somewhere within
        }
        double largest = 0, unlimited = 0;
        for (unsigned seed = 1; seed <= 6; ++seed) {
            const Eigen::VectorXd x = 0.4 * random_vector(kept.space.size(), seed);
            const Eigen::VectorXd moved = kept.evaluator.within(x, 1e-3, EdgeFolds::kept);
            largest = std::max(largest, turn(*kept.rest, kept.evaluator.equilibrium(moved)));
            EXPECT_GT(moved.norm(), 0.02 * x.norm()) << "it still moves";
            const Eigen::VectorXd start = kept.evaluator.within(x, 1e-3, EdgeFolds::folded);
            largest = std::max(largest, turn(*kept.rest, kept.evaluator.equilibrium(start)));
            unlimited =
                std::max(unlimited,
                         turn(*free.rest, free.evaluator.equilibrium(free.evaluator.within(x, 1e-3, EdgeFolds::kept))));
        }
        EXPECT_LE(largest, 2) << has_shell;
        EXPECT_GT(unlimited, 4) << has_shell << ": the test can fail";
    }
}

TEST(SmoothBorder, ARunKeepsItInEveryShape) {
    for (const bool is_kept : {true, false}) {
        Problem problem = held_body(is_kept, true, false);
        problem.optimize.max_evaluations = 24;
        const auto rest = rest_facts(problem);
        double most = 0;
        problem.quantities.push_back(problem.quantities[0]);
        Quantity& spy = problem.quantities.back();
        spy.names = {"spy"};
        spy.evaluate = [&, inner = spy.evaluate](const QuantityRequest& request) {
            most = std::max(most, turn(*rest, request.surface.vertices));
            return inner(request);
        };
        const RunResult result = optimize(problem);
        EXPECT_LT(result.objective_start * 1.05, result.objective) << "it gains";
        if (is_kept)
            EXPECT_LE(most, 2);
        else
            EXPECT_GT(most, 2.5) << "the test can fail";
    }
}
