#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/planform/kept_sections.hpp"
#include "core/planform/planform_motion.hpp"
#include "core/wrap/halves.hpp"
#include "core/wrap/wrap_map.hpp"
#include "evaluated.hpp"
#include "optimize/evaluate/fold_conditions.hpp"
#include "optimize/space/field_conditions.hpp"
#include "optimize/space/response_metric.hpp"
#include "problems.hpp"
#include "tests/core/planform/lofted_wing.hpp"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

/// Runs whose loads or fields keep the edges of a wing: alone and beside changes of its planform.
namespace strake {
namespace {

struct KeptRun {
    Problem problem;
    std::shared_ptr<const Wing> wing;
};

/// Level 1 has nose, middle and tail. One patch of all that is free can but inflate the wing, and gains nothing where
/// the area must not grow.
PatchHierarchy along_the_chord(const TriMesh& mesh, const Loft& loft) {
    const Points c = triangle_centroids(mesh);
    const auto third = [&](int t) {
        const double s = c(t, 1) / loft.semispan, chord = loft.chord(s);
        const double fraction = (c(t, 0) - loft.quarter(s)) / chord + 0.25;
        return fraction < 0.25 ? 0 : fraction < 0.6 ? 1 : 2;
    };
    PatchHierarchy tree;
    tree.levels.push_back(level_by(mesh, nullptr, [](int) { return 0; }));
    tree.levels.push_back(level_by(mesh, &tree.levels.back(), third));
    return tree;
}

/// Half a wing whose first 25 % of the span is fixed.
KeptRun kept_run(bool has_shell, bool has_planform, bool keeps = true) {
    Loft loft;
    loft.cells = 16;
    loft.panels = 40;  // enough points for the polynomial of the nose
    KeptRun run;
    Problem& problem = run.problem;
    problem.name = "wing";
    problem.surface = lofted(loft);
    problem.symmetry = SymmetryPlane{Eigen::Vector3d::UnitY(), 0};
    problem.has_shell = has_shell;
    problem.tree = has_shell ? along_the_chord(problem.surface, loft) : octants(problem.surface, 0);
    WingDeclaration declared;
    declared.symmetry = problem.symmetry;
    declared.stations = {0, 0.5, 1};
    for (int t = 0; t < problem.surface.num_triangles(); ++t) {
        double low = 9;
        for (const int v : problem.surface.triangles.row(t)) low = std::min(low, problem.surface.vertices(v, 1));
        (low > 0.75 - 1e-9 ? declared.triangles : problem.fixed).push_back(t);
    }
    run.wing = std::make_shared<const Wing>(problem.surface, declared);
    Parameters& p = problem.parameters;
    p.max_displacement = 0.02;
    if (has_planform) {
        std::vector<PlanformRange> ranges{
            {.change = PlanformChange::sweep, .lower = -0.1, .upper = 0.1},
            {.change = PlanformChange::twist, .by_station = true, .root_held = true, .lower = -0.07, .upper = 0.07}};
        add_planform(p, std::make_shared<const PlanformMotion>(problem.surface, std::vector{run.wing}, ranges));
    }
    problem.quantities = {closed_volume(problem.surface), area(true)};
    if (keeps)
        p.kept_sections = std::make_shared<const KeptSections>(problem.surface, std::vector{run.wing}, problem.fixed);
    if (has_shell) {
        problem.prism_height =
            Eigen::VectorXd::Constant(problem.surface.num_vertices(), 0.02 * box_diagonal(problem.surface));
        p.kinds = {VariableKind::normal_load};
    } else {
        p.kinds.clear();
        add_fields(p, std::make_shared<const DisplacementFields>(problem.surface, field_conditions(problem),
                                                                 FieldOptions{12, {}}));
    }
    return run;
}

/// Largest of what the edges are off, over the chord, and of the twist, in degrees.
std::array<double, 2> off(const KeptRun& run, const Points& vertices) {
    std::array<double, 2> worst{};
    const TriMesh now = with_vertices(run.problem.surface, vertices);
    for (const double station : {0.05, 0.31, 0.5, 0.77, 0.9}) {
        const StationFacts a = run.wing->station(run.problem.surface, station), b = run.wing->station(now, station);
        worst[0] = std::max({worst[0], (a.leading_edge - b.leading_edge).norm() / a.chord.value,
                             (a.trailing_edge - b.trailing_edge).norm() / a.chord.value});
        worst[1] = std::max(worst[1], std::abs(a.twist.value - b.twist.value) * 180 / std::numbers::pi);
    }
    return worst;
}

TEST(KeptSectionsRun, GradientsAreExact) {
    for (const bool has_shell : {false, true})
        for (const bool has_planform : {false, true}) {
            SCOPED_TRACE(testing::Message() << (has_shell ? "shell" : "fields") << (has_planform ? ", planform" : ""));
            Evaluated e(kept_run(has_shell, has_planform).problem);
            const Eigen::VectorXd x = 0.15 * random_vector(e.space.size(), 3), p = random_vector(e.space.size(), 5);
            expect_exact_gradients(e, x, p);
        }
}

/// A small change of the surface must not be made of fields that move far and whose motion is taken out: no section is
/// brought back from there.
TEST(KeptSectionsRun, NoSmallChangeIsMadeOfLargeMotions) {
    for (const bool keeps : {true, false}) {
        Problem problem = kept_run(false, false, keeps).problem;
        problem.parameters.user_variables.clear();
        add_fields(problem.parameters, std::make_shared<const DisplacementFields>(
                                           problem.surface, field_conditions(problem), FieldOptions{60, {}}));
        const Evaluated e(problem);
        const Parameters& p = e.problem.parameters;
        const double unit = p.max_displacement * e.rest->diagonal / 2;
        Eigen::MatrixXd moved(3 * e.problem.surface.num_vertices(), e.space.size());
        double farthest = 0;
        for (int j = 0; j < e.space.size(); ++j) {
            const Variable& v = e.space.variables[static_cast<std::size_t>(j)];
            const Points field =
                v.unit * p.fields->field(p.user_variables[static_cast<std::size_t>(v.component)].field);
            farthest = std::max(farthest, field.rowwise().norm().maxCoeff() / (2 * unit));
            const Points weighted =
                (e.rest->vertex_area / e.rest->vertex_area.sum()).cwiseSqrt().asDiagonal() * field / unit;
            moved.col(j) = weighted.reshaped();
        }
        // The motion before sections are kept, at most: of a change of length 1.
        const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(moved.transpose() * moved,
                                                                               e.space.metric);
        const double most = std::sqrt(solver.eigenvalues().maxCoeff());
        if (keeps) {
            EXPECT_LT(most, 1.05 / held_share);
            EXPECT_LT(farthest, 1.01 / held_share);
            problem.parameters.counts_kept_motion_alone = true;
            const Evaluated before(problem);
            EXPECT_GT((before.space.metric - e.space.metric).norm(), 0.1 * e.space.metric.norm()) << "of earlier runs";
        } else {
            EXPECT_NEAR(most, 1, 0.05) << "fields that stay as they are";
        }
    }
}

/// The same wing carried by a wrap around it, half an ellipsoid that ends on the plane of symmetry: loads act on the
/// wrap, what it makes of the wing keeps the edges, and fields and planform act on the wing itself.
KeptRun wrapped_run() {
    KeptRun run = kept_run(true, true);
    Problem& problem = run.problem;
    const Eigen::RowVector3d low = problem.surface.vertices.colwise().minCoeff(),
                             high = problem.surface.vertices.colwise().maxCoeff();
    TriMesh around = ellipsoid({0.8 * (high[0] - low[0]), 1.25 * high[1], 0.8 * (high[2] - low[2]) + 0.1}, 2);
    around.vertices.col(0).array() += 0.5 * (low[0] + high[0]);
    around.vertices.col(2).array() += 0.5 * (low[2] + high[2]);
    WrapMapOptions options;
    options.plane = problem.symmetry, options.is_half = true;
    options.held.assign(static_cast<std::size_t>(problem.surface.num_vertices()), 0);
    for (const int t : problem.fixed)
        for (const int v : problem.surface.triangles.row(t)) options.held[static_cast<std::size_t>(v)] = 1;
    around = clipped(around, *problem.symmetry, 1e-9);
    problem.wrap = std::make_shared<const WrapMap>(around, problem.surface, options);
    const Points c = triangle_centroids(around);
    for (int t = 0; t < around.num_triangles(); ++t)
        if (c(t, 1) < 0.75) problem.supports.push_back(t);
    problem.tree = octants(around, 1);
    problem.prism_height = Eigen::VectorXd::Constant(around.num_vertices(), 0.02 * box_diagonal(around));
    add_fields(problem.parameters, std::make_shared<const DisplacementFields>(
                                       problem.surface, field_conditions(problem), FieldOptions{12, {}}));
    return run;
}

TEST(KeptSectionsRun, GradientsThroughAWrapAreExact) {
    const KeptRun run = wrapped_run();
    Evaluated e(run.problem);
    const Eigen::VectorXd x = 0.1 * random_vector(e.space.size(), 3), p = random_vector(e.space.size(), 5);
    expect_exact_gradients(e, x, p);
    // Without changes of the planform every shape keeps the edges.
    Eigen::VectorXd kept = x;
    for (int j = 0; j < e.space.size(); ++j)
        if (e.space.variables[static_cast<std::size_t>(j)].name.find("delta_") != std::string::npos) kept[j] = 0;
    const std::array<double, 2> worst = off(run, e.evaluator.evaluate(kept, 1).vertices);
    EXPECT_LT(worst[0], 1e-4);
    EXPECT_LT(worst[1], 0.02);
}

TEST(KeptSectionsRun, EdgesStayInEveryShapeAndRunsGain) {
    for (const bool has_shell : {false, true}) {
        SCOPED_TRACE(has_shell ? "shell" : "fields");
        const KeptRun run = kept_run(has_shell, false), free = kept_run(has_shell, false, false);
        std::array<double, 2> worst{}, before{};
        for (const KeptRun* one : {&run, &free}) {
            Evaluated e(one->problem);
            const Eigen::VectorXd x = (0.1 * random_vector(e.space.size(), 3)).cwiseMax(e.space.lower);
            const ShapeEvaluation at = e.evaluator.evaluate(x, 1);
            ASSERT_EQ(at.status, EvaluationStatus::ok) << at.reason;
            (one == &run ? worst : before) = off(*one, at.vertices);
            EXPECT_GT(at.max_displacement, 1e-4 * e.rest->diagonal);
            for (const int t : one->problem.fixed)
                for (const int v : one->problem.surface.triangles.row(t))
                    EXPECT_EQ(at.vertices.row(v), one->problem.surface.vertices.row(v));
        }
        EXPECT_GT(before[0], 1e-3) << "the test can fail";
        EXPECT_LT(worst[0], 1e-4);
        EXPECT_LT(worst[1], 0.02);
        Problem problem = run.problem;
        maximize_volume(problem, 1.0);
        problem.optimize.max_evaluations = 14;
        expect_run_is_stored(problem, 0.02, 1e-8);
    }
}

/// A design is what it is by what its wing keeps: it neither starts nor is mixed with one that keeps something else.
TEST(KeptSectionsRun, DesignsOfOtherRulesAreRefused) {
    const auto design_of = [](Problem& problem) {
        std::shared_ptr<const StoredDesign> best;
        RunEvents events;
        events.accepted = [&](const AcceptedDesign& design) {
            best = std::make_shared<const StoredDesign>(stored_design(design));
        };
        maximize_volume(problem, 1.02);
        problem.optimize.max_evaluations = 4;
        optimize(problem, events);
        return best;
    };
    Problem kept = kept_run(false, false).problem, free = kept_run(false, false, false).problem;
    const auto a = design_of(kept), b = design_of(free);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(mixed_design({kept, a}, {kept_run(false, false).problem, a}, 0.5).defect, "");
    const auto words_of = [](const auto& act) -> std::string {
        try {
            act();
        } catch (const InvalidInput& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_NE(words_of([&] { mixed_design({kept, a}, {free, b}, 0.5); }).find("planform: keep"), std::string::npos);
    Problem from = kept;
    start_from(from, b);
    EXPECT_NE(words_of([&] { optimize(from); }).find("planform: keep"), std::string::npos);
}

TEST(KeptSectionsRun, TheMetricIsThatOfWhatIsKept) {
    for (const bool has_shell : {false, true}) {
        Evaluated e(kept_run(has_shell, false).problem);
        const Eigen::VectorXd rest = Eigen::VectorXd::Zero(e.space.size()), d = random_vector(e.space.size(), 9);
        const Eigen::VectorXd product = e.evaluator.metric_product(rest, d);
        ASSERT_EQ(product.size(), d.size());
        EXPECT_LT((product - e.space.metric * d).norm(), 1e-5 * product.norm());
        EXPECT_GT(e.space.metric.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0);
    }
}

TEST(KeptSectionsRun, FoldConditionsFollow) {
    const Evaluated e(kept_run(false, true).problem);
    Eigen::VectorXd x = 0.5 * random_vector(e.space.size(), 3).cwiseMax(e.space.lower).cwiseMin(e.space.upper);
    const Eigen::VectorXd p = random_vector(e.space.size(), 5);
    constexpr double below = 0.9, h = 1e-4;
    for (int tries = 0; tries < 20 && fold_conditions(e.space, x, below).values.size() < 4; ++tries)
        for (int j = 0; j < e.space.size(); ++j)
            if (e.space.variables[static_cast<std::size_t>(j)].kind == VariableKind::field) x[j] *= 1.5;
    const FoldConditions at = fold_conditions(e.space, x, below);
    ASSERT_GE(at.values.size(), 4);
    const Eigen::VectorXd change =
        (fold_conditions(e.space, x + h * p, below).values - fold_conditions(e.space, x - h * p, below).values) /
        (2 * h);
    ASSERT_EQ(change.size(), at.values.size());
    EXPECT_LT((change - at.slopes * p).norm(), 1e-4 * change.norm());
}

}  // namespace
}  // namespace strake
