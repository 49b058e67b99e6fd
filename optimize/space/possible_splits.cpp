#include "optimize/space/possible_splits.hpp"

#include <algorithm>
#include <map>
#include <numeric>

namespace strake {
namespace {

/// Shape variables by the group of the patch that they act on; `owner(variable)` is a patch of the parent.
template <class Owner>
std::vector<std::vector<int>> by_group(const DesignSpace& space, const std::vector<int>& group, const Owner& owner) {
    std::vector<std::vector<int>> members(group.size());
    for (int j = 0; j < space.num_shape(); ++j)
        if (space.variables[j].patch >= 0) members[group[owner(space.variables[j])]].push_back(j);
    return members;
}

/// How many variables a split adds to a patch that no space has: it would have as many as the first of its parts.
int added_by_parts(const PartsOfPatches& parts, const std::vector<int>& variables) {
    std::map<int, int> first;  // part, by owner
    return static_cast<int>(std::ranges::count_if(variables, [&](int j) {
        const int part = parts.child.variables[j].patch;
        return first.try_emplace(parts.owner[part], part).first->second != part;
    }));
}

}  // namespace

PartsOfPatches::PartsOfPatches(const DesignSpace& parts, const Front& front) : child(parts), above(front) {
    for (const Patch& patch : child.patches().patches) owner.push_back(above.patches.label[patch.triangles.front()]);
}

std::vector<int> split_groups(const DesignSpace* parent, const PartsOfPatches& parts) {
    std::vector<int> root(parts.above.depth.size());
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](int p) {
        while (root[p] != p) p = root[p];
        return p;
    };
    const auto tie = [&](const DesignSpace& space, const auto& owner) {
        for (const Variable& variable : space.variables)
            for (const DegreeOfFreedom& move : variable.moves) {
                if (variable.patch < 0) continue;
                const int a = find(owner(variable.patch)), b = find(owner(move.index / patch_dof::count));
                root[std::max(a, b)] = std::min(a, b);
            }
    };
    if (parent) tie(*parent, [](int patch) { return patch; });
    tie(parts.child, [&](int patch) { return parts.owner[patch]; });
    for (std::size_t p = 0; p < root.size(); ++p) root[p] = find(static_cast<int>(p));
    return root;
}

void offer_fields(const DesignSpace& parent, const DesignSpace& child, std::vector<SplitDecrease>& splits) {
    const std::vector<int>& there = parent.fields.numbers;
    for (int j = 0; j < child.num_shape(); ++j) {
        const Variable& v = child.variables[j];
        const int field = v.kind == VariableKind::field ? child.rest->parameters.user_variables[v.component].field : -1;
        if (field < 0 || std::ranges::binary_search(there, field)) continue;
        SplitDecrease more;
        more.names = v.name;
        more.field = field;
        more.variables = {j};
        more.new_variables = 1;
        splits.push_back(std::move(more));
    }
}

std::vector<SplitDecrease> possible_splits(const DesignSpace& parent, const DesignSpace& child,
                                           const std::vector<Front>& passed) {
    const PartsOfPatches parts(child, passed.back());
    const std::vector<int> number = parts_of(*parent.rest->tree, parts.above);
    const bool is_next = passed.size() == 1;
    const std::vector<int> group = split_groups(is_next ? &parent : nullptr, parts);
    const auto new_ones = by_group(child, group, [&](const Variable& v) { return parts.owner[v.patch]; });
    std::vector<std::vector<int>> old_ones;
    if (is_next) old_ones = by_group(parent, group, [](const Variable& v) { return v.patch; });
    std::vector<SplitDecrease> splits;
    for (std::size_t g = 0; g < group.size(); ++g) {
        SplitDecrease split;
        bool has_parts = false;
        for (const Patch& patch : parts.above.patches.patches)
            if (group[patch.id] == static_cast<int>(g)) {
                split.patches.push_back(patch.id);
                split.names += (split.names.empty() ? "" : "+") + patch.name;
                has_parts |= number[patch.id] > 1;
            }
        split.variables = new_ones[g];
        split.new_variables = is_next ? static_cast<int>(new_ones[g].size()) - static_cast<int>(old_ones[g].size())
                                      : added_by_parts(parts, new_ones[g]);
        has_parts |= is_next && !parent.has_patches;
        if (has_parts && split.new_variables > 0) splits.push_back(std::move(split));
    }
    offer_fields(parent, child, splits);
    return splits;
}

LevelSet refined(const DesignSpace& space, const std::vector<Front>& passed, std::vector<char> chosen,
                 const std::vector<int>& fields) {
    LevelSet next{*space.front, space.fields, space.has_patches};
    next.has_patches |= std::ranges::count(chosen, 1) > 0;
    std::vector<std::vector<char>> is_split{std::move(chosen)};  // from the last front to the first
    for (std::size_t k = passed.size() - 1; k > 0; --k) {
        std::vector<char> above(passed[k - 1].depth.size(), 0);
        for (const Patch& patch : passed[k].patches.patches)
            if (is_split.back()[patch.id]) above[patch.parent] = 1;
        is_split.push_back(std::move(above));
    }
    for (std::size_t k = 0; k < passed.size(); ++k, is_split.pop_back()) {
        std::vector<char> here;  // a patch that was left whole has no part that is split
        for (const Patch& patch : next.front.patches.patches)
            here.push_back(is_split.back()[passed[k].patches.label[patch.triangles.front()]]);
        next.front = split_front(*space.rest->tree, next.front, here);
    }
    for (Patch& patch : next.front.patches.patches) patch.parent = space.patches().label[patch.triangles.front()];
    if (!space.resting.empty()) {
        next.resting.clear();
        for (const Patch& patch : next.front.patches.patches) next.resting.push_back(space.resting[patch.parent]);
    }
    next.fields = with_fields(space, fields);
    return next;
}

FieldSet with_fields(const DesignSpace& space, const std::vector<int>& fields) {
    FieldSet next{space.fields.numbers, offered_fields(space.rest->parameters, space.fields).reach};
    next.numbers.insert(next.numbers.end(), fields.begin(), fields.end());
    std::ranges::sort(next.numbers);
    return next;
}

}  // namespace strake
