#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "evaluated.hpp"
#include "optimize/problem/sliding_parts.hpp"
#include "optimize/run/fit.hpp"
#include "problems.hpp"
#include "tests/core/repair/defective.hpp"

#include <gtest/gtest.h>
#include <Eigen/QR>
#include <map>
#include <set>

using namespace strake;

namespace {

Problem with_fields(int number, std::vector<VariableKind> kinds = {VariableKind::load}) {
    Problem problem = ellipsoid_problem(2, 3);
    problem.parameters.kinds = std::move(kinds);
    problem.parameters.free_border = 0.6;
    FieldConditions conditions;
    conditions.held = problem.fixed;
    add_fields(problem.parameters,
               std::make_shared<const DisplacementFields>(problem.surface, conditions, FieldOptions{number, {}}));
    return problem;
}

int count_of(const DesignSpace& space, VariableKind kind) {
    return static_cast<int>(
        std::ranges::count_if(space.variables, [&](const Variable& variable) { return variable.kind == kind; }));
}

}  // namespace

TEST(Fields, AreLevelZeroAndStayBesideThePatches) {
    const Evaluated coarse(with_fields(12), 0), fine(with_fields(12), 1);
    EXPECT_EQ(coarse.space.size(), 12);
    EXPECT_EQ(count_of(coarse.space, VariableKind::field), 12);
    EXPECT_EQ(count_of(fine.space, VariableKind::field), 12);
    EXPECT_EQ(count_of(fine.space, VariableKind::load), 6);
    EXPECT_EQ(coarse.space.variables[0].name, fine.space.variables[0].name);
    EXPECT_EQ(coarse.space.variables[0].name.substr(0, 8), "section.");
}

TEST(Fields, GradientsAreExactAloneAndBesidePatches) {
    for (const auto& kinds : std::vector<std::vector<VariableKind>>{
             {VariableKind::load}, {VariableKind::normal_load, VariableKind::stiffness}, {VariableKind::strain}, {}})
        for (const double size : {0.1, 0.6})
            for (const int level : {0, 1}) {
                if (level == 0 && kinds != std::vector<VariableKind>{VariableKind::load}) continue;
                Evaluated e(with_fields(12, kinds), level);
                const Eigen::VectorXd x = size * random_vector(e.space.size(), 3), p = random_vector(e.space.size(), 5);
                ShapeEvaluation here = e.at(x);
                e.evaluator.differentiate(here);
                for (int i = 0; i < 2; ++i) {
                    const Eigen::VectorXd g = here.gradients.row(i);
                    const auto J = [&](const Eigen::VectorXd& y) { return e.at(y).values[i]; };
                    EXPECT_NEAR(taylor_order(J, x, g, p, 3e-3), 2, 0.15) << kinds.size() << ' ' << size << ' ' << i;
                    Eigen::VectorXd wrong = g;
                    wrong[0] *= 1.1;
                    EXPECT_NEAR(taylor_order(J, x, wrong, p, 3e-3), 1, 0.15) << "the test can fail";
                }
            }
}

TEST(Fields, AChangeOfFieldsAloneMovesTheSurfaceByThemAndLeavesTheShell) {
    Evaluated e(with_fields(12), 1);
    Eigen::VectorXd x = 0.5 * random_vector(e.space.size(), 3);
    const Points before = e.at(x).vertices;
    const Poses poses = e.evaluator.poses();
    Eigen::VectorXd change = Eigen::VectorXd::Zero(x.size());
    change.head(12) = 0.3 * random_vector(12, 4);
    const Points after = e.at(x + change).vertices;
    EXPECT_LT((after - before - field_motion(e.space, change)).cwiseAbs().maxCoeff(), 1e-14);
    for (std::size_t t = 0; t < poses.rotation.size(); ++t)
        EXPECT_EQ(poses.rotation[t].coeffs(), e.evaluator.poses().rotation[t].coeffs()) << "no new equilibrium";
    for (const int t : e.problem.fixed)
        for (int k = 0; k < 3; ++k) {
            const int v = e.problem.surface.triangles(t, k);
            EXPECT_EQ(after.row(v), e.problem.surface.vertices.row(v));
        }
}

TEST(Fields, AreInheritedExactlyFromLevelToLevel) {
    for (const auto& kinds :
         std::vector<std::vector<VariableKind>>{{VariableKind::load}, {VariableKind::normal_load}}) {
        Evaluated e(with_fields(12, kinds), 0);
        DesignSpace space = e.space;
        Eigen::VectorXd x = 0.5 * random_vector(space.size(), 9);
        ShapeEvaluation before = e.at(x);
        for (int level = 1; level <= 3; ++level) {
            e.evaluator.accept();
            const InheritedSpace child = refine(space, x);
            e.evaluator.enter(child.space);
            const ShapeEvaluation after = e.at(child.x);
            EXPECT_LT((after.vertices - before.vertices).cwiseAbs().maxCoeff(), 1e-10 * e.rest->diagonal);
            EXPECT_EQ(child.prolongation.cols(), space.size());
            space = child.space;
            x = child.x + 0.1 * random_vector(child.x.size(), 10);  // patches join in
            before = e.at(x);
        }
    }
}

TEST(Fields, TheMetricCouplesThemWithLoadsThroughTheirDisplacements) {
    Evaluated e(with_fields(6), 1);
    e.at(Eigen::VectorXd::Zero(e.space.size()));
    std::vector<Points> moved;
    design_response(e.space, e.evaluator.shell(), [&](int, const Points& dv) { moved.push_back(dv); });
    const double reach = e.problem.parameters.max_displacement * e.rest->diagonal, all = e.rest->vertex_area.sum();
    for (int i = 0; i < 6; ++i) {
        EXPECT_NEAR(moved[i].rowwise().norm().maxCoeff(), reach, 1e-9 * reach) << "the unit of all variables";
        for (int j = 0; j < e.space.size(); ++j) {
            const double mean = (e.rest->vertex_area.asDiagonal() * moved[i]).cwiseProduct(moved[j]).sum() / all;
            EXPECT_NEAR(e.space.metric(i, j), 4 * mean / (reach * reach), 1e-6 + (i == j ? 1e-8 : 0)) << i << ' ' << j;
        }
    }
    EXPECT_GT(e.space.metric.topRightCorner(6, e.space.size() - 6).cwiseAbs().maxCoeff(), 1e-2);
}

/// At an equilibrium under loads the product is that of the metric of the responses there.
TEST(Fields, ThePresentMetricKnowsThem) {
    Evaluated e(with_fields(6), 1);
    const Eigen::VectorXd x = Eigen::VectorXd::Zero(e.space.size());
    e.at(x);
    for (int j : {0, 3, 7}) {
        const Eigen::VectorXd d =
            Eigen::VectorXd::Unit(e.space.size(), j) + 0.3 * Eigen::VectorXd::Unit(e.space.size(), 1);
        const Eigen::VectorXd product = e.evaluator.metric_product(x, d), wanted = e.space.metric * d;
        ASSERT_EQ(product.size(), wanted.size());
        EXPECT_LT((product - wanted).norm(), 1e-5 * wanted.norm()) << j;
    }
}

TEST(Fields, AWingletTheyRaiseIsNotInvertedButAFoldIs) {
    Evaluated e(with_fields(12), 0);
    int turns = -1;
    for (int j = 0; j < e.space.size(); ++j)
        if (e.space.variables[j].name == "section.twist.0") turns = j;
    ASSERT_GE(turns, 0);
    const double unit = e.space.variables[turns].unit;
    // Sections that turn by more than a right angle.
    Eigen::VectorXd x = Eigen::VectorXd::Zero(e.space.size());
    x[turns] = 1.0 / unit;
    const ShapeEvaluation turned = e.evaluator.evaluate(x, 1);
    EXPECT_TRUE(turned.reason.find("inverted") == std::string::npos) << turned.reason;
    int scales = -1;
    for (int j = 0; j < e.space.size(); ++j)
        if (e.space.variables[j].name.rfind("section.scale_z.0", 0) == 0) scales = j;
    ASSERT_GE(scales, 0);
    x.setZero();
    x[scales] = 3.0 / e.space.variables[scales].unit;
    const ShapeEvaluation one = e.evaluator.evaluate(x, 2), other = e.evaluator.evaluate(-x, 3);
    EXPECT_TRUE(one.status == EvaluationStatus::invalid || other.status == EvaluationStatus::invalid)
        << "through itself and out on the other side";
}

TEST(Fields, ARunBeginsWithThemAndGoesOnWithPatches) {
    for (const SplitRule split : {SplitRule::tree, SplitRule::sensitivity}) {
        Problem problem = with_fields(12, {VariableKind::normal_load});
        problem.parameters.split = split;
        problem.optimize.min_expected_gain = 0;
        maximize_volume(problem);
        problem.optimize.max_evaluations = 30;
        const RunResult r = optimize(problem);
        EXPECT_TRUE(r.is_done()) << r.status << ": " << r.reason;
        ASSERT_GT(r.levels.size(), 1u);
        EXPECT_EQ(r.levels[0].level, 0);
        EXPECT_EQ(r.levels[0].variables, 12);
        EXPECT_GT(r.levels[1].variables, 12);
        for (const LevelSummary& level : r.levels) EXPECT_LT(level.inherited_shape_change, 1e-10);
        Problem without = problem;
        without.parameters.user_variables.clear();
        without.parameters.fields.reset();
        EXPECT_GT(r.objective, (1 - 1e-3) * optimize(without).objective);
    }
}

/// Vertices moved by one field more than the first level has: of all candidates the run takes this one.
TEST(Fields, ARefinementTakesTheFieldThatTheGradientAsksFor) {
    Problem problem = with_fields(27, {VariableKind::normal_load});
    constexpr int wanted = 19, first = 12;
    problem.parameters.field_steps = {first, 27};
    problem.parameters.split = SplitRule::sensitivity;
    problem.parameters.max_displacement = 0.1;
    const Points target = problem.surface.vertices + 0.03 * problem.parameters.fields->field(wanted) +
                          0.03 * problem.parameters.fields->field(3);
    problem.quantities = {target_shape_same("match", problem.surface, with_vertices(problem.surface, target))};
    problem.objective = problem.quantities[0].names[0];
    problem.maximize = false;
    problem.constraints.clear();
    problem.optimize.max_evaluations = 25;
    std::vector<std::vector<int>> fields;
    RunEvents events;
    events.level = [&](const LevelStart& level) { fields.push_back(level.space.fields.numbers); };
    const RunResult r = optimize(problem, events);
    ASSERT_GT(fields.size(), 1u) << r.reason;
    EXPECT_EQ(fields[0].size(), static_cast<std::size_t>(first));
    EXPECT_TRUE(std::ranges::binary_search(fields[1], wanted));
    EXPECT_LT(fields[1].size(), 20u) << "fields that the target does not need";
    EXPECT_LT(r.objective, 1e-6 * r.objective_start);
    for (const LevelSummary& level : r.levels) EXPECT_LT(level.inherited_shape_change, 1e-10);
}

/// The gradient of the start asks for fields of the last of three steps: the first step of the search has them, where
/// earlier runs took one step of fields after another, each with evaluations of its own.
TEST(Fields, OfAllStepsAreThereForTheFirstStepOfASearch) {
    Problem problem = with_fields(27, {VariableKind::normal_load});
    problem.parameters.field_steps = {6, 12, 27};
    problem.parameters.split = SplitRule::sensitivity;
    problem.parameters.max_displacement = 0.1;
    const DisplacementFields& fields = *problem.parameters.fields;
    const Points target =
        problem.surface.vertices + 0.03 * fields.field(3) + 0.02 * fields.field(9) + 0.02 * fields.field(24);
    problem.quantities = {target_shape_same("match", problem.surface, with_vertices(problem.surface, target))};
    problem.objective = problem.quantities[0].names[0];
    problem.maximize = false;
    problem.constraints.clear();
    problem.optimize.max_evaluations = 25;
    const auto evaluations_to = [&](double share) {
        int first = 0, count = 0;
        double start = 0;
        RunEvents events;
        events.evaluation = [&](const EvaluationRecord& record) {
            if (++count == 1) start = record.objective;
            if (first == 0 && record.status == "ok" && record.objective < share * start) first = count;
        };
        const RunResult r = optimize(problem, events);
        EXPECT_LT(r.objective, share * r.objective_start) << r.reason;
        return first;
    };
    const int now = evaluations_to(1e-2);
    problem.parameters.offers_fields_by_steps = true;
    EXPECT_GT(evaluations_to(1e-2), now);
}

TEST(Fields, OfSuccessiveLevelsWhereNothingTellsWhichToTake) {
    Problem problem = with_fields(12);
    problem.parameters.field_steps = {4, 9, 12};
    const std::shared_ptr<const RestFacts> rest = rest_facts(problem);
    const DesignSpace coarse = design_space(rest, 0);
    EXPECT_FALSE(coarse.has_patches);
    EXPECT_EQ(coarse.fields.numbers, (std::vector{0, 1, 2, 3}));
    EXPECT_EQ(level_set(*rest, 1).fields.numbers.size(), 9u);
    EXPECT_EQ(more_fields(problem.parameters, {{0, 1, 2, 3, 8}, 9}).numbers.size(), 12u) << "those passed over, too";
    EXPECT_EQ(offered_fields(problem.parameters, {{0, 1, 2, 3}, 4}).numbers.size(), 9u);
    problem.parameters.split = SplitRule::sensitivity;
    EXPECT_EQ(offered_fields(problem.parameters, {{0, 1, 2, 3}, 4}).numbers.size(), 12u) << "a gradient tells of all";
    problem.parameters.offers_fields_by_steps = true;
    EXPECT_EQ(offered_fields(problem.parameters, {{0, 1, 2, 3}, 4}).numbers.size(), 9u) << "runs of before";
    // Values of fields that a level does not have are carried, not lost.
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(coarse.size(), 0.1, 0.4);
    const InheritedSpace fewer = refine(coarse, x, LevelSet{*coarse.front, {{1, 3}, 4}, true});
    EXPECT_EQ(count_of(fewer.space, VariableKind::field), 2);
    const Eigen::VectorXd before = demand(coarse, x).fields, after = demand(fewer.space, fewer.x).fields;
    EXPECT_LT((before - after).norm(), 1e-12 * before.norm());
    Problem wrong = problem;
    wrong.parameters.field_steps = {4, 4, 12};
    EXPECT_THROW(rest_facts(wrong), InvalidInput);
    wrong.parameters.field_steps = {4, 9};
    EXPECT_THROW(rest_facts(wrong), InvalidInput);
}

/// Levels of fields go on where the tree has ended: the patches are those of the level above, and so are their loads.
TEST(Fields, PatchesKeepTheirLoadsWhereOnlyFieldsAreAdded) {
    Problem problem = with_fields(12, {VariableKind::load});
    problem.tree = octants(problem.surface, 1);
    problem.parameters.field_steps = {4, 9, 12};
    const std::shared_ptr<const RestFacts> rest = rest_facts(problem);
    DesignSpace space = design_space(rest, 0);
    Eigen::VectorXd x = 0.3 * random_vector(space.size(), 2);
    for (int level = 1; level <= 3; ++level) {
        const ShellDemand before = demand(space, x);
        const InheritedSpace child = refine(space, x);
        const ShellDemand after = demand(child.space, child.x);
        EXPECT_LE((after.loads.force - before.loads.force).norm(), 1e-12 * before.loads.force.norm()) << level;
        EXPECT_LT((after.fields - before.fields).norm(), 1e-12) << level;
        space = child.space;
        x = child.x + 0.3 * random_vector(space.size(), 5);
    }
    EXPECT_EQ(space.patches().patches.size(), 2u);
}

/// An integral over a patch says nothing of a field, which moves the whole surface: fields come in their steps.
TEST(Fields, WhereIntegralsOverPatchesChooseFieldsComeInSteps) {
    Problem problem = with_fields(12, {});
    problem.parameters.field_steps = {4, 9, 12};
    problem.parameters.split = SplitRule::gradient;
    maximize_volume(problem);
    problem.optimize.max_evaluations = 20;
    std::vector<std::size_t> fields;
    RunEvents events;
    events.level = [&](const LevelStart& level) { fields.push_back(level.space.fields.numbers.size()); };
    const RunResult r = optimize(problem, events);
    EXPECT_EQ(fields, (std::vector<std::size_t>{4, 9, 12})) << r.reason;
}

TEST(Fields, AFitWithThemFindsATaperedAndFlattenedBody) {
    Problem problem = with_fields(27, {});
    TriMesh target = problem.surface;
    for (int v = 0; v < target.num_vertices(); ++v) {
        const double s = std::max(0.0, target.vertices(v, 0) + 0.75) / 1.75;  // zero where it is held
        target.vertices(v, 1) *= 1 + 0.15 * s;
        target.vertices(v, 2) *= 1 - 0.2 * s;
        target.vertices(v, 0) += 0.1 * s;
    }
    problem.parameters.max_displacement = 0.1;
    problem.quantities = {target_shape_same("match", problem.surface, target)};
    problem.fit = {problem.quantities[0].names[0]};
    problem.optimize.max_evaluations = 20;
    const RunResult r = fit(problem);
    const double before = (target.vertices - problem.surface.vertices).norm();
    EXPECT_LT((r.vertices - target.vertices).norm(), std::sqrt(0.03) * before) << r.reason;
}

TEST(Fields, WrongOnesAreRefused) {
    Problem problem = with_fields(6);
    problem.parameters.user_variables.push_back(problem.parameters.user_variables[0]);
    EXPECT_THROW(rest_facts(problem), InvalidInput) << "a name twice";
    problem = with_fields(6);
    problem.parameters.fields.reset();
    EXPECT_THROW(rest_facts(problem), InvalidInput) << "a field that is not there";
    problem = with_fields(6);
    problem.surface = ellipsoid({1, 0.6, 0.4}, 3);
    EXPECT_THROW(rest_facts(problem), InvalidInput) << "of another surface";
}

namespace {

/// Fields that move a body, with a small one beside it that follows.
Problem with_attached(AttachHow how) {
    Problem problem = ellipsoid_problem(2, 2);
    const TriMesh pod = ellipsoid({0.2, 0.1, 0.1}, 1);
    const int first = problem.surface.num_vertices(), m = problem.surface.num_triangles();
    TriMesh both = problem.surface;
    both.vertices.conservativeResize(first + pod.num_vertices(), 3);
    both.vertices.bottomRows(pod.num_vertices()) = pod.vertices.rowwise() + Eigen::RowVector3d(0.4, 0, -0.65);
    both.triangles.conservativeResize(m + pod.num_triangles(), 3);
    both.triangles.bottomRows(pod.num_triangles()) = pod.triangles.array() + first;
    AttachedPart part{"pod", {}, {}, how};
    for (int t = 0; t < both.num_triangles(); ++t) (t < m ? part.host : part.triangles).push_back(t);
    std::erase_if(part.host, [&](int t) { return triangle_centroids(both)(t, 2) > 0; });
    problem.surface = both;
    problem.tree = octants(both, 2);
    problem.prism_height = Eigen::VectorXd::Constant(both.num_vertices(), 0.05 * box_diagonal(both));
    problem.attached = {part};
    problem.parameters.variables_on.assign(static_cast<std::size_t>(both.num_triangles()), 1);
    for (const int t : part.triangles) problem.parameters.variables_on[static_cast<std::size_t>(t)] = 0;
    problem.quantities = {volume(both), area()};
    FieldConditions conditions;
    conditions.held = problem.fixed;
    add_fields(problem.parameters, std::make_shared<const DisplacementFields>(both, conditions, FieldOptions{9, {}}));
    return problem;
}

}  // namespace

TEST(Fields, AttachedPartsFollowTheirHostsWhereTheseAreInTheEnd) {
    for (const AttachHow how : {AttachHow::rigid, AttachHow::follow}) {
        Evaluated e(with_attached(how), 1);
        const Eigen::VectorXd x = 0.5 * random_vector(e.space.size(), 3), p = random_vector(e.space.size(), 5);
        ShapeEvaluation here = e.at(x);
        const std::vector<int>& part = e.problem.attached[0].triangles;
        const int first = e.problem.surface.triangles(part.front(), 0);
        double moved = 0, stretched = 0;
        for (const int t : part)
            for (int k = 0; k < 3; ++k) {
                const int v = e.problem.surface.triangles(t, k), w = e.problem.surface.triangles(t, (k + 1) % 3);
                const auto length = [&](const Points& at) { return (at.row(v) - at.row(w)).norm(); };
                stretched =
                    std::max(stretched, std::abs(length(here.vertices) / length(e.problem.surface.vertices) - 1));
                moved = std::max(moved, (here.vertices.row(v) - e.problem.surface.vertices.row(v)).norm());
            }
        EXPECT_GE(first, 0);
        EXPECT_GT(moved, 0.01);
        if (how == AttachHow::rigid) {
            EXPECT_LT(stretched, 1e-12) << "a rigid part stays so";
        }
        e.evaluator.differentiate(here);
        for (int i = 0; i < 2; ++i) {
            const Eigen::VectorXd g = here.gradients.row(i);
            const auto J = [&](const Eigen::VectorXd& y) { return e.at(y).values[i]; };
            EXPECT_NEAR(taylor_order(J, x, g, p, 3e-3), 2, 0.15) << i;
            EXPECT_NEAR(taylor_order(J, x, 1.1 * g, p, 3e-3), 1, 0.15) << "the test can fail";
        }
        const ShapeEvaluation again = e.at(x);
        std::vector<Points> rates;
        design_response(
            e.space, e.evaluator.shell(), [&](int, const Points& dv) { rates.push_back(dv); }, 1e-11, &again.vertices);
        for (int j = 0; j < e.space.size(); j += 4) {
            const Eigen::VectorXd h = 1e-4 * Eigen::VectorXd::Unit(e.space.size(), j);
            const Points slope = (e.at(x + h).vertices - e.at(x - h).vertices) / 2e-4;
            EXPECT_LT((slope - rates[static_cast<std::size_t>(j)]).norm(), 1e-5 * slope.norm()) << j;
        }
    }
}

/// Every field alone, and every patch beside them: remainders of second order, at rest and after large moves.
TEST(Fields, EveryVariableHasItsExactDerivative) {
    Evaluated e(with_fields(27, {VariableKind::normal_load}), 1);
    for (const double size : {0.0, 0.7}) {
        const Eigen::VectorXd x = size * random_vector(e.space.size(), 11);
        ShapeEvaluation here = e.at(x);
        e.evaluator.differentiate(here);
        const Eigen::VectorXd g = here.gradients.row(0), area = here.gradients.row(1);
        for (int j = 0; j < e.space.size(); ++j) {
            const Eigen::VectorXd p = Eigen::VectorXd::Unit(e.space.size(), j);
            // The area has a curvature in every direction; a volume may be linear in a field.
            const auto J = [&](const Eigen::VectorXd& y) { return e.at(y).values[1]; };
            EXPECT_NEAR(taylor_order(J, x, area, p, 1e-2), 2, 0.3) << e.space.variables[j].name << ' ' << size;
            const Eigen::VectorXd wrong = area + (0.1 * std::abs(area[j]) + 0.01 * area.norm()) * p;
            EXPECT_NEAR(taylor_order(J, x, wrong, p, 1e-2), 1, 0.3) << "the test can fail";
        }
    }
}

namespace {

/// A crooked box, held below, with fields and the patches of `tree`; the half has the plane y = 1 as its cut.
Problem box_problem(const TriMesh& mesh, bool is_half) {
    Problem problem;
    problem.surface = mesh;
    problem.tree.levels.push_back(level_by(mesh, nullptr, [](int) { return 0; }));
    const Points c = triangle_centroids(mesh);
    problem.tree.levels.push_back(level_by(mesh, &problem.tree.levels.back(), [&](int t) { return c(t, 2) > 0.6; }));
    problem.prism_height = Eigen::VectorXd::Constant(mesh.num_vertices(), 0.1);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (c(t, 2) < 0.3) problem.fixed.push_back(t);
    problem.parameters.load_directions = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()};
    // The plane of the whole and the half's cut are the same; diagonals are not.
    FieldConditions conditions;
    conditions.held = problem.fixed;
    const SymmetryPlane plane{Eigen::Vector3d::UnitY(), 1};
    if (is_half) problem.symmetry = plane, conditions.cut = plane;
    if (!is_half) conditions.mirror = plane;
    problem.quantities = {area()};
    add_fields(problem.parameters, std::make_shared<const DisplacementFields>(mesh, conditions, FieldOptions{12, {}}));
    for (UserVariable& v : problem.parameters.user_variables) v.unit = 0.02;
    return problem;
}

}  // namespace

/// The same fields and tractions, by physical values: the half's surface is that of the whole, to 1e-10.
TEST(Fields, BesidePatchesHalfAndWholeModelsAgree) {
    const HalfAndWhole box = crooked_box(4);
    const auto half = rest_facts(box_problem(box.half, true)), whole = rest_facts(box_problem(box.whole, false));
    const DesignSpace of_half = design_space(half, 1), of_whole = design_space(whole, 1);
    ASSERT_EQ(of_half.size(), of_whole.size());
    Eigen::VectorXd x = 0.3 * random_vector(of_half.size(), 3), y = x;
    for (int j = 0; j < x.size(); ++j) {
        ASSERT_EQ(of_half.variables[j].name, of_whole.variables[j].name);
        y[j] = x[j] * of_half.variables[j].unit / of_whole.variables[j].unit;
    }
    const auto shape = [](const std::shared_ptr<const RestFacts>& rest, const DesignSpace& space,
                          const Eigen::VectorXd& at) {
        const ShellDemand wanted = demand(space, at);
        ShellOptions options = rest->setup.options;
        PrimoShell shell(rest->surface, options);
        EXPECT_EQ(shell.solve(wanted.loads).status, SolveStatus::converged);
        return with_fields(*rest, wanted, shell.vertices());
    };
    const Points a = shape(half, of_half, x), b = shape(whole, of_whole, y);
    double worst = 0, moved = 0;
    for (const int v :
         std::set<int>(box.half.triangles.data(), box.half.triangles.data() + box.half.triangles.size())) {
        Eigen::Index w = 0;
        ASSERT_LT((box.whole.vertices.rowwise() - box.half.vertices.row(v)).rowwise().norm().minCoeff(&w), 1e-12);
        worst = std::max(worst, (a.row(v) - b.row(w)).norm());
        moved = std::max(moved, (a.row(v) - box.half.vertices.row(v)).norm());
    }
    EXPECT_LT(worst, 1e-10 * whole->diagonal);
    EXPECT_GT(moved, 1e-3);
}

/// The same x gives the same shape in other units and with other numbers of vertices and triangles.
TEST(Fields, UnitsAndNumbersChangeNothing) {
    Problem first = ellipsoid_problem(2, 2);
    std::vector<int> vertex_order, triangle_order;
    Problem second = first;
    second.surface = renumbered(first.surface, 5, &vertex_order, &triangle_order);
    second.surface.vertices *= 1000;
    second.tree = octants(second.surface, 2);
    second.prism_height *= 1000;
    second.fixed.clear();
    const Points c = triangle_centroids(second.surface);
    for (int t = 0; t < second.surface.num_triangles(); ++t)
        if (c(t, 0) < -750) second.fixed.push_back(t);
    std::vector<Points> shapes;
    std::vector<double> diagonals;
    std::map<std::string, double> by_name;
    for (Problem* problem : {&first, &second}) {
        problem->parameters.kinds = {VariableKind::normal_load};
        problem->quantities = {volume(problem->surface), area()};
        FieldConditions conditions;
        conditions.held = problem->fixed;
        add_fields(problem->parameters,
                   std::make_shared<const DisplacementFields>(problem->surface, conditions, FieldOptions{12, {}}));
        Evaluated e(*problem, 1);
        Eigen::VectorXd x(e.space.size());
        for (int j = 0; j < x.size(); ++j) {
            const auto [at, fresh] = by_name.try_emplace(e.space.variables[static_cast<std::size_t>(j)].name, 0.0);
            if (fresh) at->second = 0.1 + 0.05 * j;
            x[j] = at->second;
        }
        shapes.push_back(e.at(x).vertices);
        diagonals.push_back(e.rest->diagonal);
    }
    for (int v = 0; v < first.surface.num_vertices(); ++v)
        EXPECT_LT((shapes[1].row(v) / 1000 - shapes[0].row(vertex_order[static_cast<std::size_t>(v)])).norm(),
                  1e-6 * diagonals[0]);
}

/// On what fields turn by 20 degrees loads move the surface by what they do at rest: E is not turned along. The shape
/// is a valid one.
TEST(Fields, TwistedByTwentyDegreesTakeLocalBumps) {
    Problem problem = ellipsoid_problem(3, 3);
    problem.parameters.kinds = {VariableKind::normal_load};
    FieldConditions conditions;
    conditions.held = problem.fixed;
    add_fields(problem.parameters,
               std::make_shared<const DisplacementFields>(problem.surface, conditions, FieldOptions{12, {}}));
    Evaluated e(problem, 3);
    // The rotation about x that grows from what is held to 20 degrees at the end, as far as the fields make it.
    const int n = problem.surface.num_vertices();
    Points twist(n, 3);
    constexpr double degree = 3.14159265358979 / 180;
    for (int v = 0; v < n; ++v) {
        const Eigen::Vector3d x = problem.surface.vertices.row(v);
        const double angle = 20 * degree * std::max(0.0, x[0] + 0.75) / 1.75;
        twist.row(v) = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()) * x - x;
    }
    Eigen::MatrixXd columns(3 * n, 12);
    for (int b = 0; b < 12; ++b) {
        const Points u = problem.parameters.fields->field(b);
        columns.col(b) = Eigen::VectorXd::Map(u.data(), u.size());
    }
    const Eigen::VectorXd z = columns.colPivHouseholderQr().solve(Eigen::VectorXd::Map(twist.data(), twist.size()));
    Eigen::VectorXd x = Eigen::VectorXd::Zero(e.space.size());
    int bump = -1;
    for (int j = 0; j < e.space.size(); ++j) {
        const Variable& variable = e.space.variables[static_cast<std::size_t>(j)];
        if (variable.kind == VariableKind::field)
            x[j] = z[problem.parameters.user_variables[static_cast<std::size_t>(variable.component)].field] /
                   variable.unit;
        else if (variable.name.find("p1.p1.p1") != std::string::npos)
            bump = j;
    }
    ASSERT_GE(bump, 0);
    const Points twisted = e.at(x).vertices;
    x[bump] = 0.6;
    const Points bumped = e.at(x).vertices;
    int top = 0;
    const Points own = bumped - twisted;
    own.rowwise().norm().maxCoeff(&top);
    EXPECT_GT(own.row(top).norm(), 0.01 * e.rest->diagonal);
    // The same vectors as on the body at rest.
    Eigen::VectorXd alone = Eigen::VectorXd::Zero(e.space.size());
    alone[bump] = x[bump];
    const Points at_rest = e.at(alone).vertices - problem.surface.vertices;
    EXPECT_LT((own - at_rest).cwiseAbs().maxCoeff(), 1e-9 * e.rest->diagonal);
}

/// One map of space moves both parts, but their triangles are flat: the cut goes on to other ones. That is no fault.
TEST(Fields, TheCutOfPartsThatPierceEachOtherMayWander) {
    Problem problem;
    problem.surface = defective::joined(ellipsoid({1, 0.6, 0.4}, 3),
                                        defective::moved(ellipsoid({0.5, 0.7, 0.3}, 3), {0.31, 0.23, 0.17}));
    problem.tree = octants(problem.surface, 1);
    problem.prism_height =
        Eigen::VectorXd::Constant(problem.surface.num_vertices(), 0.05 * box_diagonal(problem.surface));
    const Points c = triangle_centroids(problem.surface);
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        if (c(t, 0) < -0.1 && c(t, 2) < 0.1) problem.fixed.push_back(t);
    problem.quantities = {area()};
    problem.parameters.kinds = {VariableKind::normal_load};
    EXPECT_TRUE(sliding_triangles(problem).empty()) << "patches alone: each part moves by itself";
    FieldConditions conditions;
    conditions.held = problem.fixed;
    add_fields(problem.parameters,
               std::make_shared<const DisplacementFields>(problem.surface, conditions, FieldOptions{12, {}}));
    Evaluated e(problem, 0);
    int wandering = 0;
    const auto before = intersections(problem.surface).apart;
    for (int seed = 1; seed <= 8; ++seed) {
        const ShapeEvaluation moved = e.at(0.5 * random_vector(e.space.size(), seed));  // expects "ok"
        wandering += intersections(with_vertices(problem.surface, moved.vertices)).apart != before;
    }
    EXPECT_GT(wandering, 2) << "else nothing is shown";
}
