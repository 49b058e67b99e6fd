#include "core/fields/displacement_fields.hpp"

#include "core/error.hpp"
#include "core/fields/typical_motions.hpp"
#include "core/mesh/geometry.hpp"
#include "surfaces.hpp"
#include "tests/core/fields/left_over.hpp"
#include "tests/core/patches/shapes.hpp"

#include <gtest/gtest.h>
#include <Eigen/SVD>
#include <functional>
#include <random>

namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

using Motion = std::function<Vector3d(const Vector3d&)>;

Points motion_of(const TriMesh& mesh, const Motion& motion) {
    Points u(mesh.num_vertices(), 3);
    for (int v = 0; v < mesh.num_vertices(); ++v) u.row(v) = motion(mesh.vertices.row(v)).transpose();
    return u;
}

std::vector<int> triangles_where(const TriMesh& mesh, const std::function<bool(const Vector3d&)>& inside) {
    std::vector<int> found;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        bool all = true;
        for (int k = 0; k < 3; ++k) all &= inside(mesh.vertices.row(mesh.triangles(t, k)));
        if (all) found.push_back(t);
    }
    return found;
}

VectorXd random_values(int size, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    VectorXd z(size);
    for (double& value : z) value = uniform(random);
    return z;
}

/// A wing of semispan 1 or so, swept, that is held at its root.
struct HeldWing {
    TriMesh mesh = naca0012_wing(24, 24, 3);
    FieldConditions conditions;
    HeldWing() {
        for (int v = 0; v < mesh.num_vertices(); ++v) mesh.vertices(v, 0) += 0.3 * mesh.vertices(v, 1);
        conditions.held = triangles_where(mesh, [](const Vector3d& x) { return x[1] < 0.13; });
    }
};

TEST(DisplacementFields, AreExactlyZeroOnWhatIsHeldAndOfSizeOne) {
    const HeldWing wing;
    const DisplacementFields fields(wing.mesh, wing.conditions, {60, {}});
    ASSERT_EQ(fields.size(), 60);
    ASSERT_FALSE(wing.conditions.held.empty());
    for (int b = 0; b < fields.size(); ++b) {
        const Points u = fields.field(b);
        EXPECT_NEAR(u.rowwise().norm().maxCoeff(), 1, 1e-12);
        for (const int t : wing.conditions.held)
            for (int k = 0; k < 3; ++k) EXPECT_TRUE(u.row(wing.mesh.triangles(t, k)).isZero(0)) << fields.name(b);
    }
}

TEST(DisplacementFields, TheGradientByOneVertexHasTheBitsOfThatByAll) {
    const HeldWing wing;
    const DisplacementFields fields(wing.mesh, wing.conditions, {40, {}});
    const Vector3d g(0.3, -2, 0.7);
    for (const int v : {0, 1000, wing.mesh.num_vertices() - 1}) {
        Points all = Points::Zero(wing.mesh.num_vertices(), 3);
        all.row(v) = g.transpose();
        EXPECT_EQ(fields.gradient(v, g), fields.gradient(all)) << v;
    }
    EXPECT_GT(fields.gradient(1000, g).norm(), 1e-3);
}

TEST(DisplacementFields, TheGradientOfAMapIsTheTransposeOfTheMaps) {
    const HeldWing wing;
    const DisplacementFields fields(wing.mesh, wing.conditions, {20, {}});
    const VectorXd z = random_values(fields.size(), 2), step = random_values(fields.size(), 7);
    const auto at = fields.local_maps(z), beside = fields.local_maps(z + step);
    const Matrix3d weight = (Matrix3d() << 1, -2, 0.5, 3, 0.1, -1, 0.7, 2, 1).finished();
    for (const int t : {0, 100, static_cast<int>(at.size()) - 1}) {
        const double change = (beside[t] - at[t]).cwiseProduct(weight).sum();  // maps are linear in z
        EXPECT_NEAR(fields.map_gradient(t, weight).dot(step), change, 1e-11 * (1 + std::abs(change))) << t;
    }
    EXPECT_GT((fields.map_gradient(300, weight) - fields.map_gradient(301, weight)).norm(), 1e-6) << "of its triangle";
    EXPECT_THROW(fields.map_gradient(-1, weight), InvalidInput);
}

/// Splines along the axis: as exact as polynomials.
TEST(DisplacementFields, OfSplinesAreOrthogonalAndTheirMapsAreTheDerivatives) {
    const HeldWing wing;
    const DisplacementFields fields(
        wing.mesh, wing.conditions,
        {.number = 40, .axis = Vector3d::UnitY(), .motions = {"twist", "scale"}, .along = AlongAxis::splines});
    ASSERT_EQ(fields.size(), 40);
    Eigen::MatrixXd columns(3 * wing.mesh.num_vertices(), fields.size());
    for (int b = 0; b < fields.size(); ++b) {
        const Points u = vertex_areas(wing.mesh).cwiseSqrt().asDiagonal() * fields.field(b);
        columns.col(b) = VectorXd::Map(u.data(), u.size()).normalized();
        for (const int t : wing.conditions.held)
            for (int k = 0; k < 3; ++k) EXPECT_TRUE(fields.field(b).row(wing.mesh.triangles(t, k)).isZero(0));
    }
    EXPECT_LT((columns.transpose() * columns - Eigen::MatrixXd::Identity(40, 40)).cwiseAbs().maxCoeff(), 1e-9);
    // The first fields are those of fewer, so that finer levels keep the shape.
    const DisplacementFields few(
        wing.mesh, wing.conditions,
        {.number = 9, .axis = Vector3d::UnitY(), .motions = {"twist", "scale"}, .along = AlongAxis::splines});
    for (int b = 0; b < few.size(); ++b) EXPECT_LT((few.field(b) - fields.field(b)).cwiseAbs().maxCoeff(), 1e-9);
}

/// What polynomials cannot: a tent along the axis, wherever its kinks are.
TEST(DisplacementFields, SplinesMakeAKink) {
    const TriMesh body = capped_cylinder(16, 160, 0.2, 2);
    const double middle = 0.5 * (body.vertices.col(0).maxCoeff() + body.vertices.col(0).minCoeff());
    const Points tent = motion_of(body, [&](const Vector3d& x) {
        return Vector3d(std::max(0.0, 0.5 - std::abs(x[0] - middle - 0.1234)) * Vector3d(0, x[1], x[2]));
    });
    std::vector<double> left;
    for (const int number : {14, 35})
        for (const AlongAxis along : {AlongAxis::polynomials, AlongAxis::splines}) {
            const FieldOptions options{
                .number = 2 * number, .axis = Vector3d::UnitX(), .motions = {"scale"}, .along = along};
            left.push_back(left_over(body, DisplacementFields(body, {}, options), tent));
        }
    EXPECT_LT(left[3], 0.5 * left[2]) << left[2];
    EXPECT_LT(left[3], 0.3 * left[1]) << "more of them follow it closer";
}

TEST(FunctionsAlong, SplinesAreThoseOfAllKnotsUpToTheirLevel) {
    const int last = 18;  // four polynomials, and 15 splines around the knots of 16 intervals
    const int samples = 401;
    Eigen::MatrixXd values(samples, last + 1), powers(samples, 2);
    for (int n = 0; n < samples; ++n) {
        const double s = -1 + 2.0 * n / (samples - 1);
        const FunctionsAlong at(AlongAxis::splines, s, last);
        values.row(n) = VectorXd::Map(at.value.data(), last + 1).transpose();
        powers(n, 0) = std::pow(std::max(0.0, s - 0.375), 3);   // a knot of sixteen
        powers(n, 1) = std::pow(std::max(0.0, s - 0.4375), 3);  // of thirty-two
    }
    const auto rest = [&](int count, int k) {
        const Eigen::MatrixXd some = values.leftCols(count);
        return (some * some.colPivHouseholderQr().solve(powers.col(k)) - powers.col(k)).norm() / powers.col(k).norm();
    };
    EXPECT_EQ(values.colPivHouseholderQr().rank(), last + 1);
    EXPECT_LT(rest(last + 1, 0), 1e-12);
    EXPECT_GT(rest(last + 1, 1), 1e-5);
    EXPECT_GT(rest(last, 0), 1e-5) << "the last one is needed";
}

TEST(FunctionsAlong, SlopesAreDerivativesAndEvenNumbersAreEven) {
    for (const AlongAxis along : {AlongAxis::polynomials, AlongAxis::splines})
        for (const double s : {-0.93, -0.31, 0.0, 0.2, 0.77}) {
            const double h = 1e-5;
            const int last = 70;
            const FunctionsAlong at(along, s, last), image(along, -s, last), ahead(along, s + h, last),
                behind(along, s - h, last);
            for (int n = 0; n <= last; ++n) {
                const double slope = (ahead.value[n] - behind.value[n]) / (2 * h);
                EXPECT_NEAR(at.slope[n], slope, 1e-4 * (1 + std::abs(slope))) << n << " at " << s;
                EXPECT_NEAR(image.value[n], (n % 2 == 0 ? 1 : -1) * at.value[n], 1e-13) << n << " at " << s;
            }
            FunctionsAlong reused(along, 0.5, last);
            reused.set(s);
            EXPECT_EQ(reused.value, at.value);
            EXPECT_EQ(reused.slope, at.slope);
        }
}

/// A file may keep points that are none of the surface, wherever they are.
TEST(DisplacementFields, AreThoseOfTheSurfaceWithoutItsLooseVertices) {
    HeldWing wing;
    // No station is where slices of typical motions meet: rounding would choose its slice.
    wing.mesh = naca0012_wing(24, 23, 3);
    wing.conditions.held = triangles_where(wing.mesh, [](const Vector3d& x) { return x[1] < 0.13; });
    TriMesh loose = wing.mesh;
    const int n = loose.num_vertices();
    loose.vertices.conservativeResize(n + 2, 3);
    loose.vertices.bottomRows(2) << 1000, -30, 7, 0.5, 0.5, 0.01;
    for (const bool is_held : {true, false}) {
        const FieldConditions conditions = is_held ? wing.conditions : FieldConditions{};
        const DisplacementFields alone(wing.mesh, conditions, {30, {}}), beside(loose, conditions, {30, {}});
        ASSERT_EQ(alone.size(), beside.size());
        for (int b = 0; b < alone.size(); ++b) {
            EXPECT_EQ(alone.name(b), beside.name(b));
            const Points u = beside.field(b);
            EXPECT_LT((alone.field(b) - u.topRows(n)).cwiseAbs().maxCoeff(), 1e-12) << alone.name(b);
            EXPECT_TRUE(u.bottomRows(2).isZero(0)) << "what no triangle uses stays";
        }
        const std::vector<TypicalMotion> of_body = typical_motions(wing.mesh, conditions, {}),
                                         of_both = typical_motions(loose, conditions, {});
        ASSERT_EQ(of_body.size(), of_both.size());
        for (std::size_t k = 0; k < of_body.size(); ++k)
            EXPECT_LT((of_body[k].displacement - of_both[k].displacement.topRows(n)).cwiseAbs().maxCoeff(), 1e-12)
                << of_body[k].name;
    }
}

TEST(DisplacementFields, AreOrthogonalInTheMeanAndTheGradientIsTheTranspose) {
    const HeldWing wing;
    const DisplacementFields fields(wing.mesh, wing.conditions, {36, {}});
    Eigen::MatrixXd columns(3 * wing.mesh.num_vertices(), fields.size());
    for (int b = 0; b < fields.size(); ++b) {
        const Points u = vertex_areas(wing.mesh).cwiseSqrt().asDiagonal() * fields.field(b);
        columns.col(b) = VectorXd::Map(u.data(), u.size()).normalized();
    }
    const Eigen::MatrixXd gram = columns.transpose() * columns;
    EXPECT_LT((gram - Eigen::MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff(), 1e-8);
    const VectorXd z = random_values(fields.size(), 3);
    Points slope(wing.mesh.num_vertices(), 3);
    slope.reshaped() = random_values(3 * wing.mesh.num_vertices(), 4);
    const double forward = fields.displacement(z).cwiseProduct(slope).sum(), back = z.dot(fields.gradient(slope));
    EXPECT_NEAR(forward, back, 1e-12 * (1 + std::abs(forward)));
    Points sum = Points::Zero(wing.mesh.num_vertices(), 3);
    for (int b = 0; b < fields.size(); ++b) sum += z[b] * fields.field(b);
    EXPECT_LT((sum - fields.displacement(z)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(DisplacementFields, TheFirstOfMoreAreTheFewer) {
    const HeldWing wing;
    const DisplacementFields many(wing.mesh, wing.conditions, {60, {}});
    std::vector<std::string> names;
    for (const int number : {6, 12, 27}) {
        const DisplacementFields few(wing.mesh, wing.conditions, {number, {}});
        ASSERT_EQ(few.size(), number);
        for (int b = 0; b < number; ++b) {
            EXPECT_EQ(few.name(b), many.name(b));
            EXPECT_LT((few.field(b) - many.field(b)).cwiseAbs().maxCoeff(), 1e-9) << few.name(b);
        }
    }
    for (int b = 0; b < many.size(); ++b) names.push_back(many.name(b));
    std::sort(names.begin(), names.end());
    EXPECT_EQ(std::unique(names.begin(), names.end()), names.end()) << "a name once";
    EXPECT_TRUE(std::binary_search(names.begin(), names.end(), "section.twist.1"));
    EXPECT_TRUE(std::binary_search(names.begin(), names.end(), "section.scale_x.0"));
}

/// Motions that a designer thinks of; y is measured from what is held, zeta and xi from the local quarter chord.
std::vector<std::pair<std::string, Motion>> wing_motions() {
    const auto y = [](const Vector3d& x) { return std::max(0.0, x[1] - 0.125); };
    const auto xi = [](const Vector3d& x) { return x[0] - 0.3 * x[1] - 0.25; };
    return {{"bend", [=](const Vector3d& x) { return Vector3d(0, 0, y(x) * y(x)); }},
            {"twist", [=](const Vector3d& x) { return Vector3d(y(x) * x[2], 0, -y(x) * xi(x)); }},
            {"sweep", [=](const Vector3d& x) { return Vector3d(y(x), 0, 0); }},
            {"taper", [=](const Vector3d& x) { return Vector3d(-y(x) * xi(x), 0, -y(x) * x[2]); }},
            {"thicken", [=](const Vector3d& x) { return Vector3d(0, 0, y(x) * y(x) * x[2]); }},
            {"span", [=](const Vector3d& x) { return Vector3d(0, y(x), 0); }}};
}

TEST(DisplacementFields, MakeWhatADesignerMeansOnAWing) {
    const HeldWing wing;
    const DisplacementFields fields(wing.mesh, wing.conditions, {36, {}});
    for (const auto& [name, motion] : wing_motions())
        EXPECT_LT(left_over(wing.mesh, fields, motion_of(wing.mesh, motion)), 0.03) << name;
}

TEST(DisplacementFields, MakeWhatADesignerMeansOnABodyThatNothingHolds) {
    const TriMesh body = ellipsoid({3, 1, 0.6}, 3);
    const DisplacementFields fields(body, {}, {36, {}});
    const std::vector<std::pair<std::string, Motion>> motions{
        {"bend", [](const Vector3d& x) { return Vector3d(0, 0, x[0] * x[0] - 3); }},
        {"twist", [](const Vector3d& x) { return Vector3d(0, -x[0] * x[2], x[0] * x[1]); }},
        {"sweep", [](const Vector3d& x) { return Vector3d(0, x[0] * x[0] - 3, 0); }},
        {"taper", [](const Vector3d& x) { return Vector3d(0, x[0] * x[1], x[0] * x[2]); }},
        {"swell",
         [](const Vector3d& x) -> Vector3d { return Vector3d(Vector3d(0, x[1], x[2]) * (1 - x[0] * x[0] / 9)); }},
        {"flatten", [](const Vector3d& x) { return Vector3d(0, 0.2 * x[1], -0.2 * x[2]); }},
        {"longer", [](const Vector3d& x) { return Vector3d(x[0], 0, 0); }}};
    for (const auto& [name, motion] : motions) {
        Points wanted = motion_of(body, motion);
        const VectorXd area = vertex_areas(body);
        wanted.rowwise() -= (area.transpose() * wanted).eval() / area.sum();  // fields move nothing as a whole
        EXPECT_LT(left_over(body, fields, wanted), 0.03) << name;
    }
}

TEST(DisplacementFields, NothingHeldLeavesNoRigidMotion) {
    const TriMesh body = ellipsoid({3, 1, 0.6}, 2);
    const DisplacementFields fields(body, {}, {27, {}});
    const VectorXd area = vertex_areas(body);
    for (int b = 0; b < fields.size(); ++b) {
        const Points u = area.asDiagonal() * fields.field(b);
        EXPECT_LT(u.colwise().sum().norm(), 1e-9 * area.sum()) << fields.name(b);
        Vector3d moment = Vector3d::Zero();
        for (int v = 0; v < body.num_vertices(); ++v)
            moment += Vector3d(body.vertices.row(v)).cross(Vector3d(u.row(v)));
        EXPECT_LT(moment.norm(), 1e-9 * area.sum()) << fields.name(b);
    }
    FieldConditions keeps;
    keeps.keeps_rigid_motions = true;
    EXPECT_EQ(DisplacementFields(body, keeps, {6, {}}).name(0), "section.move_x.0");
}

TEST(DisplacementFields, OfAHalfAreThoseOfTheWholeThatAreSymmetric) {
    const HalfAndWhole box = crooked_box(4);
    const SymmetryPlane plane{Vector3d::UnitY(), 1};
    FieldConditions of_half, of_whole;
    of_half.cut = plane;
    of_whole.mirror = plane;
    const auto low = [](const Vector3d& x) { return x[2] < 0.3; };
    of_half.held = triangles_where(box.half, low);
    of_whole.held = triangles_where(box.whole, low);
    const DisplacementFields half(box.half, of_half, {30, {}}), whole(box.whole, of_whole, {30, {}});
    const std::vector<char> used = used_vertices(box.whole);
    for (int b = 0; b < half.size(); ++b) {
        const Points u = half.field(b);
        for (int v = 0; v < box.half.num_vertices(); ++v) {
            if (std::abs(box.half.vertices(v, 1) - 1) < 1e-12) {
                EXPECT_EQ(u(v, 1), 0) << half.name(b);
            }
        }
        const Points w = whole.field(b);
        for (int v = 0; v < box.whole.num_vertices(); ++v)
            for (int other = 0; other < box.whole.num_vertices(); ++other) {
                if (!used[static_cast<std::size_t>(v)] || !used[static_cast<std::size_t>(other)]) continue;
                const Vector3d image(box.whole.vertices(v, 0), 2 - box.whole.vertices(v, 1), box.whole.vertices(v, 2));
                if ((Vector3d(box.whole.vertices.row(other)) - image).norm() > 1e-9) continue;
                EXPECT_NEAR(w(v, 0), w(other, 0), 1e-9);
                EXPECT_NEAR(w(v, 1), -w(other, 1), 1e-9);
                EXPECT_NEAR(w(v, 2), w(other, 2), 1e-9);
            }
        EXPECT_EQ(half.name(b), whole.name(b));
    }
}

/// A held part beside the plane is there twice in the whole, and its two ramps are two.
TEST(DisplacementFields, OfAHalfKnowTheImagesOfWhatIsHeldBesideThePlane) {
    const HalfAndWhole box = crooked_box(6);
    const SymmetryPlane plane{Vector3d::UnitY(), 1};
    const auto beside = [](const Vector3d& x) { return x[0] < 0.9 && std::abs(x[1] - 1) > 0.3; };
    for (const bool smooth : {false, true}) {
        FieldConditions of_half, of_whole;
        of_half.cut = plane;
        of_whole.mirror = plane;
        of_half.smooth_border = of_whole.smooth_border = smooth;
        of_half.held = triangles_where(box.half, beside);
        of_whole.held = triangles_where(box.whole, beside);
        ASSERT_GT(of_half.held.size(), 2u);
        ASSERT_EQ(of_whole.held.size(), 2 * of_half.held.size());
        const DisplacementFields half(box.half, of_half, {12, {}}), whole(box.whole, of_whole, {12, {}});
        ASSERT_EQ(half.size(), whole.size());
        const VectorXd z = random_values(half.size(), 3);
        const Points u = half.displacement(z), w = whole.displacement(z);
        const Points of = triangle_centroids(box.half), all = triangle_centroids(box.whole);
        const auto turn = half.local_maps(0.1 * z), turns = whole.local_maps(0.1 * z);
        double off = 0, maps_off = 0;
        const std::vector<char> in_half = used_vertices(box.half), in_whole = used_vertices(box.whole);
        for (int v = 0; v < box.half.num_vertices(); ++v) {
            if (!in_half[static_cast<std::size_t>(v)]) continue;
            Eigen::Index same = 0;
            VectorXd distance = (box.whole.vertices.rowwise() - box.half.vertices.row(v)).rowwise().norm();
            for (Eigen::Index k = 0; k < distance.size(); ++k)
                if (!in_whole[static_cast<std::size_t>(k)]) distance[k] = 1e9;
            distance.minCoeff(&same);
            off = std::max(off, (u.row(v) - w.row(same)).norm());
        }
        for (int t = 0; t < box.half.num_triangles(); ++t) {
            Eigen::Index same = 0;
            (all.rowwise() - of.row(t)).rowwise().norm().minCoeff(&same);
            maps_off =
                std::max(maps_off, (turn[static_cast<std::size_t>(t)] - turns[static_cast<std::size_t>(same)]).norm());
        }
        EXPECT_LT(off, 1e-8) << smooth;  // of displacements of about 1
        EXPECT_LT(maps_off, 1e-8) << smooth;
    }
}

/// Twenty small held spots on a plate: a product of twenty ramps would leave motion at a few places only.
TEST(DisplacementFields, ManyHeldSpotsLeaveRoomBetweenThem) {
    const TriMesh plate = box_surface({5, 4, 0.2}, 5);
    FieldConditions conditions;
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 4; ++j) {
            const Eigen::RowVector3d at(i + 0.5, j + 0.5, 0.2);
            Eigen::Index t = 0;
            (triangle_centroids(plate).rowwise() - at).rowwise().norm().minCoeff(&t);
            conditions.held.push_back(static_cast<int>(t));
        }
    const DisplacementFields fields(plate, conditions, {6, {}});
    const VectorXd size = fields.field(2).rowwise().norm();
    std::vector<double> sorted(size.begin(), size.end());
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    EXPECT_GT(sorted[sorted.size() / 2], 0.05);  // half of the vertices; with twenty factors below 1 it is 1e-6
    for (const int t : conditions.held)
        for (int k = 0; k < 3; ++k) EXPECT_EQ(size[plate.triangles(t, k)], 0);
}

TEST(DisplacementFields, FollowTheBodyAndIgnoreUnitsAndNumbers) {
    const HeldWing wing;
    const DisplacementFields fields(wing.mesh, wing.conditions, {27, {}});
    const VectorXd z = random_values(27, 5);
    const Points u = fields.displacement(z);

    TriMesh larger = wing.mesh;
    larger.vertices *= 1000;
    EXPECT_LT((DisplacementFields(larger, wing.conditions, {27, {}}).displacement(z) - u).cwiseAbs().maxCoeff(), 1e-8);

    std::vector<int> vertex_order, triangle_order;
    const TriMesh other = renumbered(wing.mesh, 7, &vertex_order, &triangle_order);
    FieldConditions conditions;
    std::vector<char> held(static_cast<std::size_t>(wing.mesh.num_triangles()), 0);
    for (const int t : wing.conditions.held) held[static_cast<std::size_t>(t)] = 1;
    for (int t = 0; t < other.num_triangles(); ++t)
        if (held[static_cast<std::size_t>(triangle_order[static_cast<std::size_t>(t)])]) conditions.held.push_back(t);
    const Points of_other = DisplacementFields(other, conditions, {27, {}}).displacement(z);
    for (int v = 0; v < other.num_vertices(); ++v)
        EXPECT_LT((of_other.row(v) - u.row(vertex_order[static_cast<std::size_t>(v)])).norm(), 1e-8);

    // Turned by little: the axes keep their names and the motions turn along.
    const Matrix3d turn = Eigen::AngleAxisd(0.2, Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
    TriMesh turned = wing.mesh;
    turned.vertices = (wing.mesh.vertices * turn.transpose()).rowwise() + Eigen::RowVector3d(5, -3, 1);
    const Points of_turned = DisplacementFields(turned, wing.conditions, {27, {}}).displacement(z);
    EXPECT_LT((of_turned - u * turn.transpose()).cwiseAbs().maxCoeff(), 1e-7);
}

/// The sections of a body that is about as wide as long follow each other from nose to tail.
TEST(DisplacementFields, BodiesAsWideAsLongHaveTheirAxisInThePlaneOfSymmetry) {
    const SymmetryPlane middle{Vector3d::UnitY(), 0};
    const auto axis = [&](double width, bool is_half, bool by_extent_alone) {
        TriMesh mesh = ellipsoid({1, width, 0.3}, 3);
        FieldConditions conditions;
        if (is_half) {
            std::vector<Eigen::RowVector3i> kept;
            for (int t = 0; t < mesh.num_triangles(); ++t)
                if (triangle_centroids(mesh)(t, 1) > 0) kept.emplace_back(mesh.triangles.row(t));
            mesh.triangles.resize(static_cast<Eigen::Index>(kept.size()), 3);
            for (std::size_t t = 0; t < kept.size(); ++t) mesh.triangles.row(static_cast<Eigen::Index>(t)) = kept[t];
        }
        (is_half ? conditions.cut : conditions.mirror) = middle;
        FieldOptions options{12, {}};
        options.axis_by_extent_alone = by_extent_alone;
        return DisplacementFields(mesh, conditions, options).frame().letter[0];
    };
    for (const bool is_half : {false, true}) {
        EXPECT_EQ(axis(0.9, is_half, false), 'x');
        EXPECT_EQ(axis(1.03, is_half, false), 'x');
        EXPECT_EQ(axis(1.03, is_half, true), 'y') << "runs of before";
        EXPECT_EQ(axis(1.08, is_half, false), 'y');
    }
}

TEST(DisplacementFields, RotationsArePolarPartsOfTheMapsGradient) {
    // A tetrahedron that is so small that its corners tell the map's gradient.
    TriMesh body = ellipsoid({3, 1, 0.6}, 2);
    const int first = body.num_vertices(), t = body.num_triangles();
    const double edge = 1e-5;
    body.vertices.conservativeResize(first + 4, 3);
    body.triangles.conservativeResize(t + 2, 3);
    const Vector3d at(1.1, 0.3, 0.2);
    body.vertices.row(first) = at;
    for (int k = 0; k < 3; ++k) body.vertices.row(first + 1 + k) = at + edge * Vector3d::Unit(k);
    body.triangles.row(t) << first, first + 1, first + 2;
    body.triangles.row(t + 1) << first, first + 1, first + 3;
    FieldConditions conditions;
    conditions.held = triangles_where(body, [](const Vector3d& x) { return x[0] < -2; });
    const DisplacementFields fields(body, conditions, {27, {}});
    for (const double size : {0.3, 1.5}) {
        const VectorXd z = size * random_values(27, 11);
        const Points u = fields.displacement(z);
        Matrix3d F = Matrix3d::Identity();
        for (int k = 0; k < 3; ++k) F.col(k) += (u.row(first + 1 + k) - u.row(first)).transpose() / edge;
        ASSERT_GT(F.determinant(), 0);
        const Eigen::JacobiSVD<Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
        const Matrix3d turn = svd.matrixU() * svd.matrixV().transpose();
        EXPECT_LT((fields.rotations(z)[static_cast<std::size_t>(t)] - turn).norm(), 1e-3);
        EXPECT_GT(Eigen::AngleAxisd(turn).angle(), 0.05) << "the test can fail";
    }
    EXPECT_EQ(fields.rotations(VectorXd::Zero(27))[0], Matrix3d::Identity());
}

TEST(DisplacementFields, FlatBodiesHaveNoFunctionAcrossAndRefusalsNameTheLimit) {
    const TriMesh plate = strip(4, 1, 12, 4);
    FieldConditions conditions;
    conditions.held = triangles_where(plate, [](const Vector3d& x) { return x[0] < 0.4; });
    const DisplacementFields fields(plate, conditions, {27, {}});
    EXPECT_EQ(fields.size(), 27);
    for (int b = 0; b < fields.size(); ++b) EXPECT_TRUE(fields.field(b).allFinite());
    EXPECT_THROW(DisplacementFields(plate, {}, {0, {}}), InvalidInput);
    EXPECT_THROW(DisplacementFields(plate, {}, {6, Vector3d(0, 0, 2)}), InvalidInput);
    conditions.held.clear();
    for (int t = 0; t < plate.num_triangles(); ++t) conditions.held.push_back(t);
    EXPECT_THROW(DisplacementFields(plate, conditions, {6, {}}), InvalidInput);
    conditions.held = {plate.num_triangles()};
    EXPECT_THROW(DisplacementFields(plate, conditions, {6, {}}), InvalidInput);
    FieldConditions oblique;
    oblique.mirror = SymmetryPlane{Vector3d::UnitY(), 0.5};
    EXPECT_THROW(DisplacementFields(plate, oblique, {6, Vector3d(1, 1, 0).normalized()}), InvalidInput);
    EXPECT_EQ(DisplacementFields(plate, {}, {6, Vector3d(0, 1, 0)}).frame().letter[0], 'y');
}

}  // namespace
}  // namespace strake
