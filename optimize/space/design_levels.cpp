#include "optimize/space/design_levels.hpp"

#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/space/mirror.hpp"
#include "optimize/space/parameters.hpp"
#include "optimize/space/scaling.hpp"
#include "optimize/space/strain_core.hpp"

#include <algorithm>
#include <numeric>

namespace strake {
namespace {

constexpr double nearly_all = 0.95;  ///< of the area of a patch that is held: worth a word

bool wants(const DesignSpace& space, VariableKind kind) {
    const auto& kinds = space.rest->parameters.kinds;
    return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

bool any_of(const std::vector<char>& flags, const Patch& patch) {
    return std::any_of(patch.triangles.begin(), patch.triangles.end(), [&](int t) { return flags[t] != 0; });
}

bool takes_part(const RestFacts& rest, const Patch& patch) {
    return rest.parameters.variables_on.empty() || any_of(rest.parameters.variables_on, patch);
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
        space.core = strain_cores(rest.elastic(), rest.elastic_adjacent(), space.patches(), space.pin,
                                  rest.setup.options.symmetry.has_value(), rest.parameters.free_border);
        for (std::size_t p = 0; p < patches.size(); ++p)
            if (!takes_part(rest, patches[p])) space.core[p].clear();
    } else {
        std::vector<char> in_core(static_cast<std::size_t>(rest.elastic().num_triangles()), 0);
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
        space.carried_motion[p].about = area_centroid(rest.elastic(), space.core[p]);
        for (const int t : space.core[p]) space.pin[t] = space.motion[p] + 1;
    }
    if (std::find(space.pin.begin(), space.pin.end(), free_prism) == space.pin.end())
        throw InvalidInput(text("strain variables of level ", space.level,
                                " leave no free prism: every triangle is fixed or in the core of a patch"));
}

/// Patches that share their values: the first of them, and how a vector of it becomes a vector of each.
struct Tied {
    struct Member {
        int patch;
        Eigen::Matrix3d turn;  ///< of loads and translations; a rotation vector takes det(turn) turn
    };
    std::vector<Member> members;
    /// Of a patch that is its own mirror image: only what keeps it so may be offered. Else zero.
    Eigen::Matrix3d own_image = Eigen::Matrix3d::Zero();
};

/// Every patch is in one of the result; ties as `parameters.groups` and `parameters.mirror` ask for.
std::vector<Tied> tied_patches(const DesignSpace& space) {
    const RestFacts& rest = *space.rest;
    const auto& patches = space.patches().patches;
    std::vector<char> taken(patches.size(), 0);
    std::vector<Tied> all;
    for (const std::vector<char>& group : rest.parameters.groups) {
        Tied tied;
        for (const Patch& patch : patches)
            if (!taken[patch.id] && any_of(group, patch)) {
                taken[patch.id] = 1;
                tied.members.push_back({patch.id, Eigen::Matrix3d::Identity()});
            }
        if (!tied.members.empty()) all.push_back(tied);
    }
    std::vector<int> image(patches.size(), -1);
    if (rest.mirror) image = mirror_images(rest.elastic(), space.patches(), *rest.mirror);
    for (const Patch& patch : patches) {
        if (std::exchange(taken[patch.id], 1)) continue;
        Tied tied{{{patch.id, Eigen::Matrix3d::Identity()}}};
        const int other = image[patch.id];
        if (other == patch.id) tied.own_image = reflection(*rest.mirror);
        if (other >= 0 && !std::exchange(taken[other], 1)) tied.members.push_back({other, reflection(*rest.mirror)});
        all.push_back(tied);
    }
    std::sort(all.begin(), all.end(),
              [](const Tied& a, const Tied& b) { return a.members[0].patch < b.members[0].patch; });
    return all;
}

/// Lists all variables that could be, with unit 1.
class Candidates {
public:
    explicit Candidates(DesignSpace& space) : space_(space), rest_(*space.rest) {}

    void list() {
        for (const Tied& tied : tied_patches(space_)) {
            Tied usable{{}, tied.own_image};
            bool any_free = false, has_core = true;
            for (const Tied::Member& member : tied.members) {
                const Patch& patch = space_.patches().patches[member.patch];
                if (!takes_part(rest_, patch) || !space_.has_variables(patch.id)) continue;
                if (!rest_.parameters.frozen.empty() && any_of(rest_.parameters.frozen, patch)) {
                    space_.notes.push_back(text("patch ", patch.name, ": frozen, no variables"));
                    continue;
                }
                const bool is_free = std::any_of(patch.triangles.begin(), patch.triangles.end(),
                                                 [&](int t) { return space_.pin[t] == free_prism; });
                if (!is_free && space_.core[patch.id].empty()) {
                    space_.notes.push_back(text("patch ", patch.name, ": all of its triangles are held, no variables"));
                    continue;
                }
                note_if_nearly_fixed(patch);
                any_free |= is_free;
                has_core &= !space_.core[patch.id].empty();
                usable.members.push_back(member);
            }
            if (!usable.members.empty()) offer(usable, any_free, has_core);
        }
    }

private:
    void note_if_nearly_fixed(const Patch& patch) {
        double held = 0;
        for (const int t : patch.triangles)
            if (rest_.setup.options.pin[t] != free_prism) held += rest_.area[t];
        if (held <= nearly_all * patch.area) return;
        space_.nearly_fixed.push_back(patch.name);
        space_.notes.push_back(
            text("patch ", patch.name, ": ", std::floor(1000 * held / patch.area) / 10,
                 " % of its area is held; its variables move what is left, which has almost no room"));
    }

    void offer(const Tied& tied, bool any_free, bool has_core) {
        static const char* axes[] = {"x", "y", "z"};
        const Parameters& p = rest_.parameters;
        for (const VariableKind kind : p.kinds) switch (kind) {
                case VariableKind::load:
                    for (int c = 0; any_free && p.load_directions.empty() && c < 3; ++c)
                        add_vector(tied, kind, c, patch_dof::load, Eigen::Vector3d::Unit(c), text("load_", axes[c]));
                    for (std::size_t d = 0; any_free && d < p.load_directions.size(); ++d)
                        add_vector(tied, kind, static_cast<int>(d), patch_dof::load, p.load_directions[d],
                                   text("load_", d + 1));
                    break;
                case VariableKind::normal_load:
                    if (any_free) add_scalar(tied, kind, patch_dof::normal, "load_normal");
                    break;
                case VariableKind::strain:
                    for (int c = 0; has_core && c < 6; ++c) {
                        if (!(c < 3 ? p.strain_rotates : p.strain_translates)) continue;
                        add_vector(tied, kind, c, c < 3 ? patch_dof::rotation : patch_dof::translation,
                                   Eigen::Vector3d::Unit(c % 3), text(c < 3 ? "rotate_" : "translate_", axes[c % 3]));
                    }
                    break;
                case VariableKind::stiffness:
                    if (any_free) add_scalar(tied, kind, patch_dof::stiffness, "stiffness");
                    break;
                case VariableKind::field:
                case VariableKind::planform:
                case VariableKind::parameter:
                    break;
            }
    }

    void add(const Tied& tied, VariableKind kind, int component, const std::string& suffix,
             std::vector<DegreeOfFreedom> moves) {
        const Patch& first = space_.patches().patches[tied.members[0].patch];
        std::string name = first.name;
        if (tied.members.size() > 1) name += "+" + space_.patches().patches[tied.members[1].patch].name;
        if (tied.members.size() > 2) name += text("+", tied.members.size() - 2, "more");
        space_.variables.push_back({name + "." + suffix, kind, first.id, component, 1.0, std::move(moves)});
    }

    void add_scalar(const Tied& tied, VariableKind kind, int where, const std::string& suffix) {
        std::vector<DegreeOfFreedom> moves;
        for (const Tied::Member& member : tied.members) moves.push_back({member.patch * patch_dof::count + where, 1.0});
        add(tied, kind, 0, suffix, std::move(moves));
    }

    void add_vector(const Tied& tied, VariableKind kind, int component, int where, const Eigen::Vector3d& stated,
                    const std::string& suffix) {
        Eigen::Vector3d direction = stated;
        if (!tied.own_image.isZero(0)) {
            const double sense = where == patch_dof::rotation ? tied.own_image.determinant() : 1;
            direction = 0.5 * (stated + sense * tied.own_image * stated);
            if (direction.norm() < 1e-9) return;
            direction.normalize();
        }
        std::vector<DegreeOfFreedom> moves;
        for (const Tied::Member& member : tied.members) {
            Eigen::Vector3d v = member.turn * direction;
            if (where == patch_dof::rotation) v *= member.turn.determinant();
            for (int c = 0; c < 3; ++c)
                if (std::abs(v[c]) > 1e-15) moves.push_back({member.patch * patch_dof::count + where + c, v[c]});
        }
        add(tied, kind, component, suffix, std::move(moves));
    }

    DesignSpace& space_;
    const RestFacts& rest_;
};

FieldSet first_fields(int count) {
    FieldSet set{std::vector<int>(static_cast<std::size_t>(count)), count};
    std::iota(set.numbers.begin(), set.numbers.end(), 0);
    return set;
}

/// One variable each, with unit 1 where none is stated.
void list_user_variables(DesignSpace& space) {
    const auto& user = space.rest->parameters.user_variables;
    for (std::size_t g = 0; g < user.size(); ++g) {
        if (user[g].field >= 0 && !std::ranges::binary_search(space.fields.numbers, user[g].field)) continue;
        Variable variable;
        variable.name = user[g].name;
        variable.kind = user[g].field >= 0            ? VariableKind::field
                        : user[g].planform >= 0       ? VariableKind::planform
                        : user[g].traction.rows() > 0 ? VariableKind::load
                                                      : VariableKind::strain;
        variable.patch = -1;
        variable.component = static_cast<int>(g);
        variable.moves = {{space.num_patch_dofs() + static_cast<int>(g), 1.0}};
        space.variables.push_back(std::move(variable));
    }
}

}  // namespace

int variables_of_a_patch(const Parameters& p) {
    const auto has = [&](VariableKind kind) { return std::ranges::count(p.kinds, kind) > 0; };
    const int directions = p.load_directions.empty() ? 3 : static_cast<int>(p.load_directions.size());
    return directions * has(VariableKind::load) + has(VariableKind::normal_load) +
           3 * (p.strain_rotates + p.strain_translates) * has(VariableKind::strain) + has(VariableKind::stiffness);
}

LevelSet level_set_of(const DesignSpace& space) {
    return {*space.front, space.fields, space.has_patches, space.resting, false};
}

LevelSet level_set(const RestFacts& rest, int level) {
    const Parameters& p = rest.parameters;
    const int finest = static_cast<int>(rest.tree->levels.size()) - 1;
    LevelSet set{front_at(*rest.tree, p.field_steps.empty() ? level : std::min(level, finest)), {}, true};
    if (!p.fields) return set;
    // Strain variables begin at level 1, where the first fields then are.
    const bool has_cores = finest > 0 && std::ranges::find(p.kinds, VariableKind::strain) != p.kinds.end();
    const std::size_t steps = p.field_steps.size(), at = static_cast<std::size_t>(std::max(0, level - has_cores));
    set.fields = first_fields(steps == 0 ? p.fields->size() : p.field_steps[std::min(at, steps - 1)]);
    set.has_patches = level > 0 || finest == 0;  // level 0 of a tree that goes deeper is the fields'
    return set;
}

FieldSet more_fields(const Parameters& parameters, const FieldSet& present) {
    const auto& steps = parameters.field_steps;
    const auto next = std::ranges::upper_bound(steps, present.reach);
    const FieldSet below = first_fields(next == steps.end() ? present.reach : *next);
    FieldSet more{{}, below.reach};
    std::ranges::set_union(present.numbers, below.numbers, std::back_inserter(more.numbers));
    return more;
}

FieldSet offered_fields(const Parameters& parameters, const FieldSet& present) {
    FieldSet offered = more_fields(parameters, present);
    if (parameters.split != SplitRule::sensitivity || parameters.offers_fields_by_steps) return offered;
    while (!parameters.field_steps.empty() && offered.reach < parameters.field_steps.back())
        offered = more_fields(parameters, offered);
    return offered;
}

DesignSpace make_space(std::shared_ptr<const RestFacts> rest, int level, const LevelSet& set,
                       const DesignSpace* parent) {
    DesignSpace space;
    space.rest = std::move(rest);
    space.level = level;
    space.front = std::make_shared<const Front>(set.front);
    space.fields = set.fields;
    space.has_patches = set.has_patches;
    space.resting = set.resting;
    space.carried_user_values =
        Eigen::VectorXd::Zero(static_cast<Eigen::Index>(space.rest->parameters.user_variables.size()));
    place_cores(space, parent);
    list_user_variables(space);
    if (space.has_patches) Candidates(space).list();
    scale_variables(space);
    append_parameters(space);
    return space;
}

DesignSpace design_space(std::shared_ptr<const RestFacts> rest, int level) {
    const LevelSet set = level_set(*rest, level);
    return make_space(std::move(rest), level, set, nullptr);
}

}  // namespace strake
