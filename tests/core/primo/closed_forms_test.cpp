#include <gtest/gtest.h>

#include <cmath>

#include "shells.hpp"

using namespace strake;

// Two triangles and a dead force: the fibres give w h^2/6 theta^2-like bending, exact in closed form.
TEST(Hinge, MatchesTheClosedForm) {
    const double L = 1.3, d = 0.9, h = 0.07, area = L * d / 2, w = L * L / (2 * area);
    const TriMesh mesh = hinge(L, d);
    ShellOptions options = uniform(mesh, h);
    options.pin[0] = fixed_prism;
    PrimoShell shell(mesh, options);
    for (const double tangent : {0.01, 0.3, 2.0}) {
        const double P = tangent * w * h * h / (6 * d), theta = std::atan(tangent);
        Loads loads{Points::Zero(4, 3), {}};
        loads.force(3, 2) = P;
        const Equilibrium end = shell.solve(loads);
        ASSERT_EQ(end.status, SolveStatus::converged) << end.reason;
        EXPECT_TRUE(end.stable);
        const Points v = shell.vertices();
        EXPECT_NEAR(v(3, 0), d * std::cos(theta), 1e-12);
        EXPECT_NEAR(v(3, 1), 0, 1e-12);
        EXPECT_NEAR(v(3, 2), P / (2 * w) + d * std::sin(theta), 1e-12);
        for (int k = 0; k < 3; ++k) EXPECT_TRUE((v.row(k).array() == mesh.vertices.row(k).array()).all());
    }
}

namespace {

/// Tip of a clamped elastica of unit length under a dead transverse end load: theta'' = -p cos theta, theta(0) = 0,
/// theta'(1) = 0, by shooting and Runge-Kutta.
Eigen::Vector2d elastica_tip(double p) {
    Eigen::Vector2d tip;
    const auto shoot = [&](double curvature) {
        const int steps = 2000;
        const double s = 1.0 / steps;
        Eigen::Vector4d y(0, curvature, 0, 0);
        const auto rate = [&](const Eigen::Vector4d& a) {
            return Eigen::Vector4d(a[1], -p * std::cos(a[0]), std::cos(a[0]), std::sin(a[0]));
        };
        for (int i = 0; i < steps; ++i) {
            const Eigen::Vector4d k1 = rate(y), k2 = rate(y + s / 2 * k1), k3 = rate(y + s / 2 * k2),
                                  k4 = rate(y + s * k3);
            y += s / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
        }
        tip = y.tail<2>();
        return y[1];
    };
    double low = 0, high = p;
    for (int i = 0; i < 80; ++i) (shoot((low + high) / 2) > 0 ? high : low) = (low + high) / 2;
    return tip;
}

struct Strip {
    double length = 1, width = 0.1, height = 0.02;
    int cells_x = 60, cells_y = 6;
    double clamp() const { return length / cells_x; }
    double free_length() const { return length - clamp(); }
    TriMesh mesh() const { return strip(length, width, cells_x, cells_y); }
    ShellOptions options(const TriMesh& m) const {
        ShellOptions o = uniform(m, height);
        pin_where(m, o, fixed_prism, [&](const Eigen::Vector3d& c) { return c.x() < clamp(); });
        return o;
    }
    Loads end_load(const TriMesh& m, double P) const {
        Loads loads{Points::Zero(m.num_vertices(), 3), {}};
        for (int v = 0; v < m.num_vertices(); ++v)
            if (m.vertices(v, 0) == length)
                loads.force(v, 2) = P / cells_y * (m.vertices(v, 1) == 0 || m.vertices(v, 1) == width ? 0.5 : 1);
        return loads;
    }
    Eigen::Vector3d tip(const Points& v, const TriMesh& m) const {
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        int count = 0;
        for (int k = 0; k < m.num_vertices(); ++k)
            if (m.vertices(k, 0) == length) mean += v.row(k), ++count;
        return mean / count;
    }
};

}  // namespace

TEST(ClampedStrip, HasTheStatedBendingStiffnessAndFollowsTheElastica) {
    const Strip strip;
    const TriMesh mesh = strip.mesh();
    PrimoShell shell(mesh, strip.options(mesh));
    const double L = strip.free_length(), stated = 4.0 / 3 * strip.height * strip.height / 12 * strip.width;
    const double small = 1e-3 * stated / (L * L);
    const Points linear = shell.linear_response(strip.end_load(mesh, small));
    const double EI = small * L * L * L / (3 * strip.tip(linear, mesh).z());
    EXPECT_NEAR(EI / stated, 1, 0.12);  // mesh patterns shift it by up to 12 %
    for (const double p : {1.0, 3.0, 8.0}) {
        const Equilibrium end = shell.solve(strip.end_load(mesh, p * EI / (L * L)));
        ASSERT_EQ(end.status, SolveStatus::converged) << end.reason;
        const Eigen::Vector3d tip = strip.tip(shell.vertices(), mesh);
        const Eigen::Vector2d wanted = elastica_tip(p);
        EXPECT_NEAR(tip.z() / L, wanted[1], 0.05 * wanted[1]) << p;
        EXPECT_NEAR((strip.length - tip.x()) / L, 1 - wanted[0], 0.05 * (1 - wanted[0])) << p;
    }
}

TEST(ClampedStrip, WhereThreeTimesAsThickBendsANinth) {
    Strip strip;
    strip.cells_x = 240, strip.cells_y = 24;
    const TriMesh mesh = strip.mesh();
    ShellOptions thin = strip.options(mesh), thick = thin;
    Eigen::VectorXd heights = Eigen::VectorXd::Constant(mesh.num_triangles(), strip.height);
    const Points c = triangle_centroids(mesh);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (c(t, 0) > 1.0 / 3 && c(t, 0) < 2.0 / 3) heights[t] *= 3;
    thick.prism_height = vertex_heights(mesh, heights);
    const Loads loads = strip.end_load(mesh, 1e-7);
    // Turning of the strip between two stations inside of the middle third.
    const auto turning = [&](const ShellOptions& options) {
        PrimoShell shell(mesh, options);
        const Points v = shell.linear_response(loads);
        const auto slope = [&](double x) {
            double sum = 0, count = 0;
            for (int k = 0; k + 1 < mesh.num_vertices(); ++k)
                if (std::abs(mesh.vertices(k, 0) - x) < 1e-9 && mesh.vertices(k + 1, 0) > x)
                    sum += (v(k + 1, 2) - v(k, 2)) / (mesh.vertices(k + 1, 0) - x), ++count;
            return sum / count;
        };
        return slope(0.6) - slope(0.4);
    };
    EXPECT_NEAR(turning(thin) / turning(thick), 9,
                0.27);  // first order in the edge length: 8.31, 8.67, 8.89 at 60, 120, 240 cells
}

TEST(Refinement, SameTractionOnTheSamePatchGivesTheSameShape) {
    const Eigen::Vector3d radii(1, 0.5, 0.3);
    const Points coarse = triangle_centroids(ellipsoid(radii, 2));
    std::vector<double> apex;
    for (int level = 2; level <= 5; ++level) {
        const TriMesh body = ellipsoid(radii, level);
        const int children = 1 << (2 * (level - 2));  // of a coarse triangle, numbered in a row
        ShellOptions options = uniform(body, 0.05);
        Points traction = Points::Zero(body.num_triangles(), 3);
        for (int t = 0; t < body.num_triangles(); ++t) {
            if (coarse(t / children, 0) < -0.7) options.pin[t] = fixed_prism;
            if (coarse(t / children, 0) > 0.5) traction.row(t) = Eigen::RowVector3d(0, 0, 2e-3);
        }
        PrimoShell shell(body, options);
        ASSERT_EQ(shell.solve({traction_forces(body, traction), {}}).status, SolveStatus::converged);
        Eigen::Index k;
        body.vertices.col(0).maxCoeff(&k);
        apex.push_back(shell.vertices()(k, 2) - body.vertices(k, 2));
    }
    EXPECT_GT(apex[3], 0.01);
    // Falls with the mesh size: each refinement moves the answer by less than 0.6 of what the one before did.
    for (int i = 2; i < 4; ++i)
        EXPECT_LT(std::abs(apex[i] - apex[i - 1]), 0.6 * std::abs(apex[i - 1] - apex[i - 2])) << i;
    EXPECT_NEAR(apex[3] / apex[2], 1, 0.03);
}
