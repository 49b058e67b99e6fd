#include "objectives/geometry/section_area.hpp"

#include "ask.hpp"
#include "core/mesh/geometry.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <numbers>

using namespace strake;

namespace {

const Eigen::Vector3d tilted(0.2, 1, 0.3);

}  // namespace

TEST(SectionArea, ClosedForms) {
    const TriMesh box = box_surface({2, 3, 4}, 3), sphere = icosphere(5);
    EXPECT_NEAR(value(section_area("s", box, {{0, 5, 0}, 1.3, {}}), box), 8, 1e-12);
    EXPECT_NEAR(value(section_area("s", box, {{0, 0, -1}, -1.3, {}}), box), 6, 1e-12);
    EXPECT_NEAR(value(section_area("s", box, {{0, 1, 0}, 1, {}}), box), 8, 1e-12);  // through vertices
    EXPECT_NEAR(value(section_area("s", box, {{1, 1, 0}, 2.5 / std::sqrt(2.0), {}}), box), 2 * std::sqrt(2.0) * 4,
                1e-12);
    EXPECT_NEAR(value(section_area("s", sphere, {tilted, 0.6, {}}), sphere), 0.64 * std::numbers::pi, 5e-3);
}

TEST(SectionArea, DerivativesAreExact) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 3);
    const Quantity area = section_area("s", mesh, {tilted, 0.11, 0.9});
    EXPECT_NEAR(order(area, mesh), 2, 0.1);
    EXPECT_NEAR(order(area, mesh, 2), 1, 0.1);
    EXPECT_NEAR(residual_order(area, mesh), 2, 0.1);
    EXPECT_NEAR(residual_order(area, mesh, 2), 1, 0.1);
}

TEST(SectionArea, AHalfModelHasHalfOfIt) {
    const TriMesh box = box_surface({2, 2, 4}, 2), half = half_above(box, 1);
    const SymmetryPlane symmetry{Eigen::Vector3d::UnitY(), 1};
    const Section section{{1, 0.2, 0.3}, 1.1, {}};
    const Quantity whole = section_area("s", box_surface({2, 2, 4}, 2), {{1, 0, 0.3}, 1.1, {}});
    const Quantity part = section_area("s", half, {{1, 0, 0.3}, 1.1, {}}, symmetry);
    EXPECT_NEAR(value(part, half), 0.5 * value(whole, box), 1e-12);
    EXPECT_NEAR(order(part, half), 2, 0.2);
    EXPECT_NEAR(value(section_area("s", half, {{0, 1, 0}, 1.5, {}}, symmetry), half), 8, 1e-12);
    EXPECT_TRUE(has(refusal([&] { section_area("s", half, section); }), "the section is open at the edge from vertex"));
    EXPECT_TRUE(has(refusal([&] {
                        section_area("s", half, section, SymmetryPlane{Eigen::Vector3d::UnitY(), 0.9});
                    }),
                    "open"));
}

TEST(SectionArea, ScalesIgnoresTranslationRefinementAndOrientation) {
    const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 2);
    const double A = value(section_area("s", mesh, {tilted, 0.11, {}}), mesh);
    const TriMesh other = moved(mesh, 100, {5, -3, 1});
    const double shift = tilted.normalized().dot(Eigen::Vector3d(5, -3, 1));
    EXPECT_NEAR(value(section_area("s", other, {tilted, 11 + shift, {}}), other), 1e4 * A, 1e-8 * A * 1e4);
    EXPECT_NEAR(value(section_area("s", refined(mesh), {tilted, 0.11, {}}), refined(mesh)), A, 1e-13);
    EXPECT_NEAR(value(section_area("s", mesh, {-tilted, -0.11, {}}), mesh), A, 1e-13);
    TriMesh turned = mesh;
    turned.triangles.col(0).swap(turned.triangles.col(1));
    EXPECT_NEAR(value(section_area("s", turned, {tilted, 0.11, {}}), turned), A, 1e-13);
}

TEST(SectionArea, ResidualIsTheMeanShiftOfTheOutline) {
    // A unit square that is wanted larger by d on every side: (A - wanted) / perimeter = -d in the limit.
    const TriMesh box = box_surface();
    const double d = 1e-6, wanted = (1 + 2 * d) * (1 + 2 * d);
    const Quantity area = section_area("s", box, {{0, 0, 1}, 0.5, wanted});
    EXPECT_NEAR(area.residuals(box, box).r[0], -d, 1e-11);
    EXPECT_FALSE(section_area("s", box, {{0, 0, 1}, 0.5, {}}).residuals);
}

TEST(SectionArea, WhatIsNotCutOrNotFiniteIsRefused) {
    const TriMesh box = box_surface();
    EXPECT_TRUE(has(refusal([&] { section_area("s", box, {{0, 0, 1}, 1.5, {}}); }), "does not cut the surface"));
    EXPECT_TRUE(has(refusal([&] { section_area("s", box, {{0, 0, 0}, 1.5, {}}); }), "normal"));
    EXPECT_THROW(section_area("s", box, {{0, 0, 1}, NAN, {}}), InvalidInput);
    EXPECT_THROW(section_area("s", box, {{0, 0, 1}, 0.5, -1.0}), InvalidInput);
    const Quantity area = section_area("s", box, {{0, 0, 1}, 0.5, 1.0});
    const TriMesh away = moved(box, 1, {0, 0, 5});
    ASSERT_TRUE(ask(area, away).failure);
    EXPECT_EQ(ask(area, away).failure->kind, "undefined");
    EXPECT_THROW(area.residuals(away, away), InvalidInput);
    TriMesh broken = box;
    broken.vertices(3, 1) = NAN;
    EXPECT_TRUE(ask(area, broken).failure);
}
