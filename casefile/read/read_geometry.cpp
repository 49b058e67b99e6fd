#include "casefile/model/case.hpp"
#include "casefile/read/case_reader.hpp"
#include "core/formats/io.hpp"
#include "objectives/aero/area_distribution.hpp"
#include "objectives/geometry/bending.hpp"
#include "objectives/geometry/clearance.hpp"
#include "objectives/geometry/edge_radius.hpp"
#include "objectives/geometry/extent.hpp"
#include "objectives/geometry/mass_properties.hpp"
#include "objectives/geometry/shape_change.hpp"
#include "objectives/geometry/wall_thickness.hpp"

namespace strake {
namespace {

/// One entry while it is read.
struct Form {
    const std::string& type;
    const Value& map;
    const std::string& shown;
    const std::filesystem::path& dir;
    Diagnostics& errors;
    BuiltInEntry made = {};

    double number(const char* key, double fallback) const {
        const Value* value = map.find(key);
        return value ? value->number : fallback;
    }
    Eigen::Vector3d direction() {
        const auto d = direction_of(map.find("direction"), shown + ".direction", errors);
        return d.value_or(Eigen::Vector3d::UnitX());
    }
    Length smoothing() const {
        const Value* value = map.find("smoothing");
        return value ? length_of(*value) : Length{};
    }
    std::optional<SectionPlane> plane() {
        const Value* plane = map.find("plane");
        if (!plane) return {};
        const auto normal = direction_of(plane->find("normal"), shown + ".plane.normal", errors);
        const Value* at = plane->find("at");
        return SectionPlane{normal.value_or(Eigen::Vector3d::UnitX()), at ? at->number : 0};
    }
};

using RegionNames = std::vector<Reference>;
std::vector<char> marks(const QuantityContext& ground, const RegionNames& region) {
    return region.empty() ? std::vector<char>() : ground.marks(region.front());
}

/// Types without options but a region.
bool read_by_region(Form& form) {
    using Marks = std::vector<char>;
    using Make = std::function<Quantity(const std::string&, const QuantityContext&, const Marks&)>;
    const std::pair<const char*, Make> simple[] = {
        {"bending_energy",
         [](auto& name, auto& on, auto& marks) { return bending_energy(name, on.start, marks, on.symmetry); }},
        {"fairness", [](auto& name, auto& on, auto& marks) { return fairness(name, on.start, marks, on.symmetry); }},
        {"planarity", [](auto& name, auto& on, auto& marks) { return planarity(name, on.start, marks); }},
        {"displacement", [](auto& name, auto& on, auto& marks) { return displacement(name, on.start, marks); }}};
    for (const auto& [type, make] : simple)
        if (form.type == type)
            form.made.make = [make = make, region = form.made.regions](const std::string& name,
                                                                       const QuantityContext& ground) {
                return make(name, ground, marks(ground, region));
            };
    return static_cast<bool>(form.made.make);
}

void read_extents(Form& form) {
    const Eigen::Vector3d direction = form.direction();
    if (form.type == "extent") {
        form.made.outputs = extent_values;
        form.made.make = [direction, s = form.smoothing()](const std::string& name, const QuantityContext& ground) {
            return extent(name, ground.start, direction, s.in(ground.diagonal));
        };
        return;
    }
    const int count = static_cast<int>(form.number("stations", 40));
    for (int i = 1; i <= count; ++i) form.made.outputs.push_back(text(i));
    form.made.make = [direction, count](const std::string& name, const QuantityContext& ground) {
        return section_areas(name, ground.start, direction, count, ground.symmetry);
    };
}

void read_clearance(Form& form) {
    const Value *file = form.map.find("file"), *side = form.map.find("side");
    Clearance what;
    if (file) what.shown = file->text;
    if (side && side->text == "keep_in") what.side = Side::keep_in;
    form.made.make = [what, path = form.dir / what.shown, s = form.smoothing(), region = form.made.regions](
                         const std::string& name, const QuantityContext& ground) {
        Clearance now = what;
        now.smoothing = s.in(ground.diagonal);
        now.region = marks(ground, region);
        return clearance(name, ground.start, read_surface(path).mesh, now);
    };
}

void read_edge_radius(Form& form) {
    if (form.made.regions.empty()) form.errors.add(form.map.place, form.shown + ".region is missing");
    form.made.make = [plane = form.plane(), region = form.made.regions](const std::string& name,
                                                                        const QuantityContext& ground) {
        return edge_radius(name, ground.start, marks(ground, region), plane);
    };
}

void read_symmetry_error(Form& form) {
    const auto plane = form.plane();
    if (!plane) form.errors.add(form.map.place, form.shown + ".plane is missing");
    form.made.make = [plane](const std::string& name, const QuantityContext& ground) {
        return symmetry_error(name, ground.start, {plane->normal, plane->offset});
    };
}

}  // namespace

std::optional<BuiltInEntry> read_geometry(const std::string& type, const Value& map, const std::string& shown,
                                          const std::filesystem::path& dir, Diagnostics& errors) {
    Form form{type, map, shown, dir, errors};
    if (const Value* region = map.find("region")) form.made.regions.push_back({region->text, region->place});
    const RegionNames& region = form.made.regions;
    if (type == "extent" || type == "section_areas") read_extents(form);
    if (type == "clearance") read_clearance(form);
    if (type == "edge_radius") read_edge_radius(form);
    if (type == "symmetry_error") read_symmetry_error(form);
    if (type == "mass_properties") {
        form.made.outputs = mass_property_values();
        form.made.make = [](const std::string& name, const QuantityContext& ground) {
            return mass_properties(name, ground.start, ground.symmetry);
        };
    }
    if (type == "creases")
        form.made.make = [angle = form.number("angle", 0), region](const std::string& name,
                                                                   const QuantityContext& ground) {
            return creases(name, ground.start, angle, marks(ground, region));
        };
    if (type == "wall_thickness") {
        form.made.outputs = wall_thickness_values;
        form.made.make = [p = form.number("sharpness", 60), region](const std::string& name,
                                                                    const QuantityContext& ground) {
            return wall_thickness(name, ground.start, {p, marks(ground, region)}, ground.symmetry);
        };
    }
    if (!form.made.make && !read_by_region(form)) return {};
    return form.made;
}

}  // namespace strake
