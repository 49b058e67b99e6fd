#include "cases/geometry/wing.hpp"
#include "core/patches/automatic.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>

/// Strains pin the cores of patches and leave skin between them, over which neighbours that move differently go over
/// into each other without a crease along their border.
namespace strake {
namespace {

Problem wing_problem(double core) {
    Problem problem;
    problem.surface = example::wing(4000);
    problem.tree = segment_automatically(problem.surface, adjacency(problem.surface), {});
    problem.prism_height =
        Eigen::VectorXd::Constant(problem.surface.num_vertices(), 0.02 * box_diagonal(problem.surface));
    const Points c = triangle_centroids(problem.surface);
    for (int t = 0; t < problem.surface.num_triangles(); ++t)
        if (c(t, 1) < 0.05) problem.fixed.push_back(t);
    problem.parameters.kinds = {VariableKind::strain};
    problem.parameters.free_border = core;
    problem.quantities = {area()};
    return problem;
}

struct Raised {
    double at_borders = 0, anywhere = 0;  ///< largest rise of a dihedral, degrees
    int edges = 0;
    std::string refused;
    double moved = 0;
};

class Strained {
public:
    explicit Strained(const Problem& problem)
        : problem_(problem),
          rest_(rest_facts(problem_)),
          evaluator_(problem_, rest_, {}),
          space_(design_space(rest_, 2)) {
        evaluator_.enter(space_);
    }
    const DesignSpace& space() const { return space_; }
    const TriMesh& surface() const { return problem_.surface; }
    Raised at(const Eigen::VectorXd& x) {
        Raised raised;
        const ShapeEvaluation e = evaluator_.evaluate(x, 1);
        raised.refused = e.reason;
        if (e.status != EvaluationStatus::ok) return raised;
        raised.moved = e.max_displacement / rest_->diagonal;
        const Points after = triangle_normals(with_vertices(problem_.surface, e.vertices));
        const PatchLevel& patches = space_.patches();
        for (int k = 0; k < rest_->adjacent.num_edges(); ++k) {
            if (!rest_->adjacent.is_regular(k)) continue;
            const int s = rest_->adjacent.edge_triangles[k][0], t = rest_->adjacent.edge_triangles[k][1];
            const double rise =
                180 / M_PI *
                (dihedral(after.row(s), after.row(t)) - dihedral(rest_->normal.row(s), rest_->normal.row(t)));
            raised.anywhere = std::max(raised.anywhere, rise);
            if (patches.label[s] == patches.label[t]) continue;
            ++raised.edges;
            raised.at_borders = std::max(raised.at_borders, rise);
        }
        return raised;
    }

private:
    Problem problem_;
    std::shared_ptr<const RestFacts> rest_;
    ShapeEvaluator evaluator_;
    DesignSpace space_;
};

using V3 = Eigen::Vector3d;
using Field = std::function<V3(const V3& p)>;  ///< displacement

/// Every patch follows the rigid motion that the field is at its core: its value, and half its curl.
Eigen::VectorXd rigid_motions(const DesignSpace& space, const Field& field) {
    Eigen::VectorXd x(space.size());
    const double h = 1e-4;
    for (int j = 0; j < space.size(); ++j) {
        const Variable& variable = space.variables[j];
        const V3 at = space.carried_motion[variable.patch].about;
        Eigen::Matrix3d D;  // D(c, i) = du_c / dx_i
        for (int i = 0; i < 3; ++i) D.col(i) = (field(at + h * V3::Unit(i)) - field(at - h * V3::Unit(i))) / (2 * h);
        const V3 turn = 0.5 * V3(D(2, 1) - D(1, 2), D(0, 2) - D(2, 0), D(1, 0) - D(0, 1));
        const int c = variable.component;
        x[j] = (c < 3 ? turn[c] : field(at)[c - 3]) / variable.unit;
    }
    return x;
}

/// Scaled so that no vertex moves by more than `share` of the diagonal.
Field scaled(const TriMesh& mesh, const Field& field, double share) {
    double most = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) most = std::max(most, field(mesh.vertices.row(v)).norm());
    const double factor = share * box_diagonal(mesh) / most;
    return [=](const V3& p) { return V3(factor * field(p)); };
}

/// Neighbours move differently, as in a design: every patch by what a bend, a twist, a sweep or a change of camber of
/// the wing by 5 % of the diagonal does to its core.
const std::vector<std::pair<const char*, Field>>& fields() {
    static const std::vector<std::pair<const char*, Field>> all{
        {"bend", [](const V3& p) { return V3(0, 0, p.y() * p.y()); }},
        {"twist", [](const V3& p) { return V3(p.y() * V3(p.z(), 0, 0.5 * (0.3 - p.x()))); }},
        {"sweep", [](const V3& p) { return V3(p.y() * p.y(), 0, 0); }},
        {"camber", [](const V3& p) { return V3(0, 0, p.y() * std::cos(5 * p.x())); }}};
    return all;
}

Raised raised_by(Strained& strained, const Field& field) {
    return strained.at(rigid_motions(strained.space(), scaled(strained.surface(), field, 0.05)));
}

TEST(StrainBorders, FivePercentRaiseNoCreaseWhereCoresLeaveSkin) {
    Strained strained(wing_problem(0.4));
    ASSERT_EQ(strained.space().size(), 16 * 6);
    for (const auto& [name, field] : fields()) {
        SCOPED_TRACE(name);
        const Raised raised = raised_by(strained, field);
        ASSERT_EQ(raised.refused, "");
        EXPECT_GT(raised.edges, 100);
        EXPECT_NEAR(raised.moved, 0.05, 0.01);
        EXPECT_LT(raised.at_borders, 5);
    }
}

/// A whole wave along the span turns neighbours by half a radian against each other, in opposite senses: more than the
/// skin between them takes without a crease, which stays moderate.
TEST(StrainBorders, AnSBendRaisesMoreThanFiveDegrees) {
    Strained strained(wing_problem(0.4));
    const Raised raised =
        raised_by(strained, [](const V3& p) { return V3(0, 0, std::sin(2 * std::numbers::pi * p.y())); });
    ASSERT_EQ(raised.refused, "");
    EXPECT_GT(raised.at_borders, 5);
    EXPECT_LT(raised.at_borders, 13);
}

TEST(StrainBorders, PatchesPinnedToTheirBordersDoRaiseThem) {
    Strained strained(wing_problem(0.02));
    for (const auto& [name, field] : fields()) EXPECT_GT(raised_by(strained, field).at_borders, 5) << name;
}

}  // namespace
}  // namespace strake
