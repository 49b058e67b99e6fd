#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/design_space.hpp"
#include "optimize/strain_core.hpp"

#include <numbers>

/// How the space of a level is made: which variables, their units, and what is inherited.
namespace strake {
namespace {

constexpr double negligible = 1e-9;  ///< of the largest response of the same kind: moves nothing

bool wants(const DesignSpace& space, VariableKind kind) {
    const auto& kinds = space.rest->parameters.kinds;
    return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

bool takes_part(const RestFacts& rest, const Patch& patch) {
    if (rest.parameters.on.empty()) return true;
    for (const int t : patch.triangles)
        if (rest.parameters.on[t]) return true;
    return false;
}

/// Cores of the first level: its own. Of a finer one: the child's part of its parent's core.
void place_cores(DesignSpace& space, const DesignSpace* parent) {
    const RestFacts& rest = *space.rest;
    const auto& patches = space.patches().patches;
    space.pin = rest.setup.options.pin;
    space.core.assign(patches.size(), {});
    space.motion.assign(patches.size(), -1);
    space.carried_motion.assign(patches.size(), {});
    if (!wants(space, VariableKind::strain)) return;
    if (!parent) {
        space.core = strain_cores(rest.surface, rest.adjacent, space.patches(), space.pin,
                                  rest.setup.options.symmetry.has_value());
        for (std::size_t p = 0; p < patches.size(); ++p)
            if (!takes_part(rest, patches[p])) space.core[p].clear();
    } else {
        std::vector<char> in_core(rest.surface.num_triangles(), 0);
        for (const auto& core : parent->core)
            for (const int t : core) in_core[t] = 1;
        for (std::size_t p = 0; p < patches.size(); ++p)
            for (const int t : patches[p].triangles)
                if (in_core[t]) space.core[p].push_back(t);
    }
    int next = static_cast<int>(rest.setup.motions.size());
    for (std::size_t p = 0; p < patches.size(); ++p) {
        if (space.core[p].empty()) continue;
        space.motion[p] = next++;
        space.carried_motion[p].about = area_centroid(rest.surface, space.core[p]);
        for (const int t : space.core[p]) space.pin[t] = space.motion[p] + 1;
    }
    if (std::find(space.pin.begin(), space.pin.end(), free_prism) == space.pin.end())
        throw InvalidInput(text("strain variables of level ", space.level,
                                " leave no free prism: every triangle is fixed or in the core of a patch"));
}

void add(DesignSpace& space, VariableKind kind, const Patch& patch, int component, const std::string& suffix) {
    space.variables.push_back({patch.name + "." + suffix, kind, patch.id, component, 1.0});
}

/// All variables that could be, with unit 1.
void list_candidates(DesignSpace& space) {
    static const char* axes[] = {"x", "y", "z"};
    for (const Patch& patch : space.patches().patches) {
        if (!takes_part(*space.rest, patch)) continue;
        bool any_free = false;
        for (const int t : patch.triangles) any_free |= space.pin[t] == free_prism;
        const bool has_core = !space.core[patch.id].empty();
        if (!any_free && !has_core) {
            space.notes.push_back(text("patch ", patch.name, ": all of its triangles are held, no variables"));
            continue;
        }
        for (const VariableKind kind : space.rest->parameters.kinds) switch (kind) {
                case VariableKind::load:
                    for (int c = 0; any_free && c < 3; ++c) add(space, kind, patch, c, text("load_", axes[c]));
                    break;
                case VariableKind::load_normal:
                    if (any_free) add(space, kind, patch, 0, "load_normal");
                    break;
                case VariableKind::strain:
                    for (int c = 0; has_core && c < 6; ++c)
                        add(space, kind, patch, c, text(c < 3 ? "rotate_" : "translate_", axes[c % 3]));
                    break;
                case VariableKind::stiffness:
                    if (any_free) add(space, kind, patch, 0, "stiffness");
                    break;
            }
    }
}

/// Linear response at rest to each variable at physical value 1. Stiffness, which has none, is left at zero.
struct RestResponse {
    Eigen::VectorXd largest;  ///< displacement
    Eigen::MatrixXd samples;  ///< column j: displacements of sampled vertices times the root of their share of the area
    Eigen::MatrixXd work;     ///< entry (i, j): work of load i in the response to load j; zero for strains
};

constexpr int most_samples = 3000;  ///< vertices for the metric: a mean square needs no more

/// Work of the force of every load variable in the displacement dv.
Eigen::VectorXd work_of_loads(const DesignSpace& space, const Points& dv) {
    const RestFacts& rest = *space.rest;
    const auto& patches = space.patches().patches;
    Points vector = Points::Zero(static_cast<Eigen::Index>(patches.size()), 3);
    Eigen::VectorXd normal = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(patches.size()));
    for (int t = 0; t < rest.surface.num_triangles(); ++t) {
        Eigen::RowVector3d moved = Eigen::RowVector3d::Zero();
        for (int k = 0; k < 3; ++k) moved += rest.area[t] / 3 * dv.row(rest.surface.triangles(t, k));
        vector.row(space.patches().label[t]) += moved;
        normal[space.patches().label[t]] += moved.dot(rest.normal.row(t));
    }
    Eigen::VectorXd work = Eigen::VectorXd::Zero(space.size());
    for (int j = 0; j < space.size(); ++j) {
        const Variable& variable = space.variables[j];
        if (variable.kind == VariableKind::load) work[j] = vector(variable.patch, variable.component);
        if (variable.kind == VariableKind::load_normal) work[j] = normal[variable.patch];
    }
    return work;
}

RestResponse rest_responses(const DesignSpace& space) {
    const RestFacts& rest = *space.rest;
    const int stride = std::max(1, rest.surface.num_vertices() / most_samples);
    const int samples = (rest.surface.num_vertices() + stride - 1) / stride;
    RestResponse result{Eigen::VectorXd::Zero(space.size()), Eigen::MatrixXd::Zero(3 * samples, space.size()),
                        Eigen::MatrixXd::Zero(space.size(), space.size())};
    DesignSpace movers = space;  // without stiffness, which has no response at rest
    std::vector<int> number;
    movers.variables.clear();
    for (int j = 0; j < space.size(); ++j)
        if (space.variables[j].kind != VariableKind::stiffness)
            movers.variables.push_back(space.variables[j]), number.push_back(j);
    if (movers.variables.empty()) return result;
    ShellOptions options = rest.setup.options;
    options.pin = space.pin;
    PrimoShell shell(rest.surface, options);
    // Springs and pins belong to the rest state, given loads and motions do not.
    std::vector<RigidMotion> at_rest(rest.setup.motions.size());
    for (std::size_t p = 0; p < space.motion.size(); ++p)
        if (space.motion[p] >= 0) at_rest.push_back({{0, 0, 0}, {0, 0, 0}, space.carried_motion[p].about});
    const Equilibrium start = shell.solve({{}, rest.setup.loads.spring}, at_rest);
    if (start.status != SolveStatus::converged) throw SolverError(text("the shell at rest: ", start.reason));
    double sampled_area = 0;
    for (int v = 0; v < rest.surface.num_vertices(); v += stride) sampled_area += rest.vertex_area[v];
    design_response(movers, shell, [&](int mover, const Points& dv) {
        const int j = number[mover];
        result.largest[j] = std::sqrt(dv.rowwise().squaredNorm().maxCoeff());
        for (int s = 0; s < samples; ++s)
            result.samples.block<3, 1>(3 * s, j) =
                std::sqrt(rest.vertex_area[s * stride] / sampled_area) * dv.row(s * stride).transpose();
        if (space.variables[j].kind != VariableKind::strain) result.work.col(j) = work_of_loads(space, dv);
    });
    return result;
}

bool is_load(const Variable& v) { return v.kind == VariableKind::load || v.kind == VariableKind::load_normal; }

/// The metric of the variables as they are scaled.
Eigen::MatrixXd metric(const DesignSpace& space, const RestResponse& response, const std::vector<int>& number) {
    const double wanted = space.rest->parameters.max_displacement * space.rest->diagonal;
    const Eigen::Index n = space.size();
    Eigen::MatrixXd moved(response.samples.rows(), n), work = Eigen::MatrixXd::Zero(n, n);
    std::vector<double> works;
    for (Eigen::Index i = 0; i < n; ++i) {
        moved.col(i) = 2 / wanted * space.variables[i].unit * response.samples.col(number[i]);
        for (Eigen::Index j = 0; j < n; ++j)
            if (is_load(space.variables[i]) && is_load(space.variables[j]))
                work(i, j) = space.variables[i].unit * space.variables[j].unit * 0.5 *
                             (response.work(number[i], number[j]) + response.work(number[j], number[i]));
        if (work(i, i) > 0) works.push_back(work(i, i));
    }
    Eigen::MatrixXd sum = moved.transpose() * moved;
    if (!works.empty()) {
        std::nth_element(works.begin(), works.begin() + static_cast<std::ptrdiff_t>(works.size() / 4), works.end());
        const double soft = works[works.size() / 4];
        for (Eigen::Index i = 0; i < n; ++i)
            for (Eigen::Index j = 0; j < n; ++j)
                sum(i, j) += is_load(space.variables[i]) && is_load(space.variables[j]) ? work(i, j) / soft : 0.0;
    }
    for (Eigen::Index i = 0; i < n; ++i) {
        if (space.variables[i].kind == VariableKind::stiffness) sum(i, i) += 1;
        sum(i, i) *= 1 + 1e-9;  // definite also where loads are dependent, as a vector and a normal on a flat patch
    }
    return sum;
}

/// Units so that x = 1 moves the surface by max_displacement; variables that move nothing are left out with a note.
void scale(DesignSpace& space) {
    const RestFacts& rest = *space.rest;
    const RestResponse response = rest_responses(space);
    double largest_load = 0;
    for (int j = 0; j < space.size(); ++j)
        if (is_load(space.variables[j])) largest_load = std::max(largest_load, response.largest[j]);
    std::vector<Variable> kept;
    std::vector<int> number;
    for (int j = 0; j < space.size(); ++j) {
        Variable variable = space.variables[j];
        const double least = is_load(variable) ? negligible * largest_load : 0;
        if (variable.kind == VariableKind::stiffness) {
            variable.unit = std::numbers::ln2;
        } else if (!(response.largest[j] > least)) {
            space.notes.push_back(text(variable.name, ": moves nothing, left out"));
            continue;
        } else {
            variable.unit = rest.parameters.max_displacement * rest.diagonal / response.largest[j];
        }
        kept.push_back(variable);
        number.push_back(j);
    }
    space.variables = std::move(kept);
    space.metric = metric(space, response, number);
    space.lower = Eigen::VectorXd::Constant(space.size(), -1);
    space.upper = Eigen::VectorXd::Constant(space.size(), 1);
}

DesignSpace make_space(std::shared_ptr<const RestFacts> rest, int level, const DesignSpace* parent) {
    if (level < 0 || level >= static_cast<int>(rest->tree->levels.size()))
        throw InvalidInput(text("level ", level, " must be in [0, ", rest->tree->levels.size() - 1, "]"));
    DesignSpace space;
    space.rest = std::move(rest);
    space.level = level;
    place_cores(space, parent);
    list_candidates(space);
    scale(space);
    return space;
}

int find_variable(const DesignSpace& space, int patch, VariableKind kind, int component) {
    for (int j = 0; j < space.size(); ++j)
        if (space.variables[j].patch == patch && space.variables[j].kind == kind &&
            space.variables[j].component == component)
            return j;
    return -1;
}

/// Gives `child_patch` the physical value of one parent variable: as x where it has that variable, else carried.
void pass_on(const Variable& from, double value, const Patch& child_patch, DesignSpace& child, Eigen::VectorXd& x) {
    const int j = find_variable(child, child_patch.id, from.kind, from.component);
    if (j >= 0) {
        x[j] = value / child.variables[j].unit;
    } else if (from.kind == VariableKind::stiffness) {
        for (const int t : child_patch.triangles) child.carried_log_height[t] += value;
    } else {
        for (const int t : child_patch.triangles)
            if (from.kind == VariableKind::load)
                child.carried_traction(t, from.component) += value;
            else
                child.carried_traction.row(t) += value * child.rest->normal.row(t);
    }
}

/// A child's core follows the parent's motion about its own centroid: tau_c = (exp(rho) - I)(c_c - c_P) + tau_P.
void pass_on_motion(const RigidMotion& from, const Patch& child_patch, DesignSpace& child, Eigen::VectorXd& x) {
    RigidMotion& carried = child.carried_motion[child_patch.id];
    const double angle = from.rotation.norm();
    const Eigen::Matrix3d turn =
        angle > 0 ? Eigen::AngleAxisd(angle, from.rotation / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
    const Eigen::Vector3d arm = carried.about - from.about;
    const Eigen::Vector3d translation = turn * arm - arm + from.translation;
    for (int c = 0; c < 6; ++c) {
        const double value = c < 3 ? from.rotation[c] : translation[c - 3];
        const int j = find_variable(child, child_patch.id, VariableKind::strain, c);
        if (j >= 0)
            x[j] = value / child.variables[j].unit;
        else
            (c < 3 ? carried.rotation[c] : carried.translation[c - 3]) = value;
    }
}

}  // namespace

std::shared_ptr<const RestFacts> rest_facts(const Problem& problem) {
    auto rest = std::make_shared<RestFacts>();
    rest->setup = shell_setup(problem);
    rest->surface = problem.surface;
    rest->adjacent = adjacency(problem.surface);
    rest->area = triangle_areas(problem.surface);
    rest->normal = triangle_normals(problem.surface);
    rest->vertex_area = vertex_areas(problem.surface);
    rest->diagonal = box_diagonal(problem.surface);
    rest->given_traction = problem.given_traction;
    rest->tree = std::make_shared<const PatchHierarchy>(problem.tree);
    rest->parameters = problem.parameters;
    if (!(problem.parameters.max_displacement > 0))
        throw InvalidInput(text("max_displacement = ", problem.parameters.max_displacement, " must be > 0"));
    if (!problem.parameters.on.empty() &&
        static_cast<int>(problem.parameters.on.size()) != problem.surface.num_triangles())
        throw InvalidInput(text("parameters.on: ", problem.parameters.on.size(), " entries for ",
                                problem.surface.num_triangles(), " triangles"));
    return rest;
}

DesignSpace design_space(std::shared_ptr<const RestFacts> rest, int level) {
    return make_space(std::move(rest), level, nullptr);
}

InheritedSpace refine(const DesignSpace& parent, const Eigen::VectorXd& x) {
    InheritedSpace result{make_space(parent.rest, parent.level + 1, &parent), {}};
    DesignSpace& child = result.space;
    result.x = Eigen::VectorXd::Zero(child.size());
    const int m = parent.rest->surface.num_triangles();
    child.carried_traction = parent.carried_traction.rows() > 0 ? parent.carried_traction : Points(Points::Zero(m, 3));
    if (parent.changes_height())
        child.carried_log_height = parent.carried_log_height.size() > 0 ? parent.carried_log_height
                                                                        : Eigen::VectorXd(Eigen::VectorXd::Zero(m));
    const std::vector<RigidMotion> motions = demand(parent, x).motions;
    for (const Patch& patch : child.patches().patches) {
        for (int j = 0; j < parent.size(); ++j)
            if (parent.variables[j].patch == patch.parent && parent.variables[j].kind != VariableKind::strain)
                pass_on(parent.variables[j], x[j] * parent.variables[j].unit, patch, child, result.x);
        if (child.motion[patch.id] >= 0) pass_on_motion(motions[parent.motion[patch.parent]], patch, child, result.x);
    }
    if (child.carried_traction.isZero(0)) child.carried_traction.resize(0, 3);
    child.lower = child.lower.cwiseMin(result.x);
    child.upper = child.upper.cwiseMax(result.x);
    return result;
}

}  // namespace strake
