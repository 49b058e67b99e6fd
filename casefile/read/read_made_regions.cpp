#include "casefile/read/case_reader.hpp"

namespace strake {
namespace {

std::optional<FacingDirection> facing_of(const Value& value, const Value* within, const std::string& shown,
                                         Diagnostics& errors) {
    if (!within || !within->accepted || !value.accepted) return {};
    const auto direction = direction_or_word(&value, shown, errors);
    if (!direction) return {};
    return FacingDirection{*direction, within->number};
}

std::optional<FloodedRegion> flood_of(const Value& value) {
    const Value *from = value.find("from"), *angle = value.find("angle");
    if (!from || !angle || !angle->accepted || !from->accepted) return {};
    FloodedRegion flood;
    flood.angle = angle->number;
    if (from->form != Value::Form::list) {
        flood.triangle = static_cast<int>(from->number);
        return flood;
    }
    const auto point = vector_of(from);
    if (!point) return {};
    flood.point = *point;
    return flood;
}

}  // namespace

/// Regions made of other regions, of neighbours and of directions. False: the value was refused.
bool CaseReader::read_made_region(const Value& map, const std::string& kind, const Value& value, Region& region) {
    if (kind == "facing") {
        const auto facing = facing_of(value, map.find("within"), "regions." + region.name + ".facing", errors_);
        if (facing) region.shape = *facing;
        return facing.has_value();
    }
    if (kind == "flood") {
        const auto flood = flood_of(value);
        if (flood) region.shape = *flood;
        return flood.has_value();
    }
    const Value *of = value.find("of"), *far = value.find(kind == "grow" ? "by" : "within");
    if (!of || !of->accepted || !far || !far->accepted) return false;
    if (kind == "grow")
        region.shape = GrownRegion{{of->text, of->place}, length_of(*far)};
    else
        region.shape = NearRegion{{of->text, of->place}, length_of(*far)};
    return true;
}

}  // namespace strake
