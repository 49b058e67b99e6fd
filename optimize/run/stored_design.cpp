#include "optimize/run/stored_design.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/text/hash.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "optimize/space/parameters.hpp"

#include <algorithm>
#include <cstdint>

namespace strake {
namespace {

std::string hash_of(const void* data, std::size_t bytes) {
    return hash_digits(fnv1a({static_cast<const char*>(data), bytes}));
}

bool has_strains(const Problem& problem) {
    const auto& kinds = problem.parameters.kinds;
    return std::find(kinds.begin(), kinds.end(), VariableKind::strain) != kinds.end();
}

Front front_of(const PatchHierarchy& tree, const StoredDesign& design) {
    Front front;
    front.patches.label.assign(tree.levels[0].label.size(), -1);
    for (const auto& [level, id] : design.front) {
        Patch patch = tree.levels[level].patches[id];
        patch.id = patch.parent = static_cast<int>(front.patches.patches.size());
        for (const int t : patch.triangles) front.patches.label[t] = patch.id;
        // The tree may have got finer.
        int depth = level;
        const auto size_at = [&](int k) {
            return tree.levels[k].patches[tree.levels[k].label[patch.triangles.front()]].triangles.size();
        };
        while (depth + 1 < static_cast<int>(tree.levels.size()) && size_at(depth + 1) == patch.triangles.size())
            ++depth;
        front.depth.push_back(depth);
        front.patches.angle_deg = tree.levels[level].angle_deg;
        front.patches.patches.push_back(std::move(patch));
    }
    return front;
}

/// Those of the patches, then those of user variables, which are the same where they are called the same.
Eigen::VectorXd all_dofs(const DesignSpace& space, const StoredDesign& design) {
    const auto& given = space.rest->parameters.user_variables;
    Eigen::VectorXd all = Eigen::VectorXd::Zero(space.num_dofs());
    all.head(space.num_patch_dofs()) = design.dofs;
    for (const auto& [name, value] : design.given) {
        std::size_t g = 0;
        while (g < given.size() && given[g].name != name) ++g;
        if (g < given.size())
            all[space.num_patch_dofs() + static_cast<int>(g)] = value;
        else if (value != 0)
            throw InvalidInput(text("start_from: the run had a variable ", name, " = ", value,
                                    " under parameters.given, which this case does not have"));
    }
    return all;
}

}  // namespace

SurfaceMark surface_mark(const TriMesh& surface) {
    SurfaceMark mark;
    mark.vertices = surface.num_vertices();
    mark.triangles = surface.num_triangles();
    mark.diagonal = box_diagonal(surface);
    mark.positions = hash_of(surface.vertices.data(), sizeof(double) * surface.vertices.size());
    mark.connectivity = hash_of(surface.triangles.data(), sizeof(*surface.triangles.data()) * surface.triangles.size());
    return mark;
}

StoredDesign stored_design(const AcceptedDesign& accepted) {
    const DesignSpace& space = accepted.space;
    const RestFacts& rest = *space.rest;
    StoredDesign design;
    design.evaluation = accepted.record.evaluation;
    design.level = space.level;
    design.objective = accepted.record.objective;
    design.surface = surface_mark(rest.surface);
    design.tree = *rest.tree;
    for (const Patch& patch : space.patches().patches) {
        const int level = space.front->depth[patch.id];
        design.front.emplace_back(level, rest.tree->levels[level].label[patch.triangles.front()]);
    }
    const Eigen::VectorXd all = dofs(space, accepted.x);
    design.dofs = all.head(space.num_patch_dofs());
    for (Eigen::Index g = 0; g < space.carried_user_values.size(); ++g)
        design.given.emplace_back(rest.parameters.user_variables[g].name,
                                  space.user_values(all)[g] + space.carried_user_values[g]);
    for (std::size_t p = 0; p < space.core.size(); ++p)
        for (const int t : space.core[p]) {
            if (design.core.empty()) design.core.assign(static_cast<std::size_t>(rest.elastic().num_triangles()), -1);
            design.core[t] = static_cast<int>(p);
        }
    if (!design.core.empty()) design.carried_motion = space.carried_motion;
    design.carried_traction = space.carried_traction;
    design.carried_log_height = space.carried_log_height;
    design.poses = accepted.poses;
    design.vertices = accepted.vertices;
    design.parameters = parameter_values(space, accepted.x);
    design.at_rest = accepted.at_rest;
    return design;
}

void check_surface(const StoredDesign& design, const TriMesh& surface) {
    const SurfaceMark &was = design.surface, is = surface_mark(surface);
    if (was.vertices != is.vertices || was.triangles != is.triangles)
        throw InvalidInput(text("the surface has ", is.vertices, " vertices and ", is.triangles,
                                " triangles, that of the run has ", was.vertices, " and ", was.triangles));
    if (was.connectivity != is.connectivity)
        throw InvalidInput(
            text("the surface has as many vertices and triangles as that of the run, but other "
                 "triangles (their order and the numbers of their vertices count)"));
    if (was.positions != is.positions)
        throw InvalidInput(text("the surface has vertices at other positions than that of the run (its diagonal is ",
                                is.diagonal, ", that of the run ", was.diagonal,
                                "); they have to be equal bit by bit"));
}

void check_elastic(const StoredDesign& design, int triangles) {
    const std::size_t was = design.tree.levels.empty() ? 0 : design.tree.levels.front().label.size();
    if (was != static_cast<std::size_t>(triangles))
        throw InvalidInput(text("the shell of the run had ", was, " triangles, that of this case has ", triangles,
                                ": the key wrap has to be that of the run"));
}

bool has_levels_of(const PatchHierarchy& tree, const StoredDesign& design) {
    if (tree.levels.size() < design.tree.levels.size()) return false;
    for (std::size_t k = 0; k < design.tree.levels.size(); ++k)
        if (tree.levels[k].label != design.tree.levels[k].label) return false;
    return true;
}

void start_from(Problem& problem, std::shared_ptr<const StoredDesign> design) {
    check_surface(*design, problem.surface);
    check_elastic(*design, elastic_surface(problem).num_triangles());
    if (has_strains(problem) != !design->core.empty())
        throw InvalidInput(
            design->core.empty()
                ? "the run had no strains, and strain variables hold parts of the shell: they cannot begin "
                  "at its shape"
                : "the run had strain variables, whose shape nothing else can hold: keep strain in "
                  "parameters.variables");
    for (const auto& [name, value] : design->given)
        if (value != 0 && std::ranges::find(problem.parameters.user_variables, name, &UserVariable::name) ==
                              problem.parameters.user_variables.end())
            throw InvalidInput(text("the run had a variable ", name, " = ", value,
                                    ", which this case does not have; keep fields, given and planform under "
                                    "parameters as they are in the case.yaml of that folder"));
    if (!has_levels_of(problem.tree, *design)) problem.tree = design->tree;
    for (ProgramParameter& parameter : problem.program_parameters)
        for (const auto& [name, value] : design->parameters) {
            if (name != parameter.name) continue;
            if (!(value >= parameter.min && value <= parameter.max))
                throw InvalidInput(text("the run ended at ", name, " = ", value, parameter.is_angle ? " rad" : "",
                                        ", which must be in [", parameter.min, ", ", parameter.max, "]"));
            parameter.start = value;
        }
    problem.start = std::move(design);
}

StartSpace start_space(std::shared_ptr<const RestFacts> rest, const StoredDesign& design) {
    const PatchHierarchy& tree = *rest->tree;
    StartSpace start;
    DesignSpace& space = start.space;
    start.front = front_of(tree, design);
    space.rest = std::move(rest);
    space.level = design.level - 1;  // the space that is refined from it has the level's number
    space.front = std::make_shared<const Front>(start.front);
    const int patches = static_cast<int>(design.front.size());
    space.core.assign(patches, {});
    space.motion.assign(patches, -1);
    space.carried_motion.assign(patches, {});
    for (std::size_t t = 0; t < design.core.size(); ++t)
        if (design.core[t] >= 0) space.core[design.core[t]].push_back(static_cast<int>(t));
    int next = static_cast<int>(space.rest->setup.motions.size());
    for (int p = 0; p < patches; ++p)
        if (!space.core[p].empty()) {
            space.motion[p] = next++;
            space.carried_motion[p] = design.carried_motion[p];
        }
    space.carried_traction = design.carried_traction;
    space.carried_log_height = design.carried_log_height;
    const Eigen::VectorXd all = all_dofs(space, design);
    space.carried_user_values = Eigen::VectorXd::Zero(all.size() - design.dofs.size());
    std::vector<double> x;
    for (int i = 0; i < all.size(); ++i) {
        if (all[i] == 0) continue;
        Variable variable;
        const bool is_user_defined = i >= design.dofs.size();
        const bool is_stiffness = !is_user_defined && i % patch_dof::count == patch_dof::stiffness;
        variable.patch = is_user_defined ? -1 : i / patch_dof::count;
        variable.kind = is_stiffness ? VariableKind::stiffness : VariableKind::load;
        variable.moves = {{i, 1.0}};
        space.variables.push_back(std::move(variable));
        x.push_back(all[i]);
    }
    const int shape = space.size();
    space.metric = Eigen::MatrixXd::Identity(shape, shape);
    space.lower = space.upper = Eigen::VectorXd::Zero(shape);
    append_parameters(space);
    start.x = Eigen::VectorXd::Zero(space.size());
    start.x.head(shape) = Eigen::VectorXd::Map(x.data(), shape);
    return start;
}

namespace {

/// The fields of the first level, and those that the design uses; of patches that are taken one by one those too.
LevelSet stored_level(const StartSpace& stored, int level) {
    const RestFacts& rest = *stored.space.rest;
    LevelSet set = level_set(rest, 0);
    set.front = stored.front;
    set.has_patches |= level > 0;
    if (rest.takes_single_patches && set.has_patches) {
        set.resting.assign(set.front.depth.size(), 1);
        for (const Variable& v : stored.space.variables)
            if (v.patch >= 0) set.resting[v.patch] = 0;
        set.has_patches = std::ranges::count(set.resting, 0) > 0;
    }
    std::vector<int>& numbers = set.fields.numbers;
    for (const Variable& v : stored.space.variables) {
        const int g = v.moves.empty() ? -1 : v.moves.front().index - stored.space.num_patch_dofs();
        const int field = g < 0 ? -1 : rest.parameters.user_variables[static_cast<std::size_t>(g)].field;
        if (field >= 0 && !std::ranges::binary_search(numbers, field))
            numbers.insert(std::ranges::lower_bound(numbers, field), field);
    }
    return set;
}

}  // namespace

InheritedSpace enter_stored(ShapeEvaluator& evaluator, std::shared_ptr<const RestFacts> rest,
                            const StoredDesign& design) {
    const double diagonal = rest->diagonal;
    const StartSpace stored = start_space(std::move(rest), design);
    InheritedSpace inherited = refine(stored.space, stored.x, stored_level(stored, design.level));
    evaluator.enter(inherited.space);
    std::string reason;
    const Points vertices = evaluator.begin_from(design.poses, inherited.x, reason);
    const double off = vertices.rows() == 0
                           ? std::numeric_limits<double>::infinity()
                           : std::sqrt((vertices - design.vertices).rowwise().squaredNorm().maxCoeff());
    if (!(off <= inheritance_tolerance * diagonal))
        throw InvalidInput(
            text("start_from: the loads of that run do not give its shape here (",
                 reason.empty() ? text("it is ", off / diagonal, " diagonals off") : reason,
                 "): fixed, symmetry, shell, loads, strains, parameters.fields and what wings keep (planform: keep) "
                 "have to be those of that run"));
    return inherited;
}

}  // namespace strake
