#include "optimize/run/mixed_design.hpp"

#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/planform/kept_sections.hpp"
#include "core/planform/planform_motion.hpp"
#include "optimize/evaluate/limited_motion.hpp"
#include "optimize/evaluate/shape_solver.hpp"
#include "optimize/problem/shell_setup.hpp"
#include "optimize/space/shape_map.hpp"

namespace strake {
namespace {

struct Demand {
    std::shared_ptr<const RestFacts> rest;
    std::vector<int> pin;
    ShellDemand of_shell;
};

Demand demand_of(const DesignOfRun& one) {
    check_surface(*one.design, one.problem.surface);
    Problem problem = one.problem;
    start_from(problem, one.design);
    Demand out;
    out.rest = rest_facts(problem);
    const StartSpace start = start_space(out.rest, *one.design);
    out.pin = out.rest->setup.options.pin;
    for (std::size_t p = 0; p < start.space.core.size(); ++p)
        for (const int t : start.space.core[p]) out.pin[static_cast<std::size_t>(t)] = start.space.motion[p] + 1;
    out.of_shell = demand(start.space, start.x);
    return out;
}

bool same_plane(const std::optional<SymmetryPlane>& a, const std::optional<SymmetryPlane>& b) {
    if (!a || !b) return !a && !b;
    return a->normal == b->normal && a->offset == b->offset;
}

/// By what they do to the surface, all at once: any difference between them shows.
bool same_fields(const RestFacts& a, const RestFacts& b) {
    const DisplacementFields *one = a.parameters.fields.get(), *other = b.parameters.fields.get();
    if (!one || !other || one == other) return one == other;
    if (one->size() != other->size()) return false;
    Eigen::VectorXd z(one->size());
    for (Eigen::Index k = 0; k < z.size(); ++k) z[k] = 1 + 0.5 * std::sin(static_cast<double>(k + 1));
    constexpr double rounding = 1e-9;  // of the sum, whose terms are of size 1
    return (one->displacement(z) - other->displacement(z)).cwiseAbs().maxCoeff() <=
           rounding * static_cast<double>(z.size());
}

bool same_planform(const RestFacts& a, const RestFacts& b) {
    const PlanformMotion *one = a.parameters.planform.get(), *other = b.parameters.planform.get();
    if (!one || !other || one == other) return one == other;
    if (one->size() != other->size()) return false;
    Eigen::VectorXd z(one->size());
    for (int j = 0; j < one->size(); ++j) {
        const PlanformMotion::Variable& v = one->variables()[static_cast<std::size_t>(j)];
        if (v.name != other->variables()[static_cast<std::size_t>(j)].name) return false;
        z[j] = v.upper > 0 ? v.upper : v.lower;
    }
    return one->displacement(z) == other->displacement(z);
}

/// By what is left of the triangles' normals at the vertices: any difference shows.
bool same_kept_sections(const RestFacts& a, const RestFacts& b) {
    const KeptSections *one = a.parameters.kept_sections.get(), *other = b.parameters.kept_sections.get();
    if (!one || !other || one == other) return one == other;
    Points motion = Points::Zero(a.surface.num_vertices(), 3);
    for (int t = 0; t < a.surface.num_triangles(); ++t)
        for (const int v : a.surface.triangles.row(t)) motion.row(v) += a.normal.row(t);
    return one->num_knots() == other->num_knots() && one->rate(nullptr, motion) == other->rate(nullptr, motion);
}

/// What two designs must share to be mixed.
void check_alike(const Demand& a, const Demand& b) {
    const auto refuse = [](const std::string& what) {
        throw InvalidInput("mix: the two designs have " + what + ", and no equilibrium lies between them");
    };
    const TriMesh &one = a.rest->surface, &other = b.rest->surface;
    const bool same_counts = one.num_vertices() == other.num_vertices() && one.num_triangles() == other.num_triangles();
    if (!same_counts || one.triangles != other.triangles || one.vertices != other.vertices)
        refuse("different surfaces at the start");
    const TriMesh &one_wrap = a.rest->elastic(), &other_wrap = b.rest->elastic();
    if (!a.rest->wrap != !b.rest->wrap || one_wrap.vertices.rows() != other_wrap.vertices.rows() ||
        one_wrap.vertices != other_wrap.vertices)
        refuse("different wraps");
    if (a.rest->has_shell != b.rest->has_shell) refuse("a shell in one of them only");
    if (a.pin != b.pin) refuse("different fixed or strained triangles");
    if (!same_plane(a.rest->setup.options.symmetry, b.rest->setup.options.symmetry)) refuse("different symmetry");
    if (a.rest->setup.options.couple_nonmanifold != b.rest->setup.options.couple_nonmanifold)
        refuse("different rules for edges of more than two triangles");
    const Eigen::VectorXd &s = a.of_shell.loads.spring, &t = b.of_shell.loads.spring;
    if (s.size() != t.size() || s != t) refuse("different springs");
    const auto names = [](const Demand& demand) {
        std::vector<std::string> all;
        for (const UserVariable& v : demand.rest->parameters.user_variables)
            if (v.field >= 0) all.push_back(v.name);
        return all;
    };
    if (!same_planform(*a.rest, *b.rest)) refuse("different changes of wings (parameters.planform)");
    if (!same_kept_sections(*a.rest, *b.rest)) refuse("wings whose edges stay in one of them only (planform: keep)");
    if (names(a) != names(b)) refuse("different displacement fields");
    if (!same_fields(*a.rest, *b.rest))
        refuse(
            "displacement fields of the same names that do different things (parameters.fields: on, axis; fixed; "
            "keep; hold)");
    if (a.of_shell.motions.size() != b.of_shell.motions.size()) refuse("different motions");
    for (std::size_t k = 0; k < a.of_shell.motions.size(); ++k)
        if (a.of_shell.motions[k].about != b.of_shell.motions[k].about) refuse("motions about different points");
}

ShellDemand between(const ShellDemand& a, const ShellDemand& b, double w) {
    ShellDemand out = a;
    if (a.loads.force.rows() == 0)
        out.loads.force = w * b.loads.force;
    else if (b.loads.force.rows() == 0)
        out.loads.force = (1 - w) * a.loads.force;
    else
        out.loads.force = (1 - w) * a.loads.force + w * b.loads.force;
    for (std::size_t k = 0; k < out.motions.size(); ++k) {
        out.motions[k].rotation = (1 - w) * a.motions[k].rotation + w * b.motions[k].rotation;
        out.motions[k].translation = (1 - w) * a.motions[k].translation + w * b.motions[k].translation;
    }
    if (out.planform.size() > 0) out.planform = (1 - w) * a.planform + w * b.planform;
    if (out.fields.size() > 0) out.fields = (1 - w) * a.fields + w * b.fields;
    if (out.prism_height.size() > 0)
        out.prism_height = ((1 - w) * a.prism_height.array().log() + w * b.prism_height.array().log()).exp();
    return out;
}

}  // namespace

MixedDesign mixed_design(const DesignOfRun& a, const DesignOfRun& b, double weight) {
    if (!std::isfinite(weight)) throw InvalidInput(text("mix: weight = ", weight, " must be finite"));
    const Demand one = demand_of(a), other = demand_of(b);
    check_alike(one, other);
    const ShellDemand wanted = between(one.of_shell, other.of_shell, weight);
    MixedDesign out;
    std::optional<PrimoShell> shell;
    if (one.rest->has_shell) {
        ShellOptions options = one.rest->setup.options;
        options.pin = one.pin;
        options.prism_height = wanted.prism_height;
        shell.emplace(one.rest->elastic(), options);
        shell->set_poses(weight < 0.5 ? a.design->poses : b.design->poses);
        out.end = shell->solve(wanted.loads, wanted.motions);
        out.vertices = with_fields(*one.rest, wanted, shell->vertices());
    } else {
        out.end.status = SolveStatus::converged;
        out.end.reason = "by displacement fields";
        out.vertices = with_fields(*one.rest, wanted, one.rest->surface.vertices);
    }
    if (out.end.status != SolveStatus::converged) return out;
    out.defect = defect_of(guard_of(a.problem, one.rest), *one.rest, wanted, out.vertices, shell ? &*shell : nullptr);
    std::optional<Poses> of_datum;
    const MotionLimit limit = motion_limit(a.problem, one.rest, {}, of_datum);
    if (!limit.is_none()) out.beyond = limit.excess(beside_planform(*one.rest, wanted, out.vertices));
    return out;
}

}  // namespace strake
