#include "optimize/space/single_patches.hpp"

#include "optimize/space/possible_splits.hpp"

#include <algorithm>

namespace strake {
namespace {

using Eigen::MatrixXd;

int owner_in(const Front& front, const Patch& patch) { return front.patches.label[patch.triangles.front()]; }

bool rests(const DesignSpace& space, const Patch& patch) { return !space.has_variables(owner_in(*space.front, patch)); }

bool is_new(const Patch& patch, const Front& above) {
    return above.patches.patches[owner_in(above, patch)].triangles.size() > patch.triangles.size();
}

/// The space's front, then finer ones: what rests is split again and again, what has variables once. As long as a level
/// could have all of them: the look costs a response at rest for each.
std::vector<Front> fronts_below(const DesignSpace& space) {
    const Parameters& p = space.rest->parameters;
    const double max_variables = p.max_variable_ratio * std::max(1, space.size());
    std::vector<Front> fronts{*space.front};
    for (;;) {
        const std::vector<int> parts = parts_of(*space.rest->tree, fronts.back());
        std::vector<char> is_split;
        for (const Patch& patch : fronts.back().patches.patches)
            is_split.push_back(parts[patch.id] > 1 && (fronts.size() == 1 || rests(space, patch)));
        if (std::ranges::count(is_split, 1) == 0) return fronts;
        Front next = split_front(*space.rest->tree, fronts.back(), is_split);
        const auto variables = static_cast<double>(next.depth.size()) * variables_of_a_patch(p);
        if (fronts.size() > 1 && variables > max_variables) return fronts;
        fronts.push_back(std::move(next));
    }
}

/// Groups of the patches of a space that share variables: per patch the first of its group.
std::vector<int> groups_of(const DesignSpace& space) {
    return split_groups(&space, PartsOfPatches(space, *space.front));
}

/// Everything on the fronts, with these fields, each from the one before.
std::vector<InheritedSpace> spaces_on(const std::vector<Front>& fronts, std::size_t first, const FieldSet& fields,
                                      const DesignSpace& space, const Eigen::VectorXd& x) {
    std::vector<InheritedSpace> all;
    for (std::size_t k = first; k < fronts.size(); ++k)
        all.push_back(refine(all.empty() ? space : all.back().space, all.empty() ? x : all.back().x,
                             {fronts[k], fields, true, {}}));
    return all;
}

/// Shape variables of the patches of a group.
std::vector<int> variables_in(const DesignSpace& space, const std::vector<int>& group, int g) {
    std::vector<int> variables;
    for (int j = 0; j < space.num_shape(); ++j)
        if (space.variables[j].patch >= 0 && group[space.variables[j].patch] == g) variables.push_back(j);
    return variables;
}

void name_patch(SplitDecrease& split, const Patch& patch) {
    split.names += (split.names.empty() ? "" : "+") + patch.name;
}

void add_part(SplitDecrease& split, const Patch& patch) {
    split.parts.push_back({patch.triangles.front(), static_cast<int>(patch.triangles.size())});
}

/// A group of patches of a front, which then all have variables.
SplitDecrease taken_together(const DesignSpace& on_front, const std::vector<int>& group, int g) {
    SplitDecrease take;
    for (const Patch& patch : on_front.patches().patches)
        if (group[patch.id] == g) add_part(take, patch), name_patch(take, patch);
    take.variables = variables_in(on_front, group, g);
    take.new_variables = static_cast<int>(take.variables.size());
    return take;
}

/// Patches of the finest front of which something is in a group of a coarser one.
std::vector<int> covered_by(const std::vector<int>& group, int g, const Front& coarser, const Front& finest) {
    std::vector<int> covered;
    for (const Patch& patch : finest.patches.patches)
        if (group[owner_in(coarser, patch)] == g) covered.push_back(patch.id);
    return covered;
}

/// Patches that have variables, split once; what is at rest comes along where they are tied to it.
/// @param on_parts with the first of the finer fronts
void offer_splits(const DesignSpace& space, const DesignSpace& on_parts, const Front& finest, const MatrixXd& to_finest,
                  std::vector<SplitDecrease>& splits) {
    const Front& front = *space.front;
    const std::vector<int> group = split_groups(&space, PartsOfPatches(on_parts, front));
    std::vector<char> has_variables(group.size(), 0);
    for (const Patch& patch : front.patches.patches) has_variables[group[patch.id]] |= !rests(space, patch);
    std::vector<int> group_of_part;
    for (const Patch& part : on_parts.patches().patches) group_of_part.push_back(group[owner_in(front, part)]);
    for (int g = 0; g < static_cast<int>(group.size()); ++g) {
        if (!has_variables[g]) continue;
        SplitDecrease split = taken_together(on_parts, group_of_part, g);
        split.names.clear();  // those of the patches
        for (const Patch& patch : front.patches.patches)
            if (group[patch.id] == g) split.patches.push_back(patch.id), name_patch(split, patch);
        split.new_variables -= static_cast<int>(variables_in(space, group, g).size());
        if (split.new_variables <= 0) continue;
        split.covered = covered_by(group, g, front, finest);
        if (to_finest.size() > 0) split.directions = to_finest(Eigen::all, split.variables);
        splits.push_back(std::move(split));
    }
}

/// Patches of a front that are at rest in the space, and on no front above.
/// @param to_finest dx on the finest front by dx on this one; empty: it is the finest
void offer_takes(const DesignSpace& space, const DesignSpace& on_front, const Front* above, const Front& finest,
                 const MatrixXd& to_finest, std::vector<SplitDecrease>& splits) {
    const std::vector<int> group = groups_of(on_front);
    std::vector<char> is_offered(group.size(), 0), has_variables(group.size(), 0);
    for (const Patch& patch : on_front.patches().patches) {
        is_offered[group[patch.id]] |= !above || is_new(patch, *above);
        has_variables[group[patch.id]] |= !rests(space, patch);
    }
    for (int g = 0; g < static_cast<int>(group.size()); ++g) {
        if (!is_offered[g] || has_variables[g]) continue;
        SplitDecrease take = taken_together(on_front, group, g);
        if (take.new_variables == 0) continue;
        take.covered = covered_by(group, g, *on_front.front, finest);
        if (to_finest.size() > 0) take.directions = to_finest(Eigen::all, take.variables);
        splits.push_back(std::move(take));
    }
}

}  // namespace

Prospect prospect_of_single_patches(const DesignSpace& space, const Eigen::VectorXd& x, bool offers_fields) {
    const std::vector<Front> fronts = fronts_below(space);
    // Where no patch has variables yet the first front mostly is the whole body, which fields move better.
    const std::size_t first = space.has_patches || fronts.size() == 1 || fronts[0].depth.size() > 1 ? 0 : 1;
    const FieldSet fields = offers_fields ? offered_fields(space.rest->parameters, space.fields) : space.fields;
    std::vector<InheritedSpace> on = spaces_on(fronts, first, fields, space, x);
    Prospect below;
    below.takes_single_patches = true;
    below.passed = {*space.front};
    below.parts = parts_of(*space.rest->tree, *space.front);
    std::vector<MatrixXd> to_finest(on.size());
    for (std::size_t k = on.size() - 1; k-- > 0;)
        to_finest[k] =
            to_finest[k + 1].size() > 0 ? MatrixXd(to_finest[k + 1] * on[k + 1].prolongation) : on[k + 1].prolongation;
    if (space.has_patches && on.size() > 1) offer_splits(space, on[1].space, fronts.back(), to_finest[1], below.splits);
    for (std::size_t k = 0; k < on.size(); ++k)
        offer_takes(space, on[k].space, k > 0 ? &fronts[first + k - 1] : nullptr, fronts.back(), to_finest[k],
                    below.splits);
    offer_fields(space, on.back().space, below.splits);
    const MatrixXd from_space =
        to_finest[0].size() > 0 ? MatrixXd(to_finest[0] * on[0].prolongation) : on[0].prolongation;
    below.children = std::move(on.back());
    below.children.prolongation = from_space;
    return below;
}

LevelSet with_single_patches(const DesignSpace& space, const std::vector<const SplitDecrease*>& chosen,
                             const std::vector<int>& fields) {
    const PatchHierarchy& tree = *space.rest->tree;
    LevelSet next = level_set_of(space);
    const auto is_whole = [&](const PatchPart& part) {
        const PatchLevel& now = next.front.patches;
        return static_cast<int>(now.patches[now.label[part.triangle]].triangles.size()) <= part.triangles;
    };
    for (;;) {
        std::vector<char> is_split(next.front.depth.size(), 0);
        for (const SplitDecrease* split : chosen)
            for (const PatchPart& part : split->parts)
                if (!is_whole(part)) is_split[next.front.patches.label[part.triangle]] = 1;
        if (std::ranges::count(is_split, 1) == 0) break;
        next.front = split_front(tree, next.front, is_split);
    }
    next.resting.assign(next.front.depth.size(), 0);
    for (Patch& patch : next.front.patches.patches) {
        patch.parent = owner_in(*space.front, patch);
        next.resting[patch.id] = rests(space, patch);
    }
    for (const SplitDecrease* split : chosen)
        for (const PatchPart& part : split->parts) next.resting[next.front.patches.label[part.triangle]] = 0;
    next.has_patches = std::ranges::count(next.resting, 0) > 0;
    next.fields = with_fields(space, fields);
    return next;
}

}  // namespace strake
