#include "report/patch_shares.hpp"

#include "surfaces.hpp"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

namespace strake {
namespace {

/// Two patches: below and above the plane z = 0.
PatchLevel halves(const TriMesh& mesh) {
    PatchLevel level;
    level.patches.resize(2);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        double z = 0;
        for (int k = 0; k < 3; ++k) z += mesh.vertices(mesh.triangles(t, k), 2);
        level.label.push_back(z > 0 ? 1 : 0);
    }
    for (int p = 0; p < 2; ++p) level.patches[static_cast<std::size_t>(p)].id = p;
    return level;
}

/// Volume and its sensitivities: cubic along a path, so that the rule is exact to third order.
std::pair<double, Points> volume_of(const TriMesh& mesh) {
    double value = 0;
    Points gradient = Points::Zero(mesh.num_vertices(), 3);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Eigen::Vector3d a = mesh.vertices.row(mesh.triangles(t, 0)), b = mesh.vertices.row(mesh.triangles(t, 1)),
                              c = mesh.vertices.row(mesh.triangles(t, 2));
        value += a.dot(b.cross(c)) / 6;
        gradient.row(mesh.triangles(t, 0)) += b.cross(c).transpose() / 6;
        gradient.row(mesh.triangles(t, 1)) += c.cross(a).transpose() / 6;
        gradient.row(mesh.triangles(t, 2)) += a.cross(b).transpose() / 6;
    }
    return {value, gradient};
}

class Shares : public testing::Test {
protected:
    const TriMesh mesh = ellipsoid({1, 0.7, 0.5}, 2);
    const PatchLevel level = halves(mesh);
    /// The upper half lifted by so much of its height.
    Points lifted(double share) const {
        Points d = Points::Zero(mesh.num_vertices(), 3);
        for (int v = 0; v < mesh.num_vertices(); ++v) d(v, 2) = share * std::max(0.0, mesh.vertices(v, 2));
        return d;
    }
    void add(PatchShares& shares, double share, bool with_sensitivities = true) const {
        const auto [value, gradient] = volume_of(with_vertices(mesh, mesh.vertices + lifted(share)));
        shares.add(lifted(share), with_sensitivities ? gradient : Points(), value);
    }
};

TEST_F(Shares, AddUpToTheChangeAndGoToWhatMoved) {
    PatchShares shares(mesh);
    for (const double share : {0.0, 0.1, 0.15, 0.3}) add(shares, share);
    const std::vector<PatchShare> of = shares.of(level);
    EXPECT_GT(shares.change(), 0.1);
    EXPECT_NEAR(shares.explained(), shares.change(), 1e-12);  // the volume is linear in this motion
    EXPECT_NEAR(of[0].contribution + of[1].contribution, shares.explained(), 1e-12);
    EXPECT_GT(of[1].contribution, 0.95 * shares.change());
    EXPECT_NEAR(of[1].max_displacement, 0.3 * 0.5, 1e-12);
    EXPECT_GT(of[1].mean_outward, 0.02);
    EXPECT_NEAR(of[0].area, of[1].area, 0.15 * of[0].area);
}

TEST_F(Shares, AreNotKnownWithoutSensitivities) {
    PatchShares shares(mesh);
    add(shares, 0, false);
    add(shares, 0.2, false);
    EXPECT_TRUE(std::isnan(shares.explained()));
    EXPECT_TRUE(std::isnan(shares.of(level)[1].contribution));
    EXPECT_GT(shares.of(level)[1].max_displacement, 0.09);
}

TEST_F(Shares, OneEndStandsForBoth) {
    PatchShares shares(mesh);
    add(shares, 0, true);
    add(shares, 0.2, false);
    EXPECT_NEAR(shares.explained(), shares.change(), 1e-12);
}

TEST_F(Shares, WithoutADesignNothingHasMoved) {
    const PatchShares shares(mesh);
    EXPECT_TRUE(std::isnan(shares.of(level)[0].contribution));
    EXPECT_EQ(shares.of(level)[0].max_displacement, 0);
    EXPECT_GT(shares.of(level)[0].area, 1);
}

}  // namespace
}  // namespace strake
