#include "optimize/problem/shell_setup.hpp"

#include "core/error.hpp"
#include "core/fields/invariance.hpp"
#include "core/mesh/geometry.hpp"
#include "core/wrap/wrap_map.hpp"
#include "optimize/problem/place_user_variables.hpp"

#include <algorithm>

namespace strake {
namespace {

constexpr double same_motion = 1e-9;  ///< of a displacement: round-off

/// Of the vertices of the triangles; zero elsewhere.
Points rigid_displacement(const TriMesh& mesh, const std::vector<int>& triangles, const RigidMotion& motion) {
    Points moved = Points::Zero(mesh.num_vertices(), 3);
    const double angle = motion.rotation.norm();
    const Eigen::Matrix3d turn =
        angle > 0 ? Eigen::AngleAxisd(angle, motion.rotation / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
    for (const int t : triangles)
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector3d arm = Eigen::Vector3d(mesh.vertices.row(mesh.triangles(t, k))) - motion.about;
            moved.row(mesh.triangles(t, k)) = turn * arm - arm + motion.translation;
        }
    return moved;
}

void check_index(const char* what, int t, int num_triangles) {
    if (t < 0 || t >= num_triangles)
        throw InvalidInput(text(what, ": triangle ", t, " must be in [0, ", num_triangles, ")"));
}

void check_sizes(const Problem& problem) {
    const TriMesh& elastic = elastic_surface(problem);
    const int n = elastic.num_vertices(), m = elastic.num_triangles();
    if (problem.has_shell && problem.prism_height.size() != n)
        throw InvalidInput(text("prism_height: ", problem.prism_height.size(), " values for ", n, " vertices"));
    if (problem.given_traction.rows() != 0 && problem.given_traction.rows() != m)
        throw InvalidInput(text("given_traction: ", problem.given_traction.rows(), " rows for ", m, " triangles"));
    if (problem.spring_per_area.size() != 0 && problem.spring_per_area.size() != m)
        throw InvalidInput(text("spring_per_area: ", problem.spring_per_area.size(), " values for ", m, " triangles"));
}

/// What a wrap cannot do.
void check_wrap(const Problem& problem) {
    if (!problem.wrap) return;
    const auto refuse = [](const std::string& what) { throw InvalidInput("wrap: not possible together with " + what); };
    if (!problem.has_shell) refuse("shell: none, where nothing is elastic");
    if (!problem.attached.empty()) refuse("attach: the wrap carries all parts of the body");
    if (problem.parameters.invariance) refuse("invariance");
    const auto count = static_cast<int>(problem.wrap->held().size());
    if (count != problem.surface.num_vertices())
        throw InvalidInput(text("wrap: around ", count, " vertices, the surface has ", problem.surface.num_vertices()));
    for (const int t : problem.fixed)
        for (int k = 0; k < 3; ++k)
            if (const int v = problem.surface.triangles(t, k); !problem.wrap->held()[static_cast<std::size_t>(v)])
                throw InvalidInput(text("wrap: vertex ", v, " is fixed, but not held by the wrap's binding"));
}

/// What needs a shell, in a problem that has none.
void refuse_elastic(const Problem& problem) {
    const auto refuse = [](const std::string& what) {
        throw InvalidInput(what + ": needs an elastic shell, and the problem has none");
    };
    if (!problem.parameters.fields && !problem.parameters.planform)
        throw InvalidInput(
            "the problem has no elastic shell, and no displacement fields or changes of wings that would move the "
            "surface");
    if (!problem.strains.empty()) refuse("strains");
    if (!problem.attached.empty()) refuse("attach");
    if (problem.given_traction.rows() > 0) refuse("given_traction");
    if (problem.spring_per_area.size() > 0) refuse("spring_per_area");
    if (!problem.parameters.kinds.empty()) refuse("parameters.kinds");
    for (const UserVariable& v : problem.parameters.user_variables)
        if (v.field < 0 && v.planform < 0) refuse("variable " + v.name);
}

void pin_strain(const Problem& problem, int k, ShellSetup& setup) {
    int fixed = 0, pinned = 0;
    for (const int t : problem.strains[k].triangles) {
        check_index("strains", t, static_cast<int>(setup.options.pin.size()));
        int& pin = setup.options.pin[t];
        if (pin == fixed_prism)
            ++fixed;
        else if (pin > 0 && pin != k + 1)
            throw InvalidInput(text("strains: triangle ", t, " lies in strains ", pin, " and ", k + 1,
                                    "; a triangle can follow one motion only"));
        else
            pin = k + 1, ++pinned;
    }
    if (pinned == 0)
        throw InvalidInput(text("strains: strain ", k + 1, " has no triangle that is not fixed (", fixed, " are)"));
    if (fixed > 0)
        setup.warnings.push_back(
            text("strain ", k + 1, ": ", fixed, " of its triangles are fixed as well and stay fixed"));
}

/// Rigid patches and parts that follow others would leave the kind of shape, or what was asked of them.
void check_invariance(const Problem& problem, const ShellSetup& setup) {
    const auto& invariance = problem.parameters.invariance;
    if (!invariance) return;
    if (invariance->num_vertices() != problem.surface.num_vertices())
        throw InvalidInput(text("invariance: of ", invariance->num_vertices(), " vertices for a surface of ",
                                problem.surface.num_vertices()));
    if (!problem.attached.empty())
        throw InvalidInput("invariance: attached parts follow their hosts and keep no kind of shape; remove attach");
    if (std::ranges::count(problem.parameters.kinds, VariableKind::strain) > 0)
        throw InvalidInput(
            "invariance: strain variables move patches as rigid bodies, which no extruded, revolved or cyclic shape "
            "does; use fields, load or normal");
    invariance->check_held(problem.surface, problem.fixed);
    for (std::size_t k = 0; k < setup.motions.size(); ++k) {
        if (setup.motions[k].rotation.isZero(0) && setup.motions[k].translation.isZero(0)) continue;
        std::vector<int> moved;
        for (std::size_t t = 0; t < setup.options.pin.size(); ++t)
            if (setup.options.pin[t] == static_cast<int>(k) + 1) moved.push_back(static_cast<int>(t));
        invariance->check_held(problem.surface, moved);
        const Points u = rigid_displacement(problem.surface, moved, setup.motions[k]);
        const double off = invariance->deviation(u), size = u.rowwise().norm().maxCoeff();
        if (off > same_motion * size)
            throw InvalidInput(text("invariance: strain ", k + 1, " does not keep the shape ",
                                    to_string(invariance->kind()), ": ", off, " of its displacement ", size,
                                    " would have to be left out"));
    }
}

/// What is attached moves with its host and cannot be held or moved by anything else.
void check_attached(ShellSetup& setup) {
    if (!setup.options.attached) return;
    const std::vector<int>& part = setup.options.attached->part_of();
    for (std::size_t t = 0; t < part.size(); ++t) {
        if (part[t] < 0) continue;
        if (setup.options.pin[t] != free_prism)
            throw InvalidInput(text("attach: triangle ", t, " is attached and also ",
                                    setup.options.pin[t] == fixed_prism ? "fixed" : "moved by a strain or variable"));
        setup.options.pin[t] = fixed_prism;  // no unknown, and in no core of strain variables
    }
}

}  // namespace

const TriMesh& elastic_surface(const Problem& problem) { return problem.wrap ? problem.wrap->mesh() : problem.surface; }

Eigen::VectorXd vertex_springs(const TriMesh& rest, const Eigen::VectorXd& spring_per_area) {
    if (spring_per_area.size() == 0) return {};
    const Eigen::VectorXd area = triangle_areas(rest);
    Eigen::VectorXd spring = Eigen::VectorXd::Zero(rest.num_vertices());
    for (int t = 0; t < rest.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) spring[rest.triangles(t, k)] += spring_per_area[t] * area[t] / 3;
    return spring;
}

std::vector<int> attached_triangles(const Problem& problem) {
    std::vector<int> all;
    for (const AttachedPart& part : problem.attached)
        all.insert(all.end(), part.triangles.begin(), part.triangles.end());
    return all;
}

ShellSetup shell_setup(const Problem& problem) {
    check_sizes(problem);
    if (!problem.has_shell) refuse_elastic(problem);
    for (const int t : problem.fixed) check_index("fixed", t, problem.surface.num_triangles());
    check_wrap(problem);
    const TriMesh& elastic = elastic_surface(problem);
    ShellSetup setup;
    setup.options.prism_height = problem.prism_height;
    setup.options.symmetry = problem.symmetry;
    setup.options.couple_nonmanifold = problem.couple_nonmanifold;
    setup.options.solver = problem.solver;
    setup.options.pin.assign(static_cast<std::size_t>(elastic.num_triangles()), free_prism);
    if (!problem.attached.empty())
        setup.options.attached =
            std::make_shared<const Attachments>(problem.surface, problem.attached, problem.symmetry);
    if (!problem.wrap)  // else what holds the wrap are `supports`
        for (const int t : problem.fixed) setup.options.pin[t] = fixed_prism;
    for (const int t : problem.supports) {
        check_index("supports", t, elastic.num_triangles());
        setup.options.pin[t] = fixed_prism;
    }
    for (int k = 0; k < static_cast<int>(problem.strains.size()); ++k) {
        pin_strain(problem, k, setup);
        setup.motions.push_back(problem.strains[k].motion);
    }
    PlacedVariables placed = place_user_variables(problem, static_cast<int>(setup.motions.size()), setup.options.pin);
    setup.motions.insert(setup.motions.end(), placed.motions.begin(), placed.motions.end());
    setup.user_motion = std::move(placed.motion);
    setup.user_pinned = std::move(placed.pinned);
    setup.warnings.insert(setup.warnings.end(), placed.warnings.begin(), placed.warnings.end());
    check_attached(setup);
    check_invariance(problem, setup);
    if (problem.given_traction.rows() > 0) setup.loads.force = traction_forces(elastic, problem.given_traction);
    if (problem.parameters.invariance && setup.loads.force.rows() > 0)
        setup.loads.force = problem.parameters.invariance->pulled_back(setup.loads.force);
    setup.loads.spring = vertex_springs(elastic, problem.spring_per_area);
    return setup;
}

}  // namespace strake
