#include "optimize/check/capability.hpp"

#include "core/fields/typical_motions.hpp"
#include "core/planform/kept_sections.hpp"
#include "core/planform/planform_motion.hpp"
#include "optimize/check/border_turn.hpp"
#include "optimize/space/field_conditions.hpp"
#include "optimize/space/response_metric.hpp"
#include "optimize/space/rest_facts.hpp"
#include "problems.hpp"
#include "tests/core/planform/lofted_wing.hpp"

#include <gtest/gtest.h>

namespace strake::capability_tests {
namespace {

const MotionShare& share_of(const Capability& can, const std::string& name) {
    for (const MotionShare& motion : can.motions)
        if (motion.name == name) return motion;
    throw std::out_of_range(name);
}

Problem with_fields(int number, std::vector<VariableKind> kinds, bool is_smooth = false) {
    Problem problem = ellipsoid_problem(3, 3);
    problem.parameters.kinds = std::move(kinds);
    problem.parameters.keeps_smooth_border = is_smooth;
    if (number > 0)
        add_fields(problem.parameters, std::make_shared<const DisplacementFields>(
                                           problem.surface, field_conditions(problem), FieldOptions{number, {}}));
    return problem;
}

Capability asked(const Problem& problem) { return capability(rest_facts(problem), field_conditions(problem)); }

}  // namespace

TEST(Capability, FieldsMakeWhatAShellResists) {
    const Capability patches = asked(with_fields(0, {VariableKind::load})),
                     fields = asked(with_fields(36, {VariableKind::load}));
    EXPECT_EQ(patches.levels, (std::vector{1, 2, 3}));
    EXPECT_EQ(fields.levels, (std::vector{0, 1, 2, 3}));
    EXPECT_EQ(fields.variables[0], 36);
    for (const char* name : {"bend", "sweep", "span", "twist", "taper", "thicken", "swell", "flatten"}) {
        EXPECT_GT(share_of(fields, name).by_level[0], 0.97) << name;
        const MotionShare& of_patches = share_of(patches, name);
        for (std::size_t k = 1; k < of_patches.by_level.size(); ++k)
            EXPECT_GE(of_patches.by_level[k], of_patches.by_level[k - 1] - 1e-6) << "finer levels make no less";
    }
    const MotionShare& flatten = share_of(patches, "flatten");
    EXPECT_LT(flatten.by_level.back(), 0.9) << "membrane work";
    EXPECT_EQ(flatten.remedy, "parameters.fields: auto");
    EXPECT_GT(flatten.with_remedy, 0.95);
    EXPECT_TRUE(share_of(fields, "flatten").remedy.empty());
}

/// Where edges of a wing stay, fields make no change of its planform, whatever sections do between them along it;
/// changes of the wing do.
TEST(Capability, EdgesThatStayLeaveThePlanform) {
    Loft loft;
    loft.cells = 12;
    Problem problem;
    problem.surface = lofted(loft);
    problem.symmetry = SymmetryPlane{Eigen::Vector3d::UnitY(), 0};
    problem.has_shell = false;
    problem.tree = octants(problem.surface, 0);
    problem.parameters.kinds.clear();
    WingDeclaration declared;
    declared.symmetry = problem.symmetry;
    for (int t = 0; t < problem.surface.num_triangles(); ++t) {
        const bool is_root = problem.surface.vertices(problem.surface.triangles(t, 0), 1) < 0.5;
        (is_root ? problem.fixed : declared.triangles).push_back(t);
    }
    const auto wing = std::make_shared<const Wing>(problem.surface, declared);
    add_fields(problem.parameters, std::make_shared<const DisplacementFields>(
                                       problem.surface, field_conditions(problem), FieldOptions{36, {}}));
    const Capability free = asked(problem);
    problem.parameters.kept_sections =
        std::make_shared<const KeptSections>(problem.surface, std::vector{wing}, problem.fixed);
    const Capability kept = asked(problem);
    for (const char* name : {"bend", "sweep", "twist", "taper"}) {
        EXPECT_GT(share_of(free, name).by_level.back(), 0.8) << name;
        EXPECT_LT(share_of(kept, name).by_level.back(), 0.05) << name;
        EXPECT_EQ(share_of(kept, name).remedy, "") << name;
    }
    EXPECT_GT(share_of(kept, "thicken").by_level.back(), 0.2);
    const PlanformRange sweep{.change = PlanformChange::sweep, .lower = -0.1, .upper = 0.1};
    add_planform(problem.parameters,
                 std::make_shared<const PlanformMotion>(problem.surface, std::vector{wing}, std::vector{sweep}));
    EXPECT_GT(share_of(asked(problem), "sweep").by_level.back(), 0.8);
}

TEST(Capability, LoadsMakeTheSoftestModes) {
    const Capability can = asked(with_fields(0, {VariableKind::load}));
    EXPECT_GT(share_of(can, "soft mode 1").by_level.back(), 0.9);
    const Capability alone = asked(with_fields(6, {}));
    EXPECT_LT(share_of(alone, "bump").by_level.back(), 0.5) << "six fields";
    EXPECT_FALSE(share_of(alone, "bump").remedy.empty());
    EXPECT_GT(share_of(alone, "bump").with_remedy, share_of(alone, "bump").by_level.back());
}

TEST(Capability, SharesAreThoseOfLeastSquares) {
    Eigen::MatrixXd columns(4, 3);
    columns << 1, 0, 2, 0, 1e-6, 0, 0, 0, 0, 0, 0, 0;  // the third depends on the first, the second is small
    EXPECT_NEAR(share_made(columns, Eigen::Vector4d(3, 4, 0, 0)), 1, 1e-12);
    EXPECT_NEAR(share_made(columns, Eigen::Vector4d(3, 0, 4, 0)), 9.0 / 25, 1e-12);
    EXPECT_EQ(share_made(columns, Eigen::Vector4d(0, 0, 0, 1)), 0);
    EXPECT_EQ(share_made({}, Eigen::Vector4d(1, 0, 0, 0)), 0);
}

TEST(Capability, MotionsThatThePlaneForbidsAreNotAsked) {
    const TriMesh mesh = ellipsoid({3, 1, 0.6}, 3);
    FieldConditions conditions;
    conditions.mirror = SymmetryPlane{Eigen::Vector3d::UnitY(), 0};
    std::vector<std::string> names;
    for (const TypicalMotion& motion : typical_motions(mesh, conditions)) {
        names.push_back(motion.name);
        EXPECT_NEAR(motion.displacement.rowwise().norm().maxCoeff(), 1, 1e-12);
        for (int v = 0; v < mesh.num_vertices(); ++v)
            if (std::abs(mesh.vertices(v, 1)) < 1e-12) {
                EXPECT_NEAR(motion.displacement(v, 1), 0, 1e-9) << motion.name;
            }
    }
    EXPECT_EQ(std::count(names.begin(), names.end(), "twist"), 0);
    EXPECT_EQ(std::count(names.begin(), names.end(), "sweep"), 0);
    EXPECT_EQ(std::count(names.begin(), names.end(), "taper"), 1);
}

/// A move of 10 % of the diagonal, the border of a fine mesh: steeper than 2 degrees with a ramp, below with its
/// square.
TEST(Capability, TheTurnAtTheBorderIsToldAndASmoothOneIsSmall) {
    for (const bool is_smooth : {false, true}) {
        Problem problem = with_fields(0, {}, is_smooth);
        problem.surface = ellipsoid({1, 0.6, 0.4}, 5);
        problem.fixed.clear();
        const Points c = triangle_centroids(problem.surface);
        for (int t = 0; t < problem.surface.num_triangles(); ++t)
            if (c(t, 0) < -0.75) problem.fixed.push_back(t);
        problem.tree = octants(problem.surface, 1);
        problem.prism_height = Eigen::VectorXd::Constant(problem.surface.num_vertices(), 0.1);
        problem.quantities = {area()};
        const DisplacementFields fields(problem.surface, field_conditions(problem), {27, {}});
        add_fields(problem.parameters, std::make_shared<const DisplacementFields>(fields));
        const auto rest = rest_facts(problem);
        double most = 0;
        for (int b = 0; b < 12; ++b)
            most = std::max(
                most, border_turn(*rest, rest->adjacent, pinned_triangles(*rest), fields.field(b), 0.1 * rest->diagonal)
                          .degrees);
        if (is_smooth) {
            EXPECT_LT(most, 2);
        } else {
            EXPECT_GT(most, 2);
        }
    }
}

}  // namespace strake::capability_tests
