#include "casefile/read/case_reader.hpp"
#include "casefile/schema/scalars.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace strake {

void CaseReader::read_surface_entry(const Value& map) {
    if (const Value* file = map.find("file")) {
        case_.surface = dir_ / file->text;
        case_.surface_place = file->place;
    }
    if (const Value* units = map.find("units")) case_.units = units->text;
}

void CaseReader::read_region(const Entry& entry) {
    const Value& map = entry.value;
    Region region;
    region.name = entry.key;
    region.place = region.shape_place = entry.key_place;
    if (map.form == Value::Form::scalar && map.accepted) {
        region.shape = RegionFormula{map.text};
        region.shape_place = map.place;
        case_.regions.push_back(std::move(region));
        return;
    }
    const std::vector<std::string> shapes{"box",       "sphere", "plane", "solid", "component", "patch",
                                          "triangles", "grow",   "flood", "near",  "facing",    "of"};
    std::vector<std::string> given;
    for (const Entry& inside : map.entries)
        if (std::find(shapes.begin(), shapes.end(), inside.key) != shapes.end()) {
            given.push_back(inside.key);
            region.shape_place = inside.value.place;
        }
    if (map.form == Value::Form::map && given.size() != 1)
        errors_.add(entry.key_place, text("regions.", printable(entry.key), " must have exactly one of ",
                                          joined(shapes), "; it has ", given.empty() ? "none" : joined(given)));
    const bool legal = given.size() == 1 && read_shape(map, given[0], region);
    // A region that is declared wrongly is still declared: no second error where it is referenced.
    if (!legal) region.shape = ComponentShape{};
    case_.regions.push_back(std::move(region));
}

bool CaseReader::read_shape(const Value& map, const std::string& kind, Region& region) {
    const Value* value = map.find(kind);
    if (!value) return false;
    const std::string shown = "regions." + region.name;
    if (const Value* touch = map.find("touch")) region.touches = touch->text == "any";
    if (kind == "grow" || kind == "flood" || kind == "near" || kind == "facing")
        return read_made_region(map, kind, *value, region);
    if (kind == "of") return read_wing_region(map, *value, region);
    if (kind == "solid") region.shape = SolidShape{value->text};
    if (kind == "component") region.shape = ComponentShape{static_cast<int>(value->number)};
    if (kind == "patch") region.shape = PatchShape{value->text};
    if (kind == "triangles") region.shape = TriangleFile{dir_ / value->text};
    if (kind == "box") return read_box(*value, shown, region);
    if (kind == "sphere") {
        const auto center = vector_of(value->find("center"));
        const Value* radius = value->find("radius");
        if (!center || !radius) return false;
        region.shape = SphereShape{*center, length_of(*radius)};
    }
    if (kind == "plane") {
        const auto normal = direction_of(value->find("normal"), shown + ".plane.normal", errors_);
        const Value *at = value->find("at"), *side = map.find("side");
        if (side && side->text != "above" && side->text != "below") {
            errors_.add(side->place, text(shown, ".side of a plane must be above or below"));
            return false;
        }
        if (!normal || !at || !side) return false;
        region.shape = HalfSpace{*normal, at->number, side->text == "above"};
    }
    return true;
}

bool CaseReader::read_box(const Value& list, const std::string& shown, Region& region) {
    const auto low = vector_of(&list.entries[0].value), high = vector_of(&list.entries[1].value);
    if (!low || !high) return false;
    for (int k = 0; k < 3; ++k)
        if ((*low)[k] > (*high)[k]) {
            errors_.add(list.entries[1].value.place,
                        text(shown, ".box[1][", k, "] = ", (*high)[k], " must be >= box[0][", k, "] = ", (*low)[k]));
            return false;
        }
    region.shape = BoxShape{*low, *high};
    return true;
}

void CaseReader::read_symmetry(const Value& map) {
    const Value *plane = map.find("plane"), *at = map.find("at");
    if (!plane || !at) return;
    SymmetryPlane symmetry;
    if (plane->form == Value::Form::map) {
        const auto normal = direction_of(plane->find("normal"), "symmetry.plane.normal", errors_);
        if (!normal) return;
        symmetry.normal = *normal;
    } else {
        symmetry.normal = Eigen::Vector3d::Unit(plane->text[0] - 'x');
    }
    symmetry.offset = at->number;
    case_.symmetry = symmetry;
    case_.symmetry_place = map.place;
    case_.aero.symmetry = symmetry;
    if (const Value* snap = map.find("snap")) case_.symmetry_snap = length_of(*snap);
    const Value* coefficients = map.find("coefficients");
    case_.aero.whole_coefficients = coefficients && coefficients->text == "whole";
    // The case of a run folder holds every key; without this one it began when there were no such rules.
    case_.aero.keeps_side_values = coefficients && coefficients->from_default && !case_.command_dir.empty();
}

void CaseReader::read_axes(const Value& map) {
    const auto downstream = direction_or_word(map.find("downstream"), "axes.downstream", errors_),
               up = direction_or_word(map.find("up"), "axes.up", errors_);
    if (!downstream || !up) return;
    constexpr double square = 1e-3;  // directions rounded to four digits
    if (std::abs(downstream->dot(*up)) > square) {
        const double between = std::acos(std::clamp(downstream->dot(*up), -1.0, 1.0));
        errors_.add(map.place, text("axes: downstream and up must be perpendicular; the angle between them is ",
                                    degrees(between), "deg"));
        return;
    }
    case_.aero.axes = {*downstream, (*up - up->dot(*downstream) * *downstream).normalized(), true, map.place};
}

}  // namespace strake
