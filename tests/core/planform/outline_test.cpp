#include "core/planform/outline.hpp"

#include "wing_bodies.hpp"

#include <gtest/gtest.h>
#include <numeric>

namespace strake {
namespace {

std::vector<Outline> cut_at(const TriMesh& mesh, double y) {
    std::vector<int> all(static_cast<std::size_t>(mesh.num_triangles()));
    std::iota(all.begin(), all.end(), 0);
    const SectionFrame frame{Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(), y};
    return cut(mesh, all, frame, {false, 0.0});
}

TriMesh without(const TriMesh& mesh, const std::function<bool(const Eigen::Vector3d&)>& is_omitted) {
    TriMesh open = mesh;
    open.triangles.resize(0, 3);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        Eigen::Vector3d middle = Eigen::Vector3d::Zero();
        for (const int v : mesh.triangles.row(t)) middle += mesh.vertices.row(v).transpose() / 3;
        if (is_omitted(middle)) continue;
        open.triangles.conservativeResize(open.triangles.rows() + 1, 3);
        open.triangles.bottomRows(1) = mesh.triangles.row(t);
    }
    return open;
}

/// A raw model whose wing has a hole where the flap was cut out, beside a slat that is closed.
TEST(Outline, AnOpenAirfoilBesideAClosedOneStays) {
    Loft slat;
    slat.chord = [](double s) { return 0.15 * (1 - 0.5 * s); };
    slat.quarter = [](double s) { return -0.16 + 1.3 * s; };
    slat.height = [](double s) { return 0.3 * s - 0.02; };
    const TriMesh main = lofted(Loft{});
    const TriMesh open = without(main, [](const Eigen::Vector3d& p) {
        return p[1] > 1 && p[1] < 2 && p[0] - 0.4 * p[1] > 0.5 && p[2] < 0.1 * p[1];
    });
    ASSERT_LT(open.num_triangles(), main.num_triangles() - 10);
    const auto outlines = cut_at(both(open, lofted(slat)), 1.501);
    ASSERT_EQ(outlines.size(), 2U) << "the wing itself is there";
    double longest = 0;
    for (const Outline& outline : outlines) {
        double low = 1e9, high = -1e9;
        for (const PlanePoint& p : outline.points) low = std::min(low, p.x.value), high = std::max(high, p.x.value);
        longest = std::max(longest, high - low);
    }
    EXPECT_NEAR(longest, 0.75, 0.05) << "to where the hole begins";
}

TEST(Outline, ASheetBesideAClosedOneIsNoPart) {
    TriMesh wake;  // a strip behind the wing, with a bend
    wake.vertices.resize(6, 3);
    wake.vertices << 3, 0, 0, 3, 3, 0.3, 5, 0, 0.4, 5, 3, 0.7, 8, 0, 0.3, 8, 3, 0.6;
    wake.triangles.resize(4, 3);
    wake.triangles << 0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5;
    EXPECT_EQ(cut_at(wake, 1.501).size(), 1U);
    EXPECT_EQ(cut_at(both(lofted(Loft{}), wake), 1.501).size(), 1U);
}

}  // namespace
}  // namespace strake
