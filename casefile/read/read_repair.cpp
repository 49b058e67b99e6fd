#include "casefile/read/case_reader.hpp"

#include <numbers>

namespace strake {
namespace {

bool is_set(const Value& map, const char* key) {
    const Value* v = map.find(key);
    return v && v->text == "true";
}

std::optional<Length> optional_length(const Value& map, const char* key) {
    const Value* v = map.find(key);
    return v ? std::optional(length_of(*v)) : std::nullopt;
}

}  // namespace

void CaseReader::read_repair(const Value& map) {
    RepairEntry entry;
    entry.all = is_set(map, "all");
    entry.weld = optional_length(map, "weld");
    entry.cracks = optional_length(map, "cracks");
    entry.holes = optional_length(map, "holes");
    entry.joints = optional_length(map, "joints");
    if (const Value* v = map.find("holes"); v && v->text == "all")
        entry.holes = Length{std::numeric_limits<double>::infinity(), false};
    RepairOptions& options = entry.options;
    options.duplicates = is_set(map, "duplicates");
    options.degenerate = is_set(map, "degenerate");
    options.orient = is_set(map, "orient");
    options.split = is_set(map, "split");
    options.isolated = is_set(map, "isolated");
    if (const Value* v = map.find("fill"); v && v->text == "smooth") options.fill = HoleFill::smooth;
    if (const Value* parts = map.find("components")) {
        if (const Value* v = parts->find("largest")) options.keep_largest = static_cast<int>(v->number);
        if (const Value* v = parts->find("min_area")) options.min_area_share = v->number;
        if (const Value* v = parts->find("min_triangles")) options.min_triangles = static_cast<int>(v->number);
    }
    entry.place = map.place;
    case_.repair = entry;
}

void CaseReader::read_remesh(const Value& map) {
    RemeshEntry entry;
    if (const Value* v = map.find("edge_length"); v && v->text != "auto") entry.edge_length = length_of(*v);
    entry.chord_error = optional_length(map, "curvature");
    entry.shortest_edge = optional_length(map, "shortest_edge");
    if (const Value* v = map.find("angle")) entry.options.angle_deg = v->number * 180 / std::numbers::pi;
    if (const Value* v = map.find("iterations")) entry.options.iterations = static_cast<int>(v->number);
    if (const Value* v = map.find("gradation")) entry.options.gradation = v->number;
    entry.place = map.place;
    case_.remesh = entry;
}

}  // namespace strake
