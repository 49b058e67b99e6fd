#include "objectives/geometry/mass_properties.hpp"

#include "ask.hpp"
#include "core/mesh/geometry.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

using namespace strake;

namespace {

TriMesh turned_box() {
    TriMesh box = moved(box_surface({2, 3, 5}, 2), 1, {1, -2, 0.5});
    const Eigen::Matrix3d R = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    box.vertices = (box.vertices * R.transpose()).eval();
    return box;
}

}  // namespace

TEST(MassProperties, OfABox) {
    const TriMesh box = moved(box_surface({2, 3, 5}, 2), 1, {1, -2, 0.5});
    const std::vector<double> v = ask(mass_properties("m", box), box).values;
    const double V = 30, wanted[] = {2, -0.5, 3, V * 34 / 12, V * 29 / 12, V * 13 / 12,
                                     0, 0,    0, V * 13 / 12, V * 29 / 12, V * 34 / 12};
    for (int i = 0; i < 12; ++i) EXPECT_NEAR(v[i], wanted[i], 1e-11) << mass_property_values()[i];
    EXPECT_NEAR(v[12 + 2], 1, 1e-12);  // the axis of least inertia is the long one
    EXPECT_NEAR(v[18 + 0], 1, 1e-12);
}

TEST(MassProperties, TurnWithTheBody) {
    const TriMesh box = turned_box();
    const std::vector<double> v = ask(mass_properties("m", box), box).values;
    EXPECT_NEAR(v[9], 30 * 13.0 / 12, 1e-10);
    const Eigen::Vector3d axis =
        Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()) * Eigen::Vector3d::UnitZ();
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(v[12 + c], axis[c], 1e-10);
}

TEST(MassProperties, DerivativesAreExact) {
    const TriMesh box = turned_box();
    const Quantity m = mass_properties("m", box);
    for (std::size_t i = 0; i < m.names.size(); ++i) {
        EXPECT_NEAR(order(m, box, 1, i, 1e-3), 2, 0.1) << m.names[i];
        EXPECT_NEAR(order(m, box, 1.2, i, 1e-3), 1, 0.1) << m.names[i];
    }
}

TEST(MassProperties, AHalfModelStandsForTheWhole) {
    const TriMesh box = box_surface({2, 2, 4}, 2), half = half_above(box, 1);
    const SymmetryPlane plane{Eigen::Vector3d::UnitY(), 1};
    const std::vector<double> a = ask(mass_properties("m", half, plane), half).values,
                              b = ask(mass_properties("m", box), box).values;
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(a[i], b[i], 1e-11) << i;
    EXPECT_TRUE(has(refusal([&] { mass_properties("m", half); }), "m: the surface is open"));
}

TEST(MassProperties, AxesOfASphereAreNotDefined) {
    const TriMesh ball = box_surface({1, 1, 1}, 2);
    const Quantity m = mass_properties("m", ball);
    QuantityRequest request{ball, true, 1, 0, {}};
    request.wanted.assign(m.names.size(), 0);
    request.wanted[0] = 1;
    EXPECT_FALSE(m.evaluate(request).failure);
    request.wanted[12] = 1;
    ASSERT_TRUE(m.evaluate(request).failure);
    EXPECT_TRUE(has(m.evaluate(request).failure->message, "are equal, their axes are not defined"));
}
