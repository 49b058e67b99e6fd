#include "bench/coarse_to_fine/solve.hpp"

#include "core/mesh/adjacency.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/topology.hpp"
#include "derivatives.hpp"

#include <gtest/gtest.h>

namespace strake::evidence {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int tiny = 800;

Points points_of(const VectorXd& x) { return Eigen::Map<const Points>(x.data(), x.size() / 3, 3); }
VectorXd flat(const Points& p) { return Eigen::Map<const VectorXd>(p.data(), p.size()); }

/// Order of the Taylor remainder of value `i` of `quantity` a little off the start.
double order_of(const Quantity& quantity, std::size_t i, const TriMesh& mesh) {
    const auto J = [&](const VectorXd& x) {
        return quantity.evaluate({with_vertices(mesh, points_of(x)), false, 0, 0, {}}).values.at(i);
    };
    const double size = 0.01 * box_diagonal(mesh);
    const VectorXd x = flat(mesh.vertices) + 0.3 * size * random_vector(mesh.vertices.size(), 3);
    const QuantityResult at = quantity.evaluate({with_vertices(mesh, points_of(x)), true, 0, 0, {}});
    return taylor_order(J, x, flat(at.dJ_dv.at(i)), size * random_vector(x.size(), 4), 1e-2);
}

bool is_closed(const TriMesh& mesh) {
    const Adjacency adjacent = adjacency(mesh);
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (!adjacent.is_regular(e)) return false;
    return true;
}

TEST(Evidence, ProblemsAreSoundAndMadeBySeed) {
    ASSERT_EQ(problem_names().size(), 12u);
    int outside = 0;
    ASSERT_EQ(physical_names().size(), 6u);
    std::vector<std::string> names = problem_names();
    names.insert(names.end(), physical_names().begin(), physical_names().end());
    for (const std::string& name : names) {
        SCOPED_TRACE(name);
        const EvidenceProblem p = make_problem(name, tiny, 1);
        const TriMesh& mesh = p.problem.surface;
        outside += p.outside;
        EXPECT_NEAR(mesh.num_triangles(), tiny, 900);
        EXPECT_FALSE(p.problem.fixed.empty());
        EXPECT_LT(p.problem.fixed.size(), 0.4 * mesh.num_triangles());
        EXPECT_EQ(p.problem.tree.levels.size(), 4u);
        EXPECT_TRUE(intersections(mesh).apart.empty());
        const bool is_wing =
            name == "wing" || name == "volume_under_limits" || name == "many_minima" || name == "wing_volume";
        EXPECT_EQ(is_closed(mesh), !is_wing);
        EXPECT_GT(enclosed_volume(mesh), 0);
        const EvidenceProblem again = make_problem(name, tiny, 1), other = make_problem(name, tiny, 2);
        const auto value = [](const EvidenceProblem& q) {
            return q.problem.quantities[0].evaluate({q.problem.surface, false, 0, 0, {}}).values.at(0);
        };
        EXPECT_EQ(value(p), value(again));
        EXPECT_NE(value(p), value(other));
    }
    EXPECT_GE(outside, 6);
}

TEST(Evidence, SensitivitiesOfItsOwnQuantitiesAreExact) {
    const EvidenceProblem limits = make_problem("volume_under_limits", tiny, 1);
    const Quantity &thickness = limits.problem.quantities.at(2), &curvature = limits.problem.quantities.at(3);
    EXPECT_NEAR(order_of(thickness, 0, limits.problem.surface), 2, 0.2);
    EXPECT_NEAR(order_of(thickness, 1, limits.problem.surface), 2, 0.2);
    EXPECT_NEAR(order_of(curvature, 0, limits.problem.surface), 2, 0.1);
    const EvidenceProblem minima = make_problem("many_minima", tiny, 1);
    EXPECT_NEAR(order_of(minima.problem.quantities.at(0), 0, minima.problem.surface), 2, 0.1);
}

TEST(Evidence, SensitivitiesBesideAGivenBodyAreExact) {
    const EvidenceProblem drag = make_problem("wave_drag", tiny, 1), areas = make_problem("section_areas", tiny, 1);
    EXPECT_NEAR(order_of(drag.problem.quantities.at(0), 0, drag.problem.surface), 2, 0.2);
    EXPECT_NEAR(order_of(areas.problem.quantities.at(0), 0, areas.problem.surface), 2, 0.2);
}

TEST(Evidence, NoiseIsSmallDeterministicAndThere) {
    const EvidenceProblem p = make_problem("noisy", tiny, 1);
    const auto value = [&](double shift) {
        TriMesh mesh = p.problem.surface;
        mesh.vertices(0, 0) += shift;
        return p.problem.quantities[0].evaluate({mesh, false, 0, 0, {}}).values.at(0);
    };
    EXPECT_EQ(value(0), value(0));
    EXPECT_NEAR(value(0), 2, 2.1e-4);
    EXPECT_GT(std::abs(value(1e-12) - value(0)), 1e-9);
}

class LinearMotions : public testing::TestWithParam<Solver> {};

TEST_P(LinearMotions, KeepWhatIsHeldAndHaveExactGradients) {
    for (const char* name : {"blob", "fuselage_nacelle", "volume_under_area"}) {
        SCOPED_TRACE(name);
        const EvidenceProblem p = make_problem(name, tiny, 1);
        const TriMesh& mesh = p.problem.surface;
        const ComparedMotion motion = GetParam() == Solver::ffd ? bezier_box(p, variables_of_last_level(p.problem))
                                      : GetParam() == Solver::filtered      ? filtered_vertices(p)
                                      : GetParam() == Solver::lattice_4x4x4 ? spline_lattice(p, {4, 4, 4})
                                                                            : spline_lattice(p, {8, 4, 2});
        const VectorXd x = 0.3 * random_vector(motion.size(), 5), d = random_vector(motion.size(), 6);
        const Points moved = motion.vertices(x) - mesh.vertices;
        const std::vector<char> held = held_vertices(p.problem);
        for (int v = 0; v < mesh.num_vertices(); ++v) EXPECT_EQ(held[v] ? moved.row(v).norm() : 0, 0) << "vertex " << v;
        EXPECT_GT(moved.norm(), 0);
        // The motion is linear, so its adjoint can be tested by one inner product.
        const Points w = points_of(random_vector(mesh.vertices.size(), 7));
        const double forward = (motion.vertices(d) - mesh.vertices).cwiseProduct(w).sum();
        EXPECT_NEAR(motion.gradient(d, w).dot(d), forward, 1e-10 * motion.gradient(d, w).norm() * d.norm());
        // Units: no single Bezier variable moves the surface by more than max_displacement, and the bounds let it.
        if (GetParam() == Solver::ffd) {
            EXPECT_NEAR(motion.size(), variables_of_last_level(p.problem), 0.1 * motion.size());
            const Points one = motion.vertices(VectorXd::Unit(motion.size(), 1)) - mesh.vertices;
            EXPECT_NEAR(one.rowwise().norm().maxCoeff(), p.problem.parameters.max_displacement * box_diagonal(mesh),
                        1e-12);
        }
    }
}
INSTANTIATE_TEST_SUITE_P(All, LinearMotions,
                         testing::Values(Solver::ffd, Solver::filtered, Solver::lattice_4x4x4, Solver::lattice_8x4x2));

/// Where no end is held the control points together move every vertex alike: the weights are a partition of one.
TEST(Evidence, SplineLatticeReproducesTranslations) {
    EvidenceProblem p = make_problem("blob", tiny, 1);
    p.problem.fixed.clear();
    p.ends = {0, {}, {}};
    for (const std::array<int, 3> points : {std::array{4, 4, 4}, std::array{8, 4, 2}}) {
        const ComparedMotion motion = spline_lattice(p, points);
        const int n = motion.size() / 3;
        ASSERT_EQ(n, 64);
        // A variable's largest weight is scaled to the same step: weights are what the columns are over their largest.
        MatrixXd columns(p.problem.surface.num_vertices(), n);
        for (int j = 0; j < n; ++j)
            columns.col(j) = (motion.vertices(VectorXd::Unit(motion.size(), j)) - p.problem.surface.vertices).col(0);
        const VectorXd share = columns.colPivHouseholderQr().solve(VectorXd::Ones(columns.rows()));
        EXPECT_LT((columns * share - VectorXd::Ones(columns.rows())).lpNorm<Eigen::Infinity>(), 1e-9);
    }
}
TEST(Evidence, EverySolverLowersTheObjectiveAndTracesIt) {
    const EvidenceProblem bump = make_problem("local_bump", tiny, 1);
    const EvidenceProblem bend = without_gradients(make_problem("bent_tube", tiny, 1));
    for (const Solver solver : all_solvers()) {
        SCOPED_TRACE(to_string(solver));
        const bool is_by_values = solver == Solver::as_it_comes || solver == Solver::cma_es_12;
        const Method method = is_by_values ? Method::model : solver == Solver::filtered ? Method::lbfgs : Method::sqp;
        const int budget = is_by_values ? 34 : 16;
        const Solve s = solve(is_by_values ? bend : bump, solver, method, budget);
        ASSERT_FALSE(s.trace.empty());
        EXPECT_LE(s.evaluations, budget);
        EXPECT_EQ(s.trace.back().evaluation, s.evaluations);
        EXPECT_LT(s.final, s.start);
        EXPECT_EQ(s.trace.front().best, s.start);
        for (std::size_t i = 1; i < s.trace.size(); ++i) {
            EXPECT_LE(s.trace[i].best, s.trace[i - 1].best);
            EXPECT_GE(s.trace[i].cpu, s.trace[i - 1].cpu);
        }
    }
}

TEST(Evidence, FinestOnlyIsTheLastLevelUnderTheWholeSurface) {
    const EvidenceProblem p = make_problem("blob", tiny, 1);
    const PatchHierarchy tree = finest_only(p.problem.tree);
    ASSERT_EQ(tree.levels.size(), 2u);
    EXPECT_EQ(tree.levels[1].label, p.problem.tree.levels[3].label);
    for (const Patch& patch : tree.levels[1].patches) EXPECT_EQ(patch.parent, 0);
}

}  // namespace
}  // namespace strake::evidence
