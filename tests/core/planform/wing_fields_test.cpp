#include "core/fields/displacement_fields.hpp"

#include "core/error.hpp"
#include "core/fields/function_sum.hpp"
#include "core/mesh/geometry.hpp"
#include "core/planform/kept_sections.hpp"
#include "core/planform/wing_lines.hpp"
#include "derivatives.hpp"
#include "lofted_wing.hpp"
#include "surfaces.hpp"
#include "tests/core/fields/left_over.hpp"

#include <gtest/gtest.h>
#include <Eigen/SVD>

/// Displacement fields in a wing's own coordinates.
namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

const SymmetryPlane centre{Vector3d::UnitY(), 0};

/// Swept, tapered, twisted; its edges bend.
Loft loft() {
    Loft of;
    of.panels = 24;
    of.cells = 16;
    of.quarter = [](double s) { return 0.25 + 0.9 * s + 0.3 * s * s; };
    return of;
}

struct Example {
    TriMesh mesh;
    std::shared_ptr<const Wing> wing;
    FieldOptions options;
    FieldConditions conditions;

    explicit Example(TriMesh of, int number = 24, std::optional<SymmetryPlane> cut = centre) : mesh(std::move(of)) {
        WingDeclaration declared;
        declared.symmetry = cut;
        wing = std::make_shared<const Wing>(mesh, declared);
        options.number = number;
        options.wing = std::make_shared<const WingCoordinates>(wing_lines(mesh, *wing));
        conditions.cut = std::move(cut);
    }
    void hold_root() {
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            bool is_in = true;
            for (const int v : mesh.triangles.row(t)) is_in &= std::abs(mesh.vertices(v, 1)) < 0.4;
            if (is_in) conditions.held.push_back(t);
        }
    }
    DisplacementFields fields() const { return {mesh, conditions, options}; }
};

TEST(WingCoordinates, AreFractionsOfSpanAndChordAndTheirGradientsAreExact) {
    const Example example(lofted(loft()));
    const WingCoordinates& wing = *example.options.wing;
    const Loft of = loft();
    for (const double s : {0.2, 0.5, 0.83}) {  // the middle of the chord
        const double x = of.quarter(s) + 0.25 * of.chord(s) * std::cos(of.twist(s));
        const double z = of.height(s) - 0.25 * of.chord(s) * std::sin(of.twist(s));
        const WingCoordinates::At at = wing.at({x, 3 * s, z});
        EXPECT_NEAR(at.s, s, 2e-3);
        EXPECT_NEAR(at.xi, 0.5, 2e-3);
        EXPECT_NEAR(at.eta, 0, 0.02) << "halves of the thickness";
    }
    const auto part = [&](int which) {
        return [&wing, which](const VectorXd& x) {
            const WingCoordinates::At at = wing.at(x);
            return which == 0 ? at.xi : at.eta;
        };
    };
    const VectorXd p = random_vector(3, 5);
    for (const Vector3d& x : {Vector3d(0.9, 1.03, 0.1), Vector3d(1.6, 2.4, 0.35), Vector3d(1.7, 3.3, 0.3)})
        for (const int which : {0, 1}) {
            const WingCoordinates::At at = wing.at(x);
            const VectorXd g = which == 0 ? at.by_xi : at.by_eta;
            EXPECT_NEAR(taylor_order(part(which), x, g, p, 1e-3), 2, 0.1) << x.transpose();
            EXPECT_NEAR(taylor_order(part(which), x, 1.1 * g, p, 1e-3), 1, 0.1) << "the check can fail";
        }
}

/// Each function, and a sum of all.
TEST(WingFields, FunctionsHaveExactGradients) {
    const Example example(lofted(loft()));
    FunctionSpace space;
    space.wing = example.options.wing;
    space.frame.axes.setIdentity();
    space.frame.middle = Vector3d(1, 0, 0.1);
    space.frame.half = Vector3d(2, 3, 0.4);
    for (const int i : {-2, 0, 1, 4, 5})
        for (const int j : {0, 1, 2, 5})
            for (const int k : {0, 1, 3})
                if (i >= 0 || j + k == 0) space.powers.push_back({i, j, k});
    LocalFunctions functions(space);
    const Vector3d x(1.1, 1.7, 0.12);
    const VectorXd p = random_vector(3, 9);
    for (const Powers& number : space.powers) {
        const auto value = [&](const VectorXd& at) {
            functions.set(at);
            return functions.value(number);
        };
        functions.set(x);
        const VectorXd g = Vector3d(functions.slope(number, 0), functions.slope(number, 1), functions.slope(number, 2));
        if (g.isZero(0)) continue;
        const VectorXd wrong = g + 0.1 * g.norm() * p;
        EXPECT_NEAR(taylor_order(value, x, wrong, p, 1e-3), 1, 0.2) << "the check can fail";
        if (number[0] < 2 && number[1] + number[2] == 0) continue;  // it is linear
        EXPECT_NEAR(taylor_order(value, x, g, p, 1e-3), 2, 0.2) << number[0] << number[1] << number[2];
    }
    const Coefficients c = Eigen::Map<const Coefficients>(
        random_vector(3 * static_cast<Eigen::Index>(space.powers.size()), 3).eval().data(),
        static_cast<Eigen::Index>(space.powers.size()), 3);
    FunctionSum sum(space, c);
    Vector3d u, expected = Vector3d::Zero();
    Matrix3d slope, expected_slope = Matrix3d::Zero();
    sum.at(x, u, slope);
    functions.set(x);
    for (std::size_t f = 0; f < space.powers.size(); ++f) {
        const Vector3d by = c.row(static_cast<Eigen::Index>(f));
        expected += functions.value(space.powers[f]) * by;
        for (int k = 0; k < 3; ++k) expected_slope.col(k) += functions.slope(space.powers[f], k) * by;
    }
    EXPECT_LT((u - expected).norm(), 1e-11 * expected.norm());
    EXPECT_LT((slope - expected_slope).norm(), 1e-11 * expected_slope.norm());
}

TEST(WingFields, AreOrthogonalZeroOnWhatIsHeldAndTheGradientIsTheTranspose) {
    Example example(lofted(loft()), 36);
    example.hold_root();
    const DisplacementFields fields = example.fields();
    ASSERT_EQ(fields.size(), 36);
    ASSERT_FALSE(example.conditions.held.empty());
    Eigen::MatrixXd columns(3 * example.mesh.num_vertices(), fields.size());
    for (int b = 0; b < fields.size(); ++b) {
        const Points u = fields.field(b);
        EXPECT_NEAR(u.rowwise().norm().maxCoeff(), 1, 1e-12) << fields.name(b);
        for (const int t : example.conditions.held)
            for (const int v : example.mesh.triangles.row(t)) EXPECT_TRUE(u.row(v).isZero(0)) << fields.name(b);
        for (int v = 0; v < example.mesh.num_vertices(); ++v) {
            if (example.mesh.vertices(v, 1) == 0) {
                EXPECT_EQ(u(v, 1), 0);
            }
        }
        const Points scaled = vertex_areas(example.mesh).cwiseSqrt().asDiagonal() * u;
        columns.col(b) = VectorXd::Map(scaled.data(), scaled.size()).normalized();
    }
    EXPECT_LT((columns.transpose() * columns - Eigen::MatrixXd::Identity(36, 36)).cwiseAbs().maxCoeff(), 1e-9);
    const VectorXd z = random_vector(36, 2), dz = random_vector(36, 3);
    const Points weight = Eigen::Map<const Points>(random_vector(3 * example.mesh.num_vertices(), 4).eval().data(),
                                                   example.mesh.num_vertices(), 3);
    EXPECT_NEAR(fields.gradient(weight).dot(dz), fields.displacement(dz).cwiseProduct(weight).sum(), 1e-10);
    const auto at = fields.local_maps(z), beside = fields.local_maps(z + dz);
    const Matrix3d by = (Matrix3d() << 1, -2, 0.5, 3, 0.1, -1, 0.7, 2, 1).finished();
    for (const int t : {0, 300, 700}) {
        const double change = (beside[t] - at[t]).cwiseProduct(by).sum();
        EXPECT_NEAR(fields.map_gradient(t, by).dot(dz), change, 1e-10 * (1 + std::abs(change))) << t;
    }
    // The first of more are the fewer.
    example.options.number = 12;
    const DisplacementFields few = example.fields();
    for (int b = 0; b < 12; ++b) EXPECT_LT((few.field(b) - fields.field(b)).cwiseAbs().maxCoeff(), 1e-9);
}

/// By a corner of edges that are so short that they tell the gradient of the map.
TEST(WingFields, LocalMapsAreThoseOfTheMotion) {
    Example example(lofted(loft()), 30);
    example.hold_root();
    TriMesh& mesh = example.mesh;
    const int first = mesh.num_vertices(), t = mesh.num_triangles();
    const double edge = 1e-5;
    mesh.vertices.conservativeResize(first + 4, 3);
    mesh.triangles.conservativeResize(t + 2, 3);
    const Vector3d at(1.2, 1.71, 0.2);
    mesh.vertices.row(first) = at;
    for (int k = 0; k < 3; ++k) mesh.vertices.row(first + 1 + k) = at + edge * Vector3d::Unit(k);
    mesh.triangles.row(t) << first, first + 1, first + 2;
    mesh.triangles.row(t + 1) << first, first + 1, first + 3;
    const DisplacementFields fields = example.fields();
    const VectorXd z = 0.1 * random_vector(30, 11);
    const Points u = fields.displacement(z);
    Matrix3d F = Matrix3d::Identity();
    for (int k = 0; k < 3; ++k) F.col(k) += (u.row(first + 1 + k) - u.row(first)).transpose() / edge;
    EXPECT_LT((fields.local_maps(z)[static_cast<std::size_t>(t)] - F).norm(), 1e-3 * (F - Matrix3d::Identity()).norm());
    EXPECT_GT((F - Matrix3d::Identity()).norm(), 0.05) << "the test can fail";
}

TEST(WingFields, OfAHalfAreThoseOfTheWholeThatAreSymmetric) {
    const Loft of = loft();
    const Example half(lofted(of));
    Example whole(lofted(of, true), 24, {});
    whole.conditions.mirror = centre;
    const DisplacementFields a = half.fields(), b = whole.fields();
    ASSERT_EQ(a.size(), b.size());
    const VectorXd z = random_vector(a.size(), 3);
    const Points u = a.displacement(z), w = b.displacement(z);
    double off = 0;
    int found = 0;
    for (int v = 0; v < half.mesh.num_vertices(); ++v)
        for (int x = 0; x < whole.mesh.num_vertices(); ++x) {
            const Vector3d here = half.mesh.vertices.row(v), there = whole.mesh.vertices.row(x);
            if ((here - there).norm() < 1e-12) off = std::max(off, (u.row(v) - w.row(x)).norm()), ++found;
            if ((here - Vector3d(there[0], -there[1], there[2])).norm() < 1e-12)
                off = std::max(off, (u.row(v) - Eigen::RowVector3d(w(x, 0), -w(x, 1), w(x, 2))).norm());
        }
    EXPECT_EQ(found, half.mesh.num_vertices());
    EXPECT_LT(off, 1e-10);
    for (int k = 0; k < a.size(); ++k) EXPECT_EQ(a.name(k), b.name(k));
    // Without a plane both sides may do the opposite, too.
    whole.conditions.mirror.reset();
    whole.options.number = 40;
    const DisplacementFields all = whole.fields();
    bool has_opposite = false;
    for (int k = 0; k < all.size(); ++k) has_opposite |= all.name(k).ends_with(".opposite");
    EXPECT_TRUE(has_opposite);
}

TEST(WingFields, IgnoreUnitsAndNumbers) {
    Example example(lofted(loft()), 27);
    const VectorXd z = random_vector(27, 5);
    const Points u = example.fields().displacement(z);
    Example larger(
        [] {
            TriMesh mesh = lofted(loft());
            mesh.vertices *= 1000;
            return mesh;
        }(),
        27);
    EXPECT_LT((larger.fields().displacement(z) - u).cwiseAbs().maxCoeff(), 1e-8);
    std::vector<int> order;
    const Example other(renumbered(example.mesh, 7, &order), 27);
    const Points v = other.fields().displacement(z);
    for (int i = 0; i < v.rows(); ++i) EXPECT_LT((v.row(i) - u.row(order[static_cast<std::size_t>(i)])).norm(), 1e-8);
}

/// What a designer of airfoils asks for: more camber and a drooped nose, growing along the span.
TEST(WingFields, ReshapeSectionsWhereSectionsOfABodyCannot) {
    Example example(lofted(loft()), 24);
    example.hold_root();
    Points camber(example.mesh.num_vertices(), 3), nose = camber;
    for (int v = 0; v < camber.rows(); ++v) {
        const auto at = example.options.wing->at(example.mesh.vertices.row(v));
        const double xi = std::clamp(at.xi, 0.0, 1.0), front = std::max(0.0, (0.3 - xi) / 0.3);
        camber.row(v) = at.s * 4 * xi * (1 - xi) * Vector3d::UnitZ();
        nose.row(v) = -at.s * front * front * Vector3d::UnitZ();
    }
    for (const int t : example.conditions.held)
        for (const int v : example.mesh.triangles.row(t)) camber.row(v).setZero(), nose.row(v).setZero();
    const DisplacementFields of_wing = example.fields();
    example.options.wing.reset();
    const DisplacementFields sections = example.fields();
    EXPECT_LT(left_over(example.mesh, of_wing, camber), 0.01);
    EXPECT_GT(left_over(example.mesh, sections, camber), 0.1);
    EXPECT_LT(left_over(example.mesh, of_wing, nose), 0.1);
    EXPECT_GT(left_over(example.mesh, sections, nose), 0.3);
}

/// Both edges of all sections, which those of the body lose most of themselves to.
TEST(WingFields, OfAWingThatKeepsItsPlanformKeepItThemselves) {
    Example example(lofted(loft()), 24);
    example.options.keeps_planform = true;
    const KeptSections kept(example.mesh, {example.wing}, {});
    const DisplacementFields fields = example.fields();
    EXPECT_EQ(fields.name(0), "wing.camber.2.s0");
    const auto left = [&](const Points& u) { return kept.rate(nullptr, u).norm() / u.norm(); };
    for (int b = 0; b < fields.size(); ++b) EXPECT_GT(left(fields.field(b)), 0.8) << fields.name(b);
    example.options.wing.reset();
    const DisplacementFields sections = example.fields();
    int lost = 0;
    for (int b = 0; b < sections.size(); ++b) lost += left(sections.field(b)) < 0.1;
    EXPECT_GT(lost, 6);
}

TEST(WingFields, NothingHeldLeavesNoRigidMotion) {
    const Example example(lofted(loft()), 27);
    const DisplacementFields fields = example.fields();
    const VectorXd area = vertex_areas(example.mesh);
    const Points& x = example.mesh.vertices;
    for (int b = 0; b < fields.size(); ++b) {
        const Points u = fields.field(b);
        EXPECT_LT(std::abs(area.dot(u.col(0))), 1e-9 * area.sum()) << fields.name(b);
        EXPECT_LT(std::abs(area.dot(u.col(2))), 1e-9 * area.sum());
        const VectorXd turn = x.col(2).cwiseProduct(u.col(0)) - x.col(0).cwiseProduct(u.col(2));
        EXPECT_LT(std::abs(area.dot(turn)), 1e-8 * area.sum());
    }
}

TEST(WingFields, RefusalsSayWhy) {
    Example example(lofted(loft()));
    const auto refused = [&](const Example& of) { EXPECT_THROW(of.fields(), InvalidInput); };
    Example other = example;
    other.options.motions = {"grow"};
    refused(other);
    other.options.motions = {"camber"};
    for (int b = 0; b < 3; ++b) EXPECT_NE(other.fields().name(b).find(".camber."), std::string::npos);
    other = example;
    other.options.axis = Vector3d::UnitY();
    refused(other);
    other = example;
    other.conditions.cut.reset();
    other.conditions.mirror = SymmetryPlane{Vector3d::UnitZ(), 0};
    refused(other);
    Loft of = loft();
    of.winglet = 0.15;
    of.quarter = [](double) { return 0.25; };
    const TriMesh mesh = lofted(of);
    WingDeclaration declared;
    declared.symmetry = centre;
    const Wing with_winglet(mesh, declared);
    ASSERT_TRUE(with_winglet.has_winglet());
    EXPECT_THROW(wing_lines(mesh, with_winglet), InvalidInput);
}

}  // namespace
}  // namespace strake
