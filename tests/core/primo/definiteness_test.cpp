#include "core/primo/definiteness.hpp"

#include <gtest/gtest.h>

#include "cases/geometry/lifting_body.hpp"
#include "cases/geometry/wing.hpp"
#include "core/primo/linear/spd_solver.hpp"
#include "core/primo/linear/vectors.hpp"
#include "shells.hpp"

/// Lanczos' method beside multigrid calls nothing definite that a factorization does not, however near to buckling, and
/// sees what is safely definite as that.
namespace strake {
namespace {

/// A shell at rest under the stress of a load's linear response times any share.
struct Stressed {
    PrimoShell shell;
    PrimoShell::Impl& impl = shell.impl();
    Loads loads;
    std::vector<Eigen::Matrix3d> turn = rotation_differences(impl.poses);
    Eigen::VectorXd response;
    SpdSolver factor;

    Stressed(const TriMesh& mesh, ShellOptions options, const Loads& given)
        : shell(mesh, multigrid(options)), loads(complete(given, mesh.num_vertices())) {
        impl.prepare(loads.spring);
        assemble(0);
        factor.analyze(impl.H);
        EXPECT_TRUE(factor.factorize(impl.H));
        const Wrenches g = energy_gradient(impl.rest, turn, jumps(impl.rest, impl.poses, turn), loads)(
            impl.rest.free_prisms, Eigen::all);
        response = factor.solve(Eigen::VectorXd(-Eigen::Map<const Eigen::VectorXd>(g.data(), g.size())));
    }
    static ShellOptions multigrid(ShellOptions options) {
        options.solver = LinearSolver::multigrid;
        return options;
    }
    void assemble(double share) {
        Loads part = loads;
        part.force *= share;
        Jumps stress = jumps(impl.rest, impl.poses, turn);
        if (share != 0) stress = sum(stress, jump_rates(impl.rest, turn, share * response));
        impl.assemble(turn, stress, part, StressTerm::exact);
    }
    bool is_definite(double share) {
        assemble(share);
        return factor.factorize(impl.H);
    }
    /// The share from which on it buckles, within a hundred thousandth.
    double critical() {
        double below = 0, above = 1e-6;
        while (is_definite(above)) below = above, above *= 4;
        while (above - below > 1e-5 * above) {
            const double middle = (below + above) / 2;
            (is_definite(middle) ? below : above) = middle;
        }
        return below;
    }
};

void expect_as_by_factor(Stressed stressed) {
    const double critical = stressed.critical();
    int seen = 0;
    for (const double built_at : {0.0, 0.9}) {
        stressed.assemble(built_at * critical);
        ASSERT_TRUE(stressed.impl.factorize());
        for (const double share : {0.0, 0.5, 0.9, 0.99, 0.9999}) {
            stressed.assemble(share * critical);
            const Definiteness found = probe_definiteness(stressed.impl, 1e-3);
            EXPECT_NE(found, Definiteness::no) << share << " beside " << built_at;
            EXPECT_TRUE(found == Definiteness::yes || share > 0.9) << share << " beside " << built_at;
        }
        for (const double share : {1.0001, 1.001, 1.01, 1.1, 1.5, 3.0}) {
            ASSERT_FALSE(stressed.is_definite(share * critical));
            const Definiteness found = probe_definiteness(stressed.impl, 1e-3);
            EXPECT_NE(found, Definiteness::yes) << share << " beside " << built_at;
            seen += found == Definiteness::no;
        }
    }
    EXPECT_GT(seen, 6);  // a direction of negative curvature is met, more often than not
}

}  // namespace

TEST(Definiteness, OfAStripPushedFromItsEnd) {
    const TriMesh mesh = strip(1, 0.06, 200, 12);
    ShellOptions options = uniform(mesh, 0.01);
    pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.x() < 0.02; });
    const auto end = [](const Eigen::Vector3d& c) { return c.x() > 0.95; };
    expect_as_by_factor({mesh, options, traction_where(mesh, {-1, 0, 0}, end)});
}

TEST(Definiteness, OfAWingBent) {
    const TriMesh mesh = example::wing(5000);
    ShellOptions options = uniform(mesh, 0.02 * box_diagonal(mesh));
    pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.y() < 0.05; });
    const auto outer = [](const Eigen::Vector3d& c) { return c.y() > 0.4; };
    expect_as_by_factor({mesh, options, traction_where(mesh, {0, 0, 1}, outer)});
}

TEST(Definiteness, OfALiftingBodyPushedFromBehind) {
    const TriMesh mesh = example::lifting_body(12'000);
    ShellOptions options = uniform(mesh, 0.02 * box_diagonal(mesh));
    pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.x() < 0.4; });
    const auto aft = [](const Eigen::Vector3d& c) { return c.x() > 2.4; };
    expect_as_by_factor({mesh, options, traction_where(mesh, {-1, 0, 0}, aft)});
}

// Lanczos' values mean something only beside a map that is linear and symmetric.
TEST(Definiteness, LinearCyclesAreLinearAndSymmetric) {
    const TriMesh mesh = example::wing(20'000);
    ShellOptions options = uniform(mesh, 0.02 * box_diagonal(mesh));
    pin_where(mesh, options, fixed_prism, [](const Eigen::Vector3d& c) { return c.y() < 0.05; });
    Stressed stressed(mesh, options, {});
    ASSERT_TRUE(stressed.impl.factorize());
    std::srand(3);
    const Eigen::VectorXd a = Eigen::VectorXd::Random(6L * stressed.impl.rest.num_free());
    const Eigen::VectorXd b = Eigen::VectorXd::Random(a.size());
    const auto error = [&](Cycle kind) {
        const auto apply = [&](const Eigen::VectorXd& x) {
            return Eigen::VectorXd(stressed.impl.precondition(x, kind));
        };
        const Eigen::VectorXd of_a = apply(a), of_b = apply(b);
        const double size = std::sqrt(dot(a, of_a) * dot(b, of_b));
        return std::max(std::abs(dot(a, of_b) - dot(b, of_a)) / size,
                        (apply(a + b) - of_a - of_b).norm() / (of_a.norm() + of_b.norm()));
    };
    EXPECT_LT(error(Cycle::linear), 1e-3);  // round-off in single precision
    EXPECT_GT(error(Cycle::best), 2e-3);
}

}  // namespace strake
