#include "core/primo/coarse_shell.hpp"

#include <gtest/gtest.h>

#include "cases/geometry/lifting_body.hpp"
#include "cases/geometry/wing.hpp"
#include "core/primo/shell_impl.hpp"
#include "shells.hpp"

/// The coarser shell that goes ahead where the way is long: a shell itself, close to the finer one, and no more than a
/// guide: the end is the same without it.
namespace strake {
namespace {

struct Held {
    TriMesh mesh;
    ShellOptions options;
    Loads unit;  ///< linear response of one diagonal

    explicit Held(TriMesh surface, int axis, int also_pinned = -1) : mesh(std::move(surface)) {
        options = uniform(mesh, 0.03 * box_diagonal(mesh));
        if (also_pinned >= 0) options.pin[also_pinned] = fixed_prism;
        const double low = mesh.vertices.col(axis).minCoeff(), high = mesh.vertices.col(axis).maxCoeff();
        const auto at = [=](const Eigen::Vector3d& c) { return (c[axis] - low) / (high - low); };
        pin_where(mesh, options, fixed_prism, [&](const Eigen::Vector3d& c) { return at(c) < 0.06; });
        unit = traction_where(mesh, {0, 0, 1}, [&](const Eigen::Vector3d& c) { return at(c) > 0.3; });
        PrimoShell shell(mesh, options);
        unit = scaled_to(shell, mesh, unit, 1);
    }
    Loads loads(double share) const {
        Loads result = unit;
        result.force *= share;
        return result;
    }
};

Held held_wing(int triangles) { return Held(example::wing(triangles), 1); }
Held held_body(int triangles) { return Held(example::lifting_body(triangles), 0); }

double apart(const Points& a, const Points& b, const TriMesh& mesh) {
    return (a - b).rowwise().norm().maxCoeff() / box_diagonal(mesh);
}

/// From a pose that is off rest by next to nothing, where no coarser shell is asked.
Equilibrium solve_unguided(PrimoShell& shell, const Loads& loads, const std::vector<RigidMotion>& motions = {}) {
    Poses poses = shell.poses();
    poses.displacement(shell.impl().rest.free_prisms[0], 0) += 1e-12;
    shell.set_poses(poses);
    return shell.solve(loads, motions);
}

/// Both ways end in the same equilibrium, the guided one in fewer steps. @return the steps
std::pair<int, int> expect_same_end(const Held& held, const Loads& loads,
                                    const std::vector<RigidMotion>& motions = {}) {
    PrimoShell guided(held.mesh, held.options), alone(held.mesh, held.options);
    const Equilibrium a = guided.solve(loads, motions), b = solve_unguided(alone, loads, motions);
    EXPECT_EQ(a.status, SolveStatus::converged) << a.reason;
    EXPECT_EQ(b.status, SolveStatus::converged) << b.reason;
    EXPECT_TRUE(a.stable);
    EXPECT_LT(apart(guided.vertices(), alone.vertices(), held.mesh), 1e-9);
    const Points v = guided.vertices();
    for (int k = 0; k < v.rows(); ++k)
        if (guided.fixed_vertices()[k]) {
            EXPECT_EQ(v.row(k), held.mesh.vertices.row(k));
        }
    return {a.iterations, b.iterations};
}

TEST(CoarseShell, MovesRigidlyWithoutEnergy) {
    const TriMesh mesh = example::wing(4000);
    const RestState fine = rest_state(mesh, uniform(mesh, 0.05));
    const CoarseShell coarse = coarsen(fine, 2);
    EXPECT_LT(coarse.rest.num_prisms(), fine.num_prisms() / 6);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
    const auto moved = [&](const RestState& rest) {
        Poses poses{std::vector<Eigen::Quaterniond>(rest.num_prisms(), turn), Points(rest.num_prisms(), 3)};
        for (int i = 0; i < rest.num_prisms(); ++i) {
            const Eigen::Vector3d c = rest.centroid.row(i).transpose();
            poses.displacement.row(i) = (turn * c - c + Eigen::Vector3d(0.3, -0.2, 0.1)).transpose();
        }
        return poses;
    };
    const Poses poses = moved(coarse.rest);
    const Loads none = complete({}, mesh.num_vertices());
    EXPECT_LT(energy(coarse.rest, jumps(coarse.rest, poses, rotation_differences(poses)), none), 1e-24);
    const Poses fine_poses = prolonged(fine, coarse, coarse.rest, poses), wanted = moved(fine);
    EXPECT_LT((fine_poses.displacement - wanted.displacement).cwiseAbs().maxCoeff(), 1e-13);
    for (int i = 0; i < fine.num_prisms(); ++i)
        EXPECT_LT(fine_poses.rotation[i].angularDistance(wanted.rotation[i]),
                  1e-7);  // of which 1e-8 is the arc cosine's
}

TEST(CoarseShell, IsAboutAsStiff) {
    // A control: with the faces as stiff as they were, clusters of ten would be three times too stiff.
    for (const Held& held : {held_wing(6000), held_body(6000)}) {
        const RestState fine = rest_state(held.mesh, held.options);
        PrimoShell shell(held.mesh, held.options);
        const double wanted =
            (shell.linear_response(held.loads(0.01)) - held.mesh.vertices).rowwise().norm().maxCoeff();
        for (const bool is_softened : {true, false}) {
            CoarseShell coarse = coarsen(fine, 2);
            if (!is_softened)
                for (SharedFace& face : coarse.rest.faces)
                    for (const SharedFace& finer : fine.faces)
                        if (finer.vertex == face.vertex) {
                            face.weight = finer.weight;
                            break;
                        }
            PrimoShell::Impl rough(std::move(coarse.rest), LinearSolver::direct, 1);
            const Loads loads = complete(held.loads(0.01), held.mesh.num_vertices());
            rough.prepare(loads.spring);
            const auto turn = rotation_differences(rough.poses);
            const Jumps none = jumps(rough.rest, rough.poses, turn);
            rough.assemble(turn, none, loads, StressTerm::none);
            ASSERT_TRUE(rough.factorize());
            const Eigen::VectorXd twist = rough.precondition(vertex_wrenches(rough.rest, turn, loads.force));
            const double found = vertex_rates(rough.rest, turn, twist).rowwise().norm().maxCoeff();
            if (is_softened)
                EXPECT_NEAR(found, wanted, 0.12 * wanted);
            else
                EXPECT_LT(found, 0.6 * wanted);
        }
    }
}

TEST(CoarseShell, EndIsTheSame) {
    for (const Held& held : {held_wing(8000), held_body(8000)})
        for (const double share : {0.1, 0.5}) {
            const auto [guided, alone] = expect_same_end(held, held.loads(share));
            if (share > 0.3) {
                EXPECT_LT(guided, alone);
            }
        }
}

TEST(CoarseShell, EndIsTheSameWithSprings) {
    const Held held = held_wing(8000);
    Loads loads = held.loads(0.5);
    loads.spring = loads.force.rowwise().norm() / (2 * box_diagonal(held.mesh));
    const auto [guided, alone] = expect_same_end(held, loads);
    EXPECT_LT(guided, alone);
}

TEST(CoarseShell, EndIsTheSameUnderStrains) {
    Held held = held_wing(8000);
    const double tip = held.mesh.vertices.col(1).maxCoeff();
    pin_where(held.mesh, held.options, 1, [&](const Eigen::Vector3d& c) { return c.y() > 0.9 * tip; });
    RigidMotion motion{{0.2, 0.1, 0}, {0, 0, 0.15 * box_diagonal(held.mesh)}, {0, 0.95 * tip, 0}};
    expect_same_end(held, {}, {motion});
}

TEST(CoarseShell, EndIsTheSameBesideASymmetryPlane) {
    Held held = held_wing(8000);
    held.options.symmetry = SymmetryPlane{Eigen::Vector3d::UnitY(), 0};
    expect_same_end(held, held.loads(0.4));
}

TEST(CoarseShell, IsCancelled) {
    const Held held = held_wing(6000);
    PrimoShell shell(held.mesh, held.options);
    int told = 0;
    const Equilibrium end = shell.solve(held.loads(0.5), {}, {}, [&](const SolveRecord& record) {
        EXPECT_EQ(record.iteration, 0);
        return ++told < 2;
    });
    EXPECT_EQ(told, 2);
    EXPECT_EQ(end.status, SolveStatus::cancelled);
    EXPECT_EQ(end.iterations, 0);
    EXPECT_EQ(shell.vertices(), held.mesh.vertices);
}

/// The wing beside a part of its own, of which the first triangle is pinned.
Held wing_beside(const Points& vertices, const Eigen::Matrix<int, Eigen::Dynamic, 3>& triangles) {
    TriMesh both = example::wing(5000);
    const int n = both.num_vertices(), m = both.num_triangles();
    both.vertices.conservativeResize(n + vertices.rows(), 3);
    both.vertices.bottomRows(vertices.rows()) = vertices.rowwise() + Eigen::RowVector3d(0, 0.5, 2);
    both.triangles.conservativeResize(m + triangles.rows(), 3);
    both.triangles.bottomRows(triangles.rows()) = triangles.array() + n;
    return Held(both, 1, m);
}

TEST(CoarseShell, CentresMayCoincide) {
    Points vertices(4, 3);
    vertices << 0, 0, 0, 0.3, 0, 0, 0, 0.3, 0, 0.1, 0.1, 0;
    const Held held = wing_beside(vertices, Eigen::Matrix<int, 4, 3>{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
    const RestState fine = rest_state(held.mesh, held.options);
    double stiffest = 0;
    for (const SharedFace& face : fine.faces) stiffest = std::max(stiffest, face.weight);
    for (const SharedFace& face : coarsen(fine, 2).rest.faces) {
        EXPECT_TRUE(std::isfinite(face.weight));
        EXPECT_LE(face.weight, stiffest);
    }
    expect_same_end(held, held.loads(0.3));
}

TEST(CoarseShell, WhatItCannotDoIsLeftToTheFinerOne) {
    // Folded back onto the pinned triangle: coarser prisms see no way from one to the other.
    Points vertices(5, 3);
    vertices << 0, 0, 0, 0.3, 0, 0, 0, 0.3, 0, 0, 0.3, 0, 0.3, 0.3, 0;
    const Held held = wing_beside(vertices, Eigen::Matrix<int, 3, 3>{{0, 1, 2}, {1, 0, 3}, {1, 3, 4}});
    expect_same_end(held, held.loads(0.3));
}

}  // namespace
}  // namespace strake
