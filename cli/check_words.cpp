#include "cli/check_facts.hpp"

#include "casefile/yaml/diagnostics.hpp"
#include "report/json_number.hpp"

#include <fmt/core.h>
#include <cmath>

/// How `strake check` reports its findings.
namespace strake::cli {
namespace {

using Json = nlohmann::ordered_json;

bool is_met(const StartAnswer::Row& row) { return (row.is_equality ? std::abs(row.scaled) : row.scaled) <= 1e-6; }

void print_health(const Checkup& c) {
    const std::size_t crossing = c.pairs ? c.pairs->apart.size() + c.pairs->adjacent.size() : 0;
    fmt::print("health      {}, {} part{}, {} open boundar{}, {}; angles from {:.3g} to {:.4g} degrees\n",
               c.facts.closed ? "closed" : "open", c.facts.components, c.facts.components == 1 ? "" : "s",
               c.loops.size(), c.loops.size() == 1 ? "y" : "ies",
               !c.pairs       ? "intersections not checked"
               : crossing > 0 ? fmt::format("{} pairs of triangles that intersect or coincide", crossing)
                              : "no intersections",
               c.quality.angle_min_deg, c.quality.angle_max_deg);
}

/// Integrals over the triangles do not know the union of parts.
void print_overlap(const CheckFacts& facts) {
    const Checkup& c = facts.health;
    if (!facts.start || !c.pairs || c.pairs->apart.empty() || c.facts.components < 2) return;
    std::vector<std::string> names;
    for (const auto& quantity : facts.start->quantities)
        for (const auto& value : quantity.values)
            if (value.name == "volume" || value.name == "area") names.push_back(value.name);
    if (names.empty()) return;
    fmt::print("note        parts pass through each other: {} of the union {} not known; {}\n", joined(names),
               names.size() == 1 ? "is" : "are",
               "what lies inside another part counts, too, and changes as their cut wanders");
}

void print_parts(const std::vector<HeldPart>& parts) {
    constexpr std::size_t shown = 10;
    for (std::size_t k = 0; k < parts.size() && k < shown && parts.size() > 1; ++k)
        fmt::print("part {:<6} {} triangles, {} held{}{}\n", k, parts[k].triangles, parts[k].held,
                   parts[k].by.empty() ? "" : " by ", joined(parts[k].by));
    if (parts.size() > shown) fmt::print("            and {} more parts (all with --json)\n", parts.size() - shown);
}

void print_space(const SpaceFacts& s) {
    fmt::print("variables   level {}: {} on {} patches", s.level, s.names.size(), s.patches);
    if (!s.dependent.empty()) fmt::print(", {} dependent ones dropped", s.dependent.size());
    if (std::isfinite(s.condition)) fmt::print(", condition {:.3g}", s.condition);
    fmt::print("\n");
    if (s.condition > 1e8)
        fmt::print(
            "note        the condition number is large: some directions barely move the surface; use fewer kinds of "
            "variables "
            "or fewer patches (strake explain parameters)\n");
    for (const std::string& note : s.notes) fmt::print("note        {}\n", note);
    const auto still = std::count(s.moves.begin(), s.moves.end(), 0);
    fmt::print("still       no variable moves {} of {} vertices ({:.3g} %){}\n", still, s.moves.size(),
               s.moves.empty() ? 0.0 : 100.0 * static_cast<double>(still) / static_cast<double>(s.moves.size()),
               s.changes_height ? " (stiffness variables may)" : "");
}

void print_start(const CheckFacts& facts) {
    if (facts.start) {
        if (facts.start->status != "ok") fmt::print("start       {}: {}\n", facts.start->status, facts.start->reason);
        for (const auto& quantity : facts.start->quantities)
            for (const auto& value : quantity.values)
                if (std::isfinite(value.value)) fmt::print("start       {} = {:.10g}\n", value.name, value.value);
        for (const auto& row : facts.start->constraints)
            fmt::print("start       {} {} {:.6g}: {}\n", row.quantity,
                       row.is_equality ? "="
                       : row.scale < 0 ? ">="
                                       : "<=",
                       row.limit, is_met(row) ? "met" : fmt::format("violated, it is {:.6g}", row.value));
    }
    for (const std::string& name : facts.unknown)
        fmt::print("start       {}: computed by a program; strake check --evaluate runs it\n", name);
}

void print_cost(const RunCost& cost) {
    fmt::print(
        "cost        at most {} evaluations of about {} each: {} on an idle machine; about {:.2g} GB of memory\n",
        cost.evaluations, duration_words(cost.seconds_each), duration_words(cost.evaluations * cost.seconds_each),
        cost.memory_bytes / 1e9);
    if (!cost.programs.empty())
        fmt::print("            plus the time of {}; strake check --evaluate measures it\n", joined(cost.programs));
}

std::string percent(double share) { return fmt::format("{:.0f}", std::floor(100 * share + 1e-9)); }

/// A table of motions by level, then what would add the missing ones: a line of the case for those that it helps.
void print_capability(const Capability& can) {
    fmt::print("can make    % of the squared motion, by level:");
    for (std::size_t k = 0; k < can.levels.size(); ++k)
        fmt::print("{} {} ({} variables)", k == 0 ? "" : ",", can.levels[k], can.variables[k]);
    fmt::print("\n");
    for (const MotionShare& motion : can.motions) {
        fmt::print("            {:<12}", motion.name);
        for (const double share : motion.by_level) fmt::print("{:>5}", percent(share));
        if (!motion.remedy.empty()) fmt::print("   {} with {}", percent(motion.with_remedy), motion.remedy);
        fmt::print("\n");
    }
    if (can.levels_not_asked > 0)
        fmt::print("            not asked: {} finer level{} of many variables\n", can.levels_not_asked,
                   can.levels_not_asked == 1 ? "" : "s");
}

void print_border(const CheckFacts& facts) {
    const BorderFacts& border = *facts.border;
    if (border.variable.empty()) return;
    fmt::print(
        "border      normals beside what is held turn by up to {:.2g} degrees at a move of {:.0f} % of the diagonal "
        "({})\n",
        std::max(border.by_fields, border.by_patches), 100 * border.move, border.variable);
    constexpr double a_crease = Parameters::max_border_turn;
    if (border.is_kept)
        fmt::print("            designs keep to {:.0f}: parameters.keep: smooth_border\n", Parameters::max_border_turn);
    else if (border.by_fields > a_crease && !border.is_smooth)
        fmt::print("            fields turn them by {:.2g}; less with parameters.keep: smooth_border\n",
                   border.by_fields);
}

Json capability_json(const Capability& can) {
    Json levels = Json::array(), motions = Json::array();
    for (std::size_t k = 0; k < can.levels.size(); ++k)
        levels.push_back({{"level", can.levels[k]}, {"variables", can.variables[k]}});
    for (const MotionShare& motion : can.motions) {
        motions.push_back({{"motion", motion.name}, {"share", motion.by_level}});
        motions.back()["remedy"] = motion.remedy.empty() ? Json(nullptr) : Json(motion.remedy);
        motions.back()["share_with_remedy"] = motion.remedy.empty() ? Json(nullptr) : json_number(motion.with_remedy);
    }
    return {{"levels", levels}, {"motions", motions}, {"levels_left_out", can.levels_not_asked}};
}

Json space_json(const SpaceFacts& s) {
    Json still = Json::array();
    for (std::size_t v = 0; v < s.moves.size(); ++v)
        if (!s.moves[v]) still.push_back(v);
    return {{"level", s.level},        {"patches", s.patches}, {"variables", s.names},
            {"left_out", s.dependent}, {"notes", s.notes},     {"condition", json_number(s.condition)},
            {"still_vertices", still}};
}

Json start_json(const StartAnswer& start) {
    Json j{
        {"status", start.status}, {"reason", start.reason}, {"values", Json::object()}, {"constraints", Json::array()}};
    for (const auto& quantity : start.quantities)
        for (const auto& value : quantity.values) j["values"][value.name] = json_number(value.value);
    for (const auto& row : start.constraints)
        j["constraints"].push_back({{"quantity", row.quantity},
                                    {"value", json_number(row.value)},
                                    {"limit", json_number(row.limit)},
                                    {"scaled", json_number(row.scaled)},
                                    {"equality", row.is_equality},
                                    {"met", is_met(row)}});
    return j;
}

}  // namespace

std::string duration_words(double seconds) {
    if (!(seconds >= 0)) return "an unknown time";
    if (seconds < 9.95) return fmt::format("{:.2g} s", seconds);
    const auto whole = static_cast<long>(std::min(seconds, 1e15) + 0.5);
    if (whole < 60) return fmt::format("{} s", whole);
    if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
    if (whole < 2 * 86400) return fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
    return fmt::format("{:.3g} days", seconds / 86400);
}

void print_facts(const CheckFacts& facts) {
    print_health(facts.health);
    print_parts(facts.parts);
    if (facts.space) print_space(*facts.space);
    if (facts.can_make) print_capability(*facts.can_make);
    if (facts.border) print_border(facts);
    print_start(facts);
    print_overlap(facts);
    if (facts.cost) print_cost(*facts.cost);
}

void add_facts(Json& j, const CheckFacts& facts) {
    const Checkup& c = facts.health;
    j["health"] = {{"closed", c.facts.closed},
                   {"components", c.facts.components},
                   {"boundary_loops", c.loops.size()},
                   {"intersections", c.pairs ? Json(c.pairs->apart.size() + c.pairs->adjacent.size()) : Json(nullptr)},
                   {"smallest_angle_deg", json_number(c.quality.angle_min_deg)},
                   {"mean_edge", json_number(c.quality.edge_mean)}};
    j["parts"] = Json::array();
    for (const HeldPart& part : facts.parts)
        j["parts"].push_back({{"triangles", part.triangles}, {"held", part.held}, {"by", part.by}});
    j["space"] = facts.space ? space_json(*facts.space) : Json(nullptr);
    j["can_make"] = facts.can_make ? capability_json(*facts.can_make) : Json(nullptr);
    j["border"] = nullptr;
    if (facts.border)
        j["border"] = {{"move", facts.border->move},
                       {"turn_by_fields_deg", facts.border->by_fields},
                       {"turn_by_patches_deg", facts.border->by_patches},
                       {"variable", facts.border->variable},
                       {"kept_deg", facts.border->is_kept ? Json(Parameters::max_border_turn) : Json(nullptr)}};
    j["start"] = facts.start ? start_json(*facts.start) : Json(nullptr);
    j["not_known_at_start"] = facts.unknown;
    j["cost"] = nullptr;
    if (facts.cost)
        j["cost"] = {{"evaluations", facts.cost->evaluations},
                     {"seconds_each", json_number(facts.cost->seconds_each)},
                     {"seconds", json_number(facts.cost->evaluations * facts.cost->seconds_each)},
                     {"memory_bytes", json_number(facts.cost->memory_bytes)},
                     {"programs", facts.cost->programs}};
}

}  // namespace strake::cli
