#include "casefile/build/problem_builder.hpp"
#include "core/mesh/geometry.hpp"

#include <algorithm>
#include <numeric>

namespace strake {
namespace {

int shared(const std::vector<int>& where, const std::vector<char>& flags) {
    if (flags.empty()) return 0;
    return static_cast<int>(std::count_if(where.begin(), where.end(), [&](int t) { return flags[t] != 0; }));
}

std::string shown(const UserVariableEntry& entry) { return text("parameters.given: '", entry.name, "': "); }

const Place& place_of(const UserVariableEntry& entry) { return entry.region ? entry.region->place : entry.place; }

}  // namespace

void ProblemBuilder::set_user_values() {
    for (const UserVariableEntry& entry : case_.parameters.user_variables) {
        std::vector<int> where(elastic().mesh.num_triangles());
        std::iota(where.begin(), where.end(), 0);
        if (entry.region) where = region_or_patch("parameters.given", *entry.region);
        if (where.empty() || !may_be_user_defined(entry, where)) continue;
        if (entry.kind == UserVariableEntry::Kind::twist) {
            TwistSpec twist{entry.name,   std::move(where), entry.direction,
                            *entry.about, entry.stations,   entry.num_stations};
            twist.max_angle = entry.max_angle.value_or(5 * std::numbers::pi / 180);
            twists_.emplace_back(std::move(twist), entry.place);
            continue;
        }
        UserVariable v = entry.is_motion() ? user_motion(entry, where) : user_load(entry, where);
        v.name = entry.name;
        v.triangles = std::move(where);
        if (entry.is_motion() && entry.region)
            leave_to_motion(region_or_patch_on_surface("parameters.given", *entry.region));
        if (entry.max_displacement) v.max_displacement = entry.max_displacement->in(start_.diagonal) / start_.diagonal;
        out_.problem.parameters.user_variables.push_back(std::move(v));
    }
}

/// Conflicts that names do not show: triangles that are held, frozen or follow another motion.
bool ProblemBuilder::may_be_user_defined(const UserVariableEntry& entry, const std::vector<int>& where) {
    std::vector<char> fixed(elastic().mesh.num_triangles(), 0), held;
    for (const int t : held_triangles()) fixed[t] = 1;
    held = fixed;
    for (const PrescribedStrain& strain : out_.problem.strains)
        for (const int t : strain.triangles) held[t] = 1;
    const int all = static_cast<int>(where.size());
    const auto refuse = [&](int count, const std::string& why) {
        errors_.add(place_of(entry), text(shown(entry), count, " of its ", all, " triangles ", why));
        return false;
    };
    if (!entry.is_motion() && shared(where, held) == all) return refuse(all, "are under fixed or strains");
    if (const int count = shared(where, out_.problem.parameters.frozen); count > 0 && entry.region)
        return refuse(count, "are under parameters.frozen");
    if (!entry.is_motion()) return true;
    if (const int count = shared(where, held); count > 0) return refuse(count, "are also under fixed or strains");
    std::vector<char> mine(elastic().mesh.num_triangles(), 0);
    for (const int t : where) mine[t] = 1;
    for (const Reference& name : case_.parameters.variables_on) {
        const std::vector<int> loaded = region_or_patch("parameters.variables_on", name);
        if (!loaded.empty() && shared(loaded, mine) == static_cast<int>(loaded.size()))
            return refuse(
                static_cast<int>(loaded.size()),
                text("are '", printable(name.name), "' of parameters.variables_on, and leave nothing to load there"));
    }
    for (const UserVariable& other : out_.problem.parameters.user_variables)
        if (const int count = shared(other.triangles, mine);
            other.traction.rows() == 0 && count > 0 && other.triangles != where)
            return refuse(count, text("already follow '", other.name, "'"));
    return true;
}

UserVariable ProblemBuilder::user_load(const UserVariableEntry& entry, const std::vector<int>& where) const {
    UserVariable v;
    v.traction = Points::Zero(static_cast<Eigen::Index>(where.size()), 3);
    if (entry.kind == UserVariableEntry::Kind::load)
        v.traction.rowwise() += entry.direction.transpose();
    else
        v.traction = triangle_normals(elastic().mesh)(where, Eigen::all);
    return v;
}

UserVariable ProblemBuilder::user_motion(const UserVariableEntry& entry, const std::vector<int>& where) {
    UserVariable v;
    if (entry.kind == UserVariableEntry::Kind::translate) v.motion.translation = entry.direction;
    if (entry.kind == UserVariableEntry::Kind::rotate) v.motion.rotation = entry.direction;
    const bool is_region = entry.region && region_index_.contains(entry.region->name);  // of the body, not of its wrap
    v.motion.about = entry.about ? *entry.about
                     : is_region ? area_centroid(start_.mesh, triangles(*entry.region))
                                 : area_centroid(elastic().mesh, where);
    if (entry.max_angle) v.unit = *entry.max_angle;
    // Of a realistic size: it tells whether the motion leaves the plane of symmetry.
    PrescribedStrain moved{where, v.motion};
    moved.motion.translation *= 0.01 * start_.diagonal;
    moved.motion.rotation *= 0.1;
    check_symmetry(place_of(entry), text("parameters.given: '", entry.name, "'"), moved);
    return v;
}

/// The loads of the twists, after everything that the undeformed shell depends on.
void ProblemBuilder::set_twists() {
    if (twists_.empty()) return;
    Problem bare = out_.problem;
    bare.surface = start_.mesh;
    for (const auto& [spec, place] : twists_) {
        const auto refused = [&, where = &place](const std::string& why) {
            return text(printable(case_.file.string(), 400), ":", where->line, ":", where->column,
                        ": parameters.given: ", why);
        };
        at(place, "parameters.given: ", [&, twist = &spec] {
            try {
                TwistVariables made = twist_variables(bare, *twist);
                for (std::size_t k = 0; k < made.held.size(); ++k)
                    if (made.held[k])
                        out_.warnings.push_back(text("parameters.given: '", twist->name, "': the section at station ",
                                                     k + 1, " (", made.stations[k], ") is held: it gets no variable"));
                for (UserVariable& v : made.variables) out_.problem.parameters.user_variables.push_back(std::move(v));
            } catch (const UnheldPart& e) {
                throw UnheldPart(refused(e.what()));
            }
        });
    }
}

}  // namespace strake
