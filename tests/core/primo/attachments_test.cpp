#include "core/primo/attachments.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/mesh/topology.hpp"
#include "shells.hpp"

using namespace strake;

namespace {

/// A wing-like slab, a pod whose top sticks in its lower side, and a drop that hangs under the pod.
struct Bodies {
    TriMesh mesh;
    std::vector<int> slab, pod, drop;
    Bodies() {
        const TriMesh wing = box_surface({1, 4, 0.12}, 8);
        slab = add(wing, {0, 0, 0});
        pod = add(ellipsoid({0.5, 0.16, 0.16}, 2), {0.4, 2.6, -0.1});
        drop = add(ellipsoid({0.2, 0.08, 0.08}, 1), {0.4, 2.6, -0.3});
    }
    std::vector<int> add(const TriMesh& one, const Eigen::RowVector3d& at) {
        const int v = mesh.num_vertices(), t = mesh.num_triangles();
        mesh.vertices.conservativeResize(v + one.num_vertices(), 3);
        mesh.triangles.conservativeResize(t + one.num_triangles(), 3);
        mesh.vertices.bottomRows(one.num_vertices()) = one.vertices.rowwise() + at;
        mesh.triangles.bottomRows(one.num_triangles()) = one.triangles.array() + v;
        std::vector<int> all(one.num_triangles());
        for (int i = 0; i < one.num_triangles(); ++i) all[i] = t + i;
        return all;
    }
    std::vector<AttachedPart> parts(AttachHow how) const {
        return {{"drop", drop, pod, AttachHow::rigid}, {"pod", pod, slab, how}};  // hosts need not stand first
    }
};

/// A bent, twisted and slightly stretched body.
Points bent(const Points& rest, double size) {
    Points v = rest;
    for (int k = 0; k < v.rows(); ++k) {
        const double y = rest(k, 1), angle = size * y;
        const double x = rest(k, 0) - 0.3, z = rest(k, 2);
        v.row(k) << 0.3 + std::cos(angle) * x + std::sin(angle) * z, y * (1 + 0.1 * size * y),
            -std::sin(angle) * x + std::cos(angle) * z + 0.5 * size * y * y;
    }
    return v;
}

Points as_points(const Eigen::VectorXd& x) { return Points::Map(x.data(), x.size() / 3, 3); }
Eigen::VectorXd flat(const Points& p) { return Eigen::VectorXd::Map(p.data(), p.size()); }

int pairs_between(const TriMesh& mesh, const std::vector<int>& part) {
    int count = 0;
    for (const auto& [s, t] : intersections(mesh).apart) {
        const auto is_in = [&](int i) { return std::find(part.begin(), part.end(), i) != part.end(); };
        count += is_in(s) != is_in(t);
    }
    return count;
}

}  // namespace

TEST(Attachments, RigidMotionsOfTheHostAreFollowedExactlyHoweverLarge) {
    const Bodies b;
    for (const AttachHow how : {AttachHow::rigid, AttachHow::follow}) {
        const Attachments attached(b.mesh, b.parts(how));
        const Eigen::Matrix3d R = Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
        const Points moved = (b.mesh.vertices * R.transpose()).rowwise() + Eigen::RowVector3d(3, 1, -2);
        Points placed = moved;
        for (const auto* part : {&b.pod, &b.drop})
            for (const int t : *part)
                for (int k = 0; k < 3; ++k) placed.row(b.mesh.triangles(t, k)).setConstant(7);
        attached.place(placed);
        EXPECT_LT((placed - moved).cwiseAbs().maxCoeff(), 1e-13);
    }
}

TEST(Attachments, AtRestNothingMovesByABit) {
    const Bodies b;
    const Attachments attached(b.mesh, b.parts(AttachHow::follow));
    Points v = b.mesh.vertices;
    attached.place(v);
    EXPECT_EQ(v, b.mesh.vertices);
}

TEST(Attachments, ARigidPartKeepsItsShapeAndStaysIntersected) {
    const Bodies b;
    for (const AttachHow how : {AttachHow::rigid, AttachHow::follow}) {
        const Attachments attached(b.mesh, b.parts(how));
        Points v = bent(b.mesh.vertices, 0.15);
        attached.place(v);
        double stretched = 0;
        for (const int t : b.pod)
            for (int k = 0; k < 3; ++k) {
                const int p = b.mesh.triangles(t, k), q = b.mesh.triangles(t, (k + 1) % 3);
                const double before = (b.mesh.vertices.row(p) - b.mesh.vertices.row(q)).norm();
                stretched = std::max(stretched, std::abs((v.row(p) - v.row(q)).norm() / before - 1));
            }
        if (how == AttachHow::rigid)
            EXPECT_LT(stretched, 1e-12);
        else
            EXPECT_GT(stretched, 1e-3);
        EXPECT_GT(pairs_between(b.mesh, b.drop), 10);
        EXPECT_GT(pairs_between(with_vertices(b.mesh, v), b.drop), 10);
        EXPECT_GT(pairs_between(b.mesh, b.pod), 20);
        EXPECT_GT(pairs_between(with_vertices(b.mesh, v), b.pod), 20);
    }
}

TEST(Attachments, FollowingVerticesGoWithTheSkinThatTheyLieOn) {
    const Bodies b;
    const Attachments attached(b.mesh, b.parts(AttachHow::follow));
    Points v = bent(b.mesh.vertices, 0.1);
    const Points wanted = v;
    attached.place(v);
    const double moved = (wanted - b.mesh.vertices).rowwise().norm().maxCoeff();
    double off = 0;
    for (const int t : b.pod)
        for (int k = 0; k < 3; ++k) {
            const int p = b.mesh.triangles(t, k);
            if (std::abs(b.mesh.vertices(p, 2)) < 0.03) off = std::max(off, (v.row(p) - wanted.row(p)).norm());
        }
    EXPECT_LT(off, 0.02 * moved);
}

TEST(Attachments, PullBackIsTheGradientAndTheTransposeOfTheRates) {
    const Bodies b;
    const Eigen::Index size = b.mesh.vertices.size();
    for (const AttachHow how : {AttachHow::rigid, AttachHow::follow}) {
        const Attachments attached(b.mesh, b.parts(how));
        const Points weights = as_points(random_vector(size, 3));
        const auto J = [&](const Eigen::VectorXd& x) {
            Points v = as_points(x);
            attached.place(v);
            return weights.cwiseProduct(v).sum() + 0.5 * v.squaredNorm();
        };
        Points at = bent(b.mesh.vertices, 0.2);
        attached.place(at);
        Points g = weights + at;
        attached.pull_back(at, g);
        for (const int t : b.pod) EXPECT_EQ(g.row(b.mesh.triangles(t, 0)).norm(), 0);
        const Eigen::VectorXd x = flat(at), slope = flat(g);
        // Smooth, so that the change of the rotation shows; towards the slope, so that the control can fail.
        Points smooth = bent(b.mesh.vertices, 0.7) - b.mesh.vertices;
        const Eigen::VectorXd p = 0.3 * flat(smooth) + 0.05 * slope / slope.norm();
        EXPECT_NEAR(taylor_order(J, x, slope, p), 2, 0.1);
        EXPECT_NEAR(taylor_order(J, x, 1.2 * slope, p), 1, 0.1);  // the check can fail
        Points dv = as_points(random_vector(size, 9)), other = as_points(random_vector(size, 11));
        Points forward = dv, backward = other;
        attached.place_rates(at, forward);
        attached.pull_back(at, backward);
        EXPECT_NEAR(other.cwiseProduct(forward).sum(), backward.cwiseProduct(dv).sum(),
                    1e-11 * other.norm() * dv.norm());
    }
}

TEST(Attachments, TheShellsAdjointGoesThroughThem) {
    const Bodies b;
    for (const AttachHow how : {AttachHow::rigid, AttachHow::follow}) {
        ShellOptions options = uniform(b.mesh, 0.15);
        pin_where(b.mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.y() < 0.3; });
        options.attached = std::make_shared<const Attachments>(b.mesh, b.parts(how));
        PrimoShell shell(b.mesh, options);  // nothing holds the pod or the drop
        const auto on_tip = [](const Eigen::Vector3d& c) { return c.y() > 3; };
        const Loads loads = scaled_to(shell, b.mesh, traction_where(b.mesh, {0.2, 0.1, 1}, on_tip), 0.08);
        const auto shape = [&](const Eigen::VectorXd& force) {
            EXPECT_EQ(shell.solve({as_points(force), {}}).status, SolveStatus::converged);
            return shell.vertices();
        };
        // Of the pod and the drop alone: all of the gradient goes through where they are attached.
        const auto weigh = [&](const Points& v) { return v.bottomRows(v.rows() - b.mesh.triangles(b.pod[0], 0)); };
        const auto J = [&](const Eigen::VectorXd& force) { return 0.5 * weigh(shape(force)).squaredNorm(); };
        const Eigen::VectorXd x = flat(loads.force);
        Points dJ_dv = shape(x);
        dJ_dv.topRows(b.mesh.triangles(b.pod[0], 0)).setZero();
        const Eigen::VectorXd g = flat(shell.adjoint({dJ_dv})[0].force);
        EXPECT_NEAR(taylor_order(J, x, g, 0.5 * x, 1e-1), 2, 0.1);
        EXPECT_NEAR(taylor_order(J, x, 1.5 * g, 0.5 * x, 1e-1), 1, 0.15);
        shape(x);
        const Points dv = shell.response({loads.force})[0];
        EXPECT_NEAR(dJ_dv.cwiseProduct(dv).sum(), g.dot(x), 1e-8 * std::abs(g.dot(x)));
        // The rotation that is told of the part is that of its triangles.
        const Poses poses = shell.poses();
        const TriMesh now = with_vertices(b.mesh, shell.vertices());
        const int t = b.drop[5];
        const Eigen::Vector3d n = area_vector(b.mesh, t).normalized(), turned = area_vector(now, t).normalized();
        EXPECT_NEAR((poses.rotation[t] * n - turned).norm(), 0, 1e-12);
        shell.set_poses(poses);
        EXPECT_LT((shell.vertices() - now.vertices).norm(), 1e-12);
    }
}

TEST(Attachments, HalfABodyMovesAsTheWholeOne) {
    // A slab along y with a pod that the plane y = 0 cuts: the half of each, and both with their images.
    const auto cut = [](TriMesh mesh) {
        std::vector<int> keep;
        for (int t = 0; t < mesh.num_triangles(); ++t)
            if (Eigen::Vector3d(mesh.vertices(mesh.triangles.row(t), 1)).maxCoeff() > 0) keep.push_back(t);
        mesh.triangles = Triangles(mesh.triangles(keep, Eigen::all));
        return mesh;
    };
    const auto image = [](TriMesh mesh) {
        mesh.vertices.col(1) *= -1;
        mesh.triangles.col(0).swap(mesh.triangles.col(1));
        return mesh;
    };
    const TriMesh slab = cut(refined(box_surface({1, 2, 0.2}, 8))), pod = cut(box_surface({0.4, 0.3, 0.4}, 4));
    Bodies half, whole;
    half.mesh = TriMesh();
    half.slab = half.add(slab, {-0.5, 0, 0});
    half.pod = half.add(pod, {-0.2, 0, -0.3});
    whole = half;
    for (const int t : whole.add(image(slab), {-0.5, 0, 0})) whole.slab.push_back(t);
    for (const int t : whole.add(image(pod), {-0.2, 0, -0.3})) whole.pod.push_back(t);
    for (const AttachHow how : {AttachHow::rigid, AttachHow::follow}) {
        const Attachments all(whole.mesh, {{"pod", whole.pod, whole.slab, how}});
        const Attachments some(half.mesh, {{"pod", half.pod, half.slab, how}},
                               SymmetryPlane{Eigen::Vector3d::UnitY(), 0});
        Points v = whole.mesh.vertices;
        for (int k = 0; k < v.rows(); ++k) {
            const double x = v(k, 0), y = v(k, 1), z = v(k, 2);
            v.row(k) << x + 0.2 * z + 0.05 * y * y, y * (1 + 0.05 * x), z + 0.1 * y * y - 0.3 * x + 0.2 * x * x;
        }
        Points w = v.topRows(half.mesh.num_vertices());
        all.place(v);
        some.place(w);
        for (const int t : half.pod)
            for (int k = 0; k < 3; ++k) {
                const int p = half.mesh.triangles(t, k);
                // The whole's halves share no vertices, so that turns at the plane are those of one side.
                EXPECT_LT((v.row(p) - w.row(p)).norm(), how == AttachHow::rigid ? 1e-12 : 5e-4);
                if (half.mesh.vertices(p, 1) == 0) {
                    EXPECT_EQ(w(p, 1), 0);
                }
            }
    }
}

TEST(Attachments, WhatCannotBeAttachedIsSaid) {
    const Bodies b;
    const auto refusal = [&](const std::vector<AttachedPart>& parts) -> std::string {
        try {
            const Attachments attached(b.mesh, parts);
        } catch (const InvalidInput& e) {
            return e.what();
        }
        return "";
    };
    EXPECT_EQ(refusal({{"pod", b.pod, b.slab, {}}}), "");
    EXPECT_NE(refusal({{"pod", b.pod, b.pod, {}}}).find("attached to itself"), std::string::npos);
    EXPECT_NE(refusal({{"pod", b.pod, {}, {}}}).find("its host has no triangles"), std::string::npos);
    EXPECT_NE(refusal({{"pod", {99999}, b.slab, {}}}).find("99999"), std::string::npos);
    EXPECT_NE(refusal({{"pod", b.pod, b.drop, {}}, {"drop", b.drop, b.pod, {}}}).find("'pod' -> 'drop' -> 'pod'"),
              std::string::npos);
    EXPECT_NE(refusal({{"pod", b.pod, b.slab, {}}, {"again", b.pod, b.slab, {}}}).find("'pod' and 'again'"),
              std::string::npos);
    const std::vector<int> some(b.pod.begin(), b.pod.begin() + 20);
    EXPECT_NE(refusal({{"nose", some, b.slab, {}}}).find("shares vertex"), std::string::npos);
}
