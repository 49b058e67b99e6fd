#include "core/mesh/temp_folder.hpp"
#include "core/text/file.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/fit.hpp"
#include "optimize/run/stored_design.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

/// Every shape that a run hands to a quantity keeps to the motion limit, and the search is good along it.
namespace strake {
namespace {

/// The farthest that a vertex of any shape that the problem's first quantity has seen was from `datum`, in diagonals.
struct Watch {
    Points datum;
    double diagonal = 1, farthest = 0;
    int shapes = 0;
};

std::shared_ptr<Watch> watch(Problem& problem, const Points& datum) {
    auto seen = std::make_shared<Watch>();
    seen->datum = datum;
    seen->diagonal = box_diagonal(problem.surface);
    Quantity& quantity = problem.quantities[0];
    quantity.evaluate = [seen, ask = quantity.evaluate](const QuantityRequest& request) {
        const double far = (request.surface.vertices - seen->datum).rowwise().norm().maxCoeff() / seen->diagonal;
        seen->farthest = std::max(seen->farthest, far);
        ++seen->shapes;
        return ask(request);
    };
    return seen;
}

Problem more_volume(int levels, double limit) {
    Problem problem = ellipsoid_problem(2, levels);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.parameters.max_displacement = limit;
    problem.objective = "volume";
    problem.maximize = true;
    problem.optimize.max_evaluations = 40;
    return problem;
}

bool says(const std::string& words, const std::string& part) { return words.find(part) != std::string::npos; }

/// The tip of the ellipsoid slides along y and z; the objective is the way of its vertices along `direction`, whose
/// largest value within the limit is the limit itself.
Problem sliding_tip(const Eigen::Vector3d& direction, double limit) {
    Problem problem = ellipsoid_problem(2, 1);
    UserVariable slide;
    const Points c = triangle_centroids(problem.surface);
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        if (c(t, 0) > 0.8) slide.triangles.push_back(t);
    const int vertex = problem.surface.triangles(slide.triangles[0], 0);
    for (const auto& [name, way] : {std::pair{"across", Eigen::Vector3d(Eigen::Vector3d::UnitY())},
                                    std::pair{"up", Eigen::Vector3d(Eigen::Vector3d::UnitZ())}}) {
        slide.name = name;
        slide.motion.translation = way;
        problem.parameters.user_variables.push_back(slide);
    }
    problem.parameters.kinds = {};
    problem.parameters.max_displacement = limit;
    Quantity far;
    far.names = {"way"};
    far.evaluate = [=, rest = problem.surface.vertices](const QuantityRequest& request) {
        QuantityResult result;
        result.values = {(request.surface.vertices.row(vertex) - rest.row(vertex)).dot(direction)};
        result.dJ_dv = {Points::Zero(rest.rows(), 3)};
        result.dJ_dv[0].row(vertex) = direction.transpose();
        return result;
    };
    problem.quantities = {far};
    problem.objective = "way";
    problem.maximize = true;
    problem.optimize.max_evaluations = 60;
    return problem;
}

}  // namespace

TEST(MotionLimitRun, EveryShapeIsWithinWhateverTheMethod) {
    for (const Method method : {Method::sqp, Method::mma, Method::lbfgs, Method::nlopt_slsqp, Method::cobyla,
                                Method::bobyqa, Method::sbplx, Method::crs2})
        for (const double limit : {0.005, 0.05}) {
            Problem problem = more_volume(2, limit);
            problem.optimize.method = method;
            const auto seen = watch(problem, problem.surface.vertices);
            const RunResult r = optimize(problem);
            EXPECT_LE(seen->farthest, limit * (1 + 1e-9)) << method_facts(method).name;
            EXPECT_GT(seen->farthest, 0.8 * limit) << method_facts(method).name << ": " << r.reason;
            EXPECT_GE(seen->shapes, 3);
            EXPECT_GT(r.objective, r.objective_start);
        }
}

TEST(MotionLimitRun, ShapesOfDifferencesAreWithin) {
    Problem problem = more_volume(2, 0.005);
    problem.quantities[0].has_sensitivities = false;
    problem.optimize.finite_differences = true;
    problem.optimize.max_evaluations = 120;
    const auto seen = watch(problem, problem.surface.vertices);
    const RunResult r = optimize(problem);
    EXPECT_LE(seen->farthest, 0.005 * (1 + 1e-9));
    Problem exact = more_volume(2, 0.005);
    EXPECT_NEAR(r.objective / optimize(exact).objective, 1, 1e-3) << r.reason;
}

TEST(MotionLimitRun, ReachesTheKnownOptimumOnTheBall) {
    const Eigen::Vector3d direction(0, 0.6, 0.8);
    for (const double limit : {0.002, 0.02}) {
        Problem problem = sliding_tip(direction, limit);
        const auto seen = watch(problem, problem.surface.vertices);
        const double L = limit * box_diagonal(problem.surface);
        const RunResult r = optimize(problem);
        EXPECT_LE(seen->farthest, limit * (1 + 1e-9));
        EXPECT_GT(r.objective, (1 - 1e-4) * L) << r.reason;
        EXPECT_EQ(r.status, "converged") << r.reason;
        EXPECT_TRUE(r.motion.is_active);
        EXPECT_TRUE(says(r.reason, "converged at the motion limit")) << r.reason;
        // The optimum is the limit: 0.1 % of the diagonal more gives as much.
        EXPECT_NEAR(r.motion.gain, 1e-3 * box_diagonal(problem.surface), 0.02e-3 * box_diagonal(problem.surface));
        EXPECT_TRUE(says(r.reason, "0.1 % of the diagonal more motion would gain about")) << r.reason;
        EXPECT_LE(r.evaluations, 25);
    }
}

/// Even pressure hardly moves a closed body: what its patches may do together is much more than each may do alone.
TEST(MotionLimitRun, SearchesByModelsUseWhatVariablesMayDoTogether) {
    Problem problem = more_volume(2, 0.01);
    const RunResult exact = optimize(problem);
    problem.quantities[0].has_sensitivities = false;
    problem.optimize.method = Method::model;
    const auto seen = watch(problem, problem.surface.vertices);
    for (const bool is_narrow : {false, true}) {
        problem.optimize.models_begin_with_narrow_ranges = is_narrow;
        RunEvents events;
        double widest = 0;  // of the first level: what is inherited widens others
        events.level = [&](const LevelStart& level) {
            if (widest == 0) widest = level.space.upper.maxCoeff();
        };
        const RunResult r = optimize(problem, events);
        EXPECT_LE(seen->farthest, 0.01 * (1 + 1e-9)) << r.reason;
        EXPECT_GT(r.objective - r.objective_start, 0.9 * (exact.objective - exact.objective_start)) << r.reason;
        if (is_narrow) {
            EXPECT_EQ(widest, 1);
        } else {
            EXPECT_GT(widest, 2);
        }
    }
}

/// What a user variable may do alone is no licence to leave the limit of the surface.
TEST(MotionLimitRun, AVariableWithAWiderLimitOfItsOwnStaysWithin) {
    constexpr double limit = 0.01;
    for (const Method method : {Method::sqp, Method::mma, Method::cobyla}) {
        Problem problem = sliding_tip(Eigen::Vector3d(0, 0.6, 0.8), limit);
        problem.optimize.method = method;
        for (UserVariable& variable : problem.parameters.user_variables) variable.max_displacement = 3 * limit;
        const auto seen = watch(problem, problem.surface.vertices);
        const RunResult r = optimize(problem);
        EXPECT_LE(seen->farthest, limit * (1 + 1e-9)) << method_facts(method).name << ": " << r.reason;
        EXPECT_GT(seen->farthest, 0.9 * limit) << method_facts(method).name << ": " << r.reason;
        EXPECT_GE(seen->shapes, 3);
    }
}

TEST(MotionLimitRun, TheOptimumIsTheOneOfOtherSearches) {
    Problem problem = more_volume(1, 0.01);
    const RunResult r = optimize(problem);
    double best = r.objective;
    for (const Method method : {Method::cobyla, Method::mma}) {
        Problem other = problem;
        other.optimize.method = method;
        other.optimize.max_evaluations = 200;
        best = std::max(best, optimize(other).objective);
    }
    EXPECT_GT(r.objective - r.objective_start, 0.99 * (best - r.objective_start)) << r.reason;
    EXPECT_TRUE(says(r.reason, "the motion limit (1 % of the diagonal) is active on ")) << r.reason;
    EXPECT_TRUE(says(r.reason, "at vertex ")) << r.reason;
}

/// Variables of their own scale, and a limit that nothing reaches: the run of the variables' boxes.
TEST(MotionLimitRun, WithoutAnActiveLimitNothingChanges) {
    Problem problem = ellipsoid_problem(2, 2);
    maximize_volume(problem, 1.01);
    problem.parameters.kinds = {VariableKind::normal_load};
    problem.parameters.limits_variables = true;
    problem.parameters.max_displacement = 0.2;
    const RunResult before = optimize(problem);
    problem.parameters.limits_variables = false;
    const RunResult now = optimize(problem);
    EXPECT_FALSE(now.motion.is_active);
    EXPECT_NEAR(now.objective / before.objective, 1, 1e-3) << now.reason << "\n" << before.reason;
    EXPECT_LE(std::abs(now.evaluations - before.evaluations), 0.1 * before.evaluations)
        << now.reason << " " << now.evaluations << "\n"
        << before.reason << " " << before.evaluations;
}

TEST(MotionLimitRun, SidesHold) {
    Problem problem = more_volume(2, 0.02);
    const int n = problem.surface.num_vertices();
    problem.parameters.max_outward = Eigen::VectorXd::Constant(n, 0.02);
    problem.parameters.max_inward = Eigen::VectorXd::Constant(n, 0.02);
    for (int v = 0; v < n; ++v)
        if (problem.surface.vertices(v, 0) > 0) problem.parameters.max_outward[v] = 0.002;
    const Points rest = problem.surface.vertices;
    const auto normals = [&] {
        Points sum = Points::Zero(n, 3);
        const Points normal = triangle_normals(problem.surface);
        const Eigen::VectorXd area = triangle_areas(problem.surface);
        for (int t = 0; t < problem.surface.num_triangles(); ++t)
            for (int k = 0; k < 3; ++k) sum.row(problem.surface.triangles(t, k)) += area[t] * normal.row(t);
        return Points(sum.rowwise().normalized());
    }();
    double outward = 0, elsewhere = 0;
    const double diagonal = box_diagonal(problem.surface);
    problem.quantities[0].evaluate = [&, ask = problem.quantities[0].evaluate](const QuantityRequest& request) {
        const Points d = (request.surface.vertices - rest) / diagonal;
        for (int v = 0; v < n; ++v) {
            double& most = rest(v, 0) > 0 ? outward : elsewhere;
            most = std::max(most, d.row(v).dot(normals.row(v)));
            EXPECT_LE(d.row(v).norm(), 0.02 * (1 + 1e-9));
        }
        return ask(request);
    };
    const RunResult r = optimize(problem);
    EXPECT_LE(outward, 0.002 * (1 + 1e-9));
    EXPECT_GT(outward, 0.0015) << r.reason;
    EXPECT_GT(elsewhere, 0.004) << r.reason;
    EXPECT_GT(r.objective, r.objective_start);
}

/// A start that lies on a limit of zero is left where that can be, and where it cannot no gradient is accused of it.
TEST(MotionLimitRun, AStartOnALimitOfZero) {
    for (const double from : {0.6, -2.0}) {  // x from where on nothing may go inward
        Problem problem = more_volume(2, 0.01);
        const int n = problem.surface.num_vertices();
        problem.parameters.max_outward = Eigen::VectorXd::Constant(n, 0.01);
        problem.parameters.max_inward = problem.parameters.max_outward;
        for (int v = 0; v < n; ++v)
            if (problem.surface.vertices(v, 0) > from) problem.parameters.max_inward[v] = 0;
        const RunResult r = optimize(problem);
        if (from > 0) {
            EXPECT_GT(r.objective, 1.002 * r.objective_start) << r.reason;
        }
        EXPECT_NE(r.status, "gradient_inconsistent") << r.reason;
    }
}

/// The datum is the shape under the given loads, not the surface of the file.
TEST(MotionLimitRun, TheDatumIsUnderTheGivenLoads) {
    Problem problem = more_volume(1, 0.01);
    problem.given_traction = Points::Zero(problem.surface.num_triangles(), 3);
    const Points c = triangle_centroids(problem.surface);
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        if (c(t, 0) > 0.5) problem.given_traction(t, 2) = 1;
    // A traction that bends the body by 3 % of the diagonal.
    const auto bent = [&](double size) {
        Problem loaded = problem;
        loaded.given_traction *= size;
        const auto rest = rest_facts(loaded);
        ShapeEvaluator evaluator(loaded, rest, {});
        const DesignSpace space = design_space(rest, 1);
        evaluator.enter(space);
        return evaluator.evaluate(Eigen::VectorXd::Zero(space.size()), 1);
    };
    const double diagonal = box_diagonal(problem.surface);
    double size = 1e-9;
    size *= 0.03 * diagonal / bent(size).max_displacement;
    const ShapeEvaluation datum = bent(size);
    ASSERT_EQ(datum.status, EvaluationStatus::ok) << datum.reason;
    ASSERT_GT(datum.max_displacement, 0.02 * diagonal);
    problem.given_traction *= size;
    const auto seen = watch(problem, datum.vertices);
    const RunResult r = optimize(problem);
    EXPECT_LE(seen->farthest, 0.01 * (1 + 1e-6));  // two solutions of the datum differ by round-off
    EXPECT_GT(seen->farthest, 0.009) << r.reason;
    EXPECT_GT(r.objective, r.objective_start);
}

/// The datum is solved before anything is evaluated, and a stop in the middle of it is one as any other.
TEST(MotionLimitRun, AStopWhileTheDatumIsSolvedEndsTheRunInOrder) {
    Problem problem = more_volume(1, 0.01);
    problem.given_traction = Points::Zero(problem.surface.num_triangles(), 3);
    problem.given_traction.col(2).setConstant(1e-9);
    RunEvents events;
    events.stop_wanted = [] { return true; };
    const RunResult r = optimize(problem, events);
    EXPECT_EQ(r.status, "interrupted") << r.reason;
    EXPECT_EQ(r.evaluations, 0);
    EXPECT_TRUE(r.levels.empty());
    Problem fitted = problem;
    fitted.parameters.is_limit_stated = true;
    fitted.objective.clear();
    fitted.quantities = {target_shape_same("match", problem.surface, ellipsoid({1, 0.6, 0.45}, 2))};
    fitted.fit = {fitted.quantities[0].names[0]};
    EXPECT_EQ(fit(fitted, events).status, "interrupted");
}

TEST(MotionLimitRun, AStoredDesignBeyondTheLimitIsMovedInside) {
    TempFolder folder;
    RunEvents events;
    events.accepted = [&](const AcceptedDesign& d) {
        write_atomically(folder / "best.design", design_bytes(stored_design(d)));
    };
    const RunResult far = optimize(more_volume(2, 0.03), events);
    ASSERT_GT(far.motion.used, 0.9);
    Problem problem = more_volume(2, 0.01);
    const auto seen = watch(problem, problem.surface.vertices);
    start_from(problem, std::make_shared<StoredDesign>(read_design(folder / "best.design")));
    const RunResult r = optimize(problem);
    EXPECT_LE(seen->farthest, 0.01 * (1 + 1e-9)) << r.reason;
    EXPECT_GT(r.best_evaluation, 0) << r.reason;
    const RunResult own = optimize(more_volume(2, 0.01));
    EXPECT_NEAR(r.objective / own.objective, 1, 2e-3) << r.reason << "\n" << own.reason;
}

TEST(MotionLimitRun, AFitHasNoLimitUnlessItIsStated) {
    Problem problem = ellipsoid_problem(2, 1);
    TriMesh target = problem.surface;
    target.vertices.col(2) *= 1.2;
    problem.quantities.push_back(target_shape_same("match", problem.surface, target));
    problem.fit = {"match"};
    problem.parameters.max_displacement = 0.002;
    const double diagonal = box_diagonal(problem.surface);
    const auto moved = [&](const RunResult& r) {
        return (r.vertices - problem.surface.vertices).rowwise().norm().maxCoeff() / diagonal;
    };
    const RunResult free = fit(problem);
    EXPECT_GT(moved(free), 0.004) << free.reason;
    problem.parameters.is_limit_stated = true;
    const RunResult held = fit(problem);
    EXPECT_LE(moved(held), 0.002 * (1 + 1e-9)) << held.reason;
    EXPECT_GT(moved(held), 0.0018) << held.reason;
    EXPECT_TRUE(says(held.reason, "the motion limit (0.2 % of the diagonal) is active")) << held.reason;
}

/// A part that follows a tip goes farther than any vertex of its host.
TEST(MotionLimitRun, AttachedPartsCount) {
    Problem problem = more_volume(2, 0.01);
    TriMesh& mesh = problem.surface;
    const TriMesh host = mesh;
    TriMesh pod = ellipsoid({0.1, 0.05, 0.05}, 1);
    pod.vertices.rowwise() += Eigen::RowVector3d(0.9, 0, 1.2);
    const int n = host.num_vertices(), m = host.num_triangles();
    mesh.vertices.conservativeResize(n + pod.num_vertices(), 3);
    mesh.vertices.bottomRows(pod.num_vertices()) = pod.vertices;
    mesh.triangles.conservativeResize(m + pod.num_triangles(), 3);
    mesh.triangles.bottomRows(pod.num_triangles()) = pod.triangles.array() + n;
    problem.tree = octants(mesh, 2);
    problem.prism_height = Eigen::VectorXd::Constant(mesh.num_vertices(), 0.05 * box_diagonal(host));
    AttachedPart part;
    part.name = "pod";
    const Points c = triangle_centroids(mesh);
    for (int t = 0; t < m; ++t)
        if (c(t, 0) > 0.7) part.host.push_back(t);
    for (int t = m; t < mesh.num_triangles(); ++t) part.triangles.push_back(t);
    problem.attached = {part};
    problem.parameters.kinds = {VariableKind::load};
    problem.parameters.variables_on.assign(mesh.num_triangles(), 1);
    for (const int t : part.triangles) problem.parameters.variables_on[t] = 0;
    problem.quantities = {volume(mesh), area()};
    const auto seen = watch(problem, mesh.vertices);
    const RunResult r = optimize(problem);
    EXPECT_LE(seen->farthest, 0.01 * (1 + 1e-9)) << r.reason;
    EXPECT_GT(seen->farthest, 0.009) << r.reason;
}

}  // namespace strake
