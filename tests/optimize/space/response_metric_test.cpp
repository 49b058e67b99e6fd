#include "optimize/space/response_metric.hpp"

#include "core/fields/displacement_fields.hpp"
#include "core/mesh/cotangents.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/space/rest_shell.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

using namespace strake;

namespace {

/// One variable that loads these patches along their normals, with the name that such a group gets.
Variable group_of(const DesignSpace& space, const std::vector<int>& patches) {
    Variable variable;
    const auto& all = space.patches().patches;
    variable.name = all[patches[0]].name + "+" + all[patches[1]].name + "+" + std::to_string(patches.size() - 2) +
                    "more.load_normal";
    variable.kind = VariableKind::normal_load;
    variable.patch = patches[0];
    for (const int p : patches) variable.moves.push_back({p * patch_dof::count + patch_dof::normal, 1.0});
    return variable;
}

Responses responses_of(DesignSpace space, const std::vector<int>& patches) {
    space.variables = {group_of(space, patches)};
    return responses_at_rest(space);
}

}  // namespace

/// Two groups of four patches share their first two members and their name, but not the others.
TEST(ResponseMetric, AGroupWithOtherMembersHasItsOwnResponse) {
    Problem problem = ellipsoid_problem(2, 3);
    problem.parameters.kinds = {VariableKind::normal_load};
    const auto rest = rest_facts(problem), other = rest_facts(problem);
    const DesignSpace space = design_space(rest, 3), untouched = design_space(other, 3);
    const std::vector<int> first{0, 1, 2, 3}, second{0, 1, 4, 7};
    ASSERT_EQ(group_of(space, first).name, group_of(space, second).name);
    const Responses of_first = responses_of(space, first), of_second = responses_of(space, second);
    const Responses alone = responses_of(untouched, second);
    EXPECT_EQ(of_second.largest[0], alone.largest[0]);
    EXPECT_EQ(of_second.samples, alone.samples);
    EXPECT_GT((of_second.samples - of_first.samples).norm(), 1e-3 * of_first.samples.norm());
}

namespace {

/// Fields beside loads, of a body in this unit.
DesignSpace fields_beside_loads(double unit, double energy_share = 1) {
    Problem problem = ellipsoid_problem(3, 2, unit);
    FieldConditions conditions;
    conditions.held = problem.fixed;
    add_fields(problem.parameters,
               std::make_shared<const DisplacementFields>(problem.surface, conditions, FieldOptions{27, {}}));
    problem.parameters.field_steps = {27};
    problem.parameters.kinds = {VariableKind::normal_load};
    return design_space(rest_facts(problem, energy_share), 1);
}

}  // namespace

/// What is left out is of loads alone: their energies. At rest the present metric agrees.
TEST(ResponseMetric, OfElasticEnergiesAShareCounts) {
    constexpr double share = 0.01;
    const DesignSpace whole = fields_beside_loads(1), part = fields_beside_loads(1, share);
    const int fields = 27, loads = whole.size() - fields;
    ASSERT_EQ(whole.variables[fields].kind, VariableKind::normal_load);
    const Eigen::MatrixXd& all = whole.metric;
    const Eigen::MatrixXd not_counted = all - part.metric;
    EXPECT_LT(not_counted.leftCols(fields).cwiseAbs().maxCoeff(), 1e-9 * all.diagonal().maxCoeff());
    // Energies are measured by the soft one of them, whose own is 1.
    const Eigen::VectorXd energies = not_counted.bottomRightCorner(loads, loads).diagonal() / (1 - share);
    EXPECT_NEAR(energies.minCoeff(), 1, 1e-6);
    const std::unique_ptr<PrimoShell> shell = shell_at_rest(part);
    const Eigen::VectorXd d = Eigen::VectorXd::Unit(part.size(), fields) + Eigen::VectorXd::Unit(part.size(), 3);
    const Eigen::VectorXd wanted = part.metric * d;
    EXPECT_LT((present_product(part, shell.get(), d) - wanted).norm(), 1e-5 * wanted.norm());
    EXPECT_GT((whole.metric * d - wanted).norm(), 0.1 * wanted.norm()) << "the share is seen";
}

/// That of a field is the mean square of the Laplacian of what it moves; those of loads stand beside it, and finer
/// fields are rougher.
TEST(ResponseMetric, RoughnessIsTheMeanSquareLaplacian) {
    const DesignSpace space = fields_beside_loads(1);
    const Eigen::MatrixXd rough = roughness(space);
    const TriMesh& surface = space.rest->surface;
    const Eigen::VectorXd area = vertex_areas(surface);
    double least = 1e300, most = 0;
    int fields = 0;
    for (int j = 0; j < space.size(); ++j) {
        EXPECT_GT(rough(j, j), 0) << space.variables[j].name;
        if (space.variables[j].kind != VariableKind::field) continue;
        ++fields;
        const int b = space.rest->parameters.user_variables[space.variables[j].component].field;
        const Points moved = space.variables[j].unit * space.rest->parameters.fields->field(b);
        const Points integrals = cotangent_matrix(surface) * moved;
        double sum = 0, squares = 0;
        for (int v = 0; v < surface.num_vertices(); ++v) {
            sum += integrals.row(v).squaredNorm() / area[v];
            squares += area[v] * moved.row(v).squaredNorm();
        }
        EXPECT_NEAR(rough(j, j), sum / area.sum(), 1e-9 * rough(j, j)) << space.variables[j].name;
        least = std::min(least, sum / squares), most = std::max(most, sum / squares);
    }
    EXPECT_EQ(fields, 27);
    EXPECT_LT(fields, space.size());
    EXPECT_GT(most, 10 * least) << "else it says nothing that the metric does not";
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> of(rough);
    EXPECT_GT(of.eigenvalues().minCoeff(), -1e-12 * of.eigenvalues().maxCoeff());
}

/// Motions go with the size of the body, their Laplacians against it.
TEST(ResponseMetric, RoughnessIsInOneOverLengthSquared) {
    const Eigen::MatrixXd one = roughness(fields_beside_loads(1)), other = roughness(fields_beside_loads(1000));
    EXPECT_LT((1e6 * other - one).norm(), 1e-6 * one.norm());
}
