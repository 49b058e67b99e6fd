#include "core/fields/displacement_fields.hpp"
#include "core/mesh/geometry.hpp"
#include "core/planform/wing_lines.hpp"
#include "evaluated.hpp"
#include "optimize/space/field_conditions.hpp"
#include "problems.hpp"
#include "tests/core/planform/lofted_wing.hpp"

#include <gtest/gtest.h>

using namespace strake;

/// Derivatives by every field of every kind, alone and beside patches.
namespace {

/// Of the area, which has a curvature in every direction; a volume may be linear in a field.
/// @param size of the move, as of twelve variables: more of them fold the surface together
void expect_second_order(Evaluated& e, double size, int every = 1) {
    const Eigen::VectorXd x = size * std::sqrt(12.0 / e.space.size()) * random_vector(e.space.size(), 11);
    ShapeEvaluation here = e.at(x);
    ASSERT_EQ(here.status, EvaluationStatus::ok);
    e.evaluator.differentiate(here);
    const Eigen::Index row = here.gradients.rows() - 1;
    const Eigen::VectorXd area = here.gradients.row(row);
    const auto J = [&](const Eigen::VectorXd& y) { return e.at(y).values[static_cast<std::size_t>(row)]; };
    for (int j = 0; j < e.space.size(); j += every) {
        const Eigen::VectorXd p = Eigen::VectorXd::Unit(e.space.size(), j);
        EXPECT_NEAR(taylor_order(J, x, area, p, 1e-2), 2, 0.3) << e.space.variables[j].name << ' ' << size;
        const Eigen::VectorXd wrong = area + (0.1 * std::abs(area[j]) + 0.01 * area.norm()) * p;
        EXPECT_LT(taylor_order(J, x, wrong, p, 1e-2), 1.5) << "the test can fail: " << e.space.variables[j].name;
    }
}

Problem body(const FieldOptions& options, const std::function<void(FieldConditions&)>& change = {}) {
    Problem problem = ellipsoid_problem(2, 3);
    problem.parameters.kinds = {VariableKind::normal_load};
    FieldConditions conditions;
    conditions.held = problem.fixed;
    if (change) change(conditions);
    add_fields(problem.parameters, std::make_shared<const DisplacementFields>(problem.surface, conditions, options));
    return problem;
}

/// A half wing that is held at its root, with fields in its own coordinates.
Problem wing(int number) {
    Loft loft;
    loft.panels = 16;
    loft.cells = 10;
    loft.quarter = [](double s) { return 0.25 + 0.9 * s; };
    Problem problem;
    problem.surface = lofted(loft);
    problem.tree = octants(problem.surface, 2);
    problem.prism_height = Eigen::VectorXd::Constant(problem.surface.num_vertices(), 0.05);
    const Points c = triangle_centroids(problem.surface);
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        if (std::abs(c(t, 1)) < 0.4) problem.fixed.push_back(t);
    problem.symmetry = SymmetryPlane{Eigen::Vector3d::UnitY(), 0};
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.quantities = {area()};
    WingDeclaration declared;
    declared.symmetry = problem.symmetry;
    const Wing of(problem.surface, declared);
    FieldConditions conditions;
    conditions.held = problem.fixed;
    conditions.cut = problem.symmetry;
    FieldOptions options{number, {}};
    options.wing = std::make_shared<const WingCoordinates>(wing_lines(problem.surface, of));
    add_fields(problem.parameters, std::make_shared<const DisplacementFields>(problem.surface, conditions, options));
    for (UserVariable& v : problem.parameters.user_variables) v.unit = 0.02;
    return problem;
}

}  // namespace

/// At rest and after moves; the thin trailing edge folds sooner than an ellipsoid.
TEST(FieldDerivatives, OfEveryFieldOfAWing) {
    Evaluated alone(wing(60), 0), beside(wing(24), 1);
    ASSERT_EQ(alone.space.size(), 60);
    ASSERT_GT(beside.space.size(), 24);
    EXPECT_EQ(alone.space.variables[0].name.substr(0, 5), "wing.");
    for (const double size : {0.0, 0.2}) expect_second_order(alone, size);
    for (const double size : {0.0, 0.2}) expect_second_order(beside, size);
}

TEST(FieldDerivatives, OfSixtyAndOfManyFields) {
    Evaluated sixty(body({60, {}}), 0), many(body({192, {}}), 0), beside(body({60, {}}), 1);
    ASSERT_EQ(many.space.size(), 192);
    for (const double size : {0.0, 0.7}) expect_second_order(sixty, size);
    for (const double size : {0.0, 0.7}) expect_second_order(many, size);
    expect_second_order(beside, 0.4, 3);
}

TEST(FieldDerivatives, OfSplinesAlongTheAxis) {
    FieldOptions options{48, {}};
    options.along = AlongAxis::splines;
    Evaluated alone(body(options), 0), beside(body(options), 1);
    for (const double size : {0.0, 0.7}) expect_second_order(alone, size);
    expect_second_order(beside, 0.4, 2);
}

TEST(FieldDerivatives, OfFieldsThatLeaveASmoothBorder) {
    Evaluated alone(body({27, {}}, [](FieldConditions& c) { c.smooth_border = true; }), 0);
    for (const double size : {0.0, 0.7}) expect_second_order(alone, size);
}

/// Nothing is held but a point, at which no field moves or turns the body.
TEST(FieldDerivatives, OfFieldsAboutAPointThatIsStill) {
    Problem problem = body({27, {}}, [](FieldConditions& c) {
        c.held.clear();
        c.still = Eigen::Vector3d(0.2, 0, 0.1);
    });
    problem.fixed.clear();
    problem.has_shell = false;
    problem.parameters.kinds.clear();
    Evaluated alone(problem, 0);
    for (const double size : {0.0, 0.7}) expect_second_order(alone, size);
}
