#include "cases/case_source.hpp"
#include "cases/scalars.hpp"

#include <algorithm>

namespace strake {
namespace {

using Vector3 = Eigen::Vector3d;

std::optional<Vector3> vector_of(const Value* list) {
    if (!list || list->entries.size() != 3) return {};
    Vector3 v;
    for (int k = 0; k < 3; ++k) {
        if (!list->entries[k].value.accepted) return {};
        v[k] = list->entries[k].value.number;
    }
    return v;
}

Length length_of(const Value& value) { return {value.number, value.relative}; }

/// A vector of length one. @return nothing, with an error, for the zero vector.
std::optional<Vector3> direction_of(const Value* list, const std::string& shown, Diagnostics& errors) {
    const auto v = vector_of(list);
    if (!v) return {};
    // Scaled first: the squares of 1e-200 or 1e200 leave the range of a double.
    const double largest = v->cwiseAbs().maxCoeff();
    if (largest > 0) return (*v / largest).normalized();
    errors.add(list->place, text(shown, " = [0, 0, 0] has no direction"));
    return {};
}

std::vector<Reference> references(const Value* list) {
    std::vector<Reference> all;
    if (!list) return all;
    for (const Entry& entry : list->entries)
        if (entry.value.accepted) all.push_back({entry.value.text, entry.value.place});
    return all;
}

std::vector<std::string> texts(const Value* list) {
    std::vector<std::string> all;
    for (const Reference& item : references(list)) all.push_back(item.name);
    return all;
}

class Reader {
public:
    Reader(const std::filesystem::path& dir, Case& out, Diagnostics& errors) : dir_(dir), case_(out), errors_(errors) {}

    void read(const Value& root) {
        if (const Value* v = root.find("case")) case_.name = v->text;
        if (const Value* v = root.find("surface")) read_surface_entry(*v);
        if (const Value* v = root.find("regions"))
            for (const Entry& entry : v->entries) read_region(entry);
        case_.fixed = references(root.find("fixed"));
        if (const Value* v = root.find("symmetry")) read_symmetry(*v);
        if (const Value* v = root.find("shell")) read_shell(*v);
        if (const Value* v = root.find("loads")) read_loads(*v);
        if (const Value* v = root.find("strains")) read_strains(*v);
        if (const Value* v = root.find("parameters")) read_parameters(*v);
        if (const Value* v = root.find("quantities"))
            for (const Entry& entry : v->entries) read_quantity(entry);
        if (const Value* v = root.find("objective")) read_objective(*v);
        case_.fit = references(root.find("fit"));
        if (const Value* v = root.find("constraints"))
            for (const Entry& entry : v->entries) read_constraint(entry);
        if (const Value* v = root.find("optimize")) read_optimize(*v);
        if (const Value* v = root.find("output")) read_output(*v);
    }

private:
    const std::filesystem::path& dir_;
    Case& case_;
    Diagnostics& errors_;

    void read_surface_entry(const Value& map) {
        if (const Value* file = map.find("file")) {
            case_.surface = dir_ / file->text;
            case_.surface_place = file->place;
        }
        if (const Value* units = map.find("units")) case_.units = units->text;
    }

    void read_region(const Entry& entry) {
        const Value& map = entry.value;
        Region region{entry.key, ComponentShape{}, entry.key_place, entry.key_place};
        const std::vector<std::string> shapes{"box", "sphere", "plane", "solid", "component", "patch", "triangles"};
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

    bool read_shape(const Value& map, const std::string& kind, Region& region) {
        const Value* value = map.find(kind);
        if (!value) return false;
        const std::string shown = "regions." + region.name;
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
            if (!normal || !at || !side) return false;
            region.shape = HalfSpace{*normal, at->number, side->text == "above"};
        }
        return true;
    }

    bool read_box(const Value& list, const std::string& shown, Region& region) {
        const auto low = vector_of(&list.entries[0].value), high = vector_of(&list.entries[1].value);
        if (!low || !high) return false;
        for (int k = 0; k < 3; ++k)
            if ((*low)[k] > (*high)[k]) {
                errors_.add(list.entries[1].value.place, text(shown, ".box[1][", k, "] = ", (*high)[k],
                                                              " must be >= box[0][", k, "] = ", (*low)[k]));
                return false;
            }
        region.shape = BoxShape{*low, *high};
        return true;
    }

    void read_symmetry(const Value& map) {
        const Value *plane = map.find("plane"), *at = map.find("at");
        if (!plane || !at) return;
        SymmetryPlane symmetry;
        if (plane->form == Value::Form::map) {
            const auto normal = direction_of(plane->find("normal"), "symmetry.plane.normal", errors_);
            if (!normal) return;
            symmetry.normal = *normal;
        } else {
            symmetry.normal = Vector3::Unit(plane->text[0] - 'x');
        }
        symmetry.offset = at->number;
        case_.symmetry = symmetry;
        case_.symmetry_place = map.place;
    }

    void read_shell(const Value& map) {
        if (const Value* spring = map.find("spring")) case_.spring = spring->number;
        if (const Value* mode = map.find("nonmanifold")) case_.couple_nonmanifold = mode->text == "couple";
        const Value* thickness = map.find("thickness");
        if (!thickness) return;
        if (thickness->form == Value::Form::scalar) {
            case_.thickness = length_of(*thickness);
            return;
        }
        for (const Entry& entry : thickness->entries) {
            if (!entry.value.accepted) continue;
            if (entry.key == "default")
                case_.thickness = length_of(entry.value);
            else
                case_.thickness_by_region.push_back({{entry.key, entry.key_place}, length_of(entry.value)});
        }
    }

    void read_loads(const Value& list) {
        for (const Entry& entry : list.entries) {
            const Value& map = entry.value;
            const Value* region = map.find("region");
            if (!map.accepted || !region) continue;
            LoadEntry load;
            load.region = {region->text, region->place};
            load.place = map.place;
            load.traction = vector_of(map.find("traction"));
            load.force = vector_of(map.find("force"));
            if (const Value* v = map.find("displacement")) load.displacement = length_of(*v);
            if (const auto v = direction_of(map.find("direction"), "loads.direction", errors_)) load.direction = *v;
            if (const Value* v = map.find("spring")) load.spring = v->number;
            case_.loads.push_back(std::move(load));
        }
    }

    void read_strains(const Value& list) {
        for (const Entry& entry : list.entries) {
            const Value& map = entry.value;
            const Value* region = map.find("region");
            if (!map.accepted || !region) continue;
            StrainEntry strain;
            strain.region = {region->text, region->place};
            strain.place = map.place;
            const Value* translate = map.find("translate");
            if (vector_of(translate))
                for (int k = 0; k < 3; ++k) strain.translate[k] = length_of(translate->entries[k].value);
            if (const auto v = vector_of(map.find("rotate"))) strain.rotate = *v;
            strain.about = vector_of(map.find("about"));
            if (!map.find("translate") && !map.find("rotate"))
                errors_.add(map.place, "a strain must have translate, rotate or both");
            case_.strains.push_back(std::move(strain));
        }
    }

    void read_parameters(const Value& map) {
        ParameterEntry& p = case_.parameters;
        case_.parameters_place = map.place;
        if (const Value* levels = map.find("levels"); levels && levels->form == Value::Form::list)
            for (const Entry& entry : levels->entries)
                if (entry.value.accepted) p.levels_deg.push_back(degrees(entry.value.number));
        if (const Value* v = map.find("min_patch")) p.min_patch_percent = v->number * 100;
        if (const Value* v = map.find("patches_per_level"))
            for (const Entry& entry : v->entries)
                if (entry.value.accepted) p.patches_per_level.push_back(static_cast<int>(entry.value.number));
        if (const Value* v = map.find("sharp_angle")) p.sharp_angle_deg = degrees(v->number);
        for (const std::string& word : texts(map.find("variables"))) p.variables.push_back(kind_named(word));
        if (const Value* v = map.find("max_displacement")) p.max_displacement = length_of(*v);
        if (const Value* v = map.find("split"); v && v->form == Value::Form::map) read_split(*v);
        p.on = references(map.find("on"));
    }

    static VariableKind kind_named(const std::string& word) {
        if (word == "load") return VariableKind::load;
        if (word == "load_normal") return VariableKind::load_normal;
        return word == "strain" ? VariableKind::strain : VariableKind::stiffness;
    }

    void read_split(const Value& map) {
        SplitEntry& split = case_.parameters.split;
        if (map.entries.size() != 1)
            errors_.add(map.place, "parameters.split must have exactly one of largest, containing");
        if (const Value* v = map.find("largest")) {
            split.kind = SplitEntry::Kind::largest;
            split.largest = static_cast<int>(v->number);
        }
        const Value* containing = map.find("containing");
        if (!containing) return;
        split.kind = SplitEntry::Kind::containing;
        for (const Entry& entry : containing->entries) {
            const Value& value = entry.value;
            if (!value.accepted) continue;
            if (value.form == Value::Form::scalar)
                split.containing.push_back({static_cast<int>(value.number), value.place});
            else if (const auto point = vector_of(value.find("near")))
                split.containing.push_back({NearPoint{*point}, value.place});
        }
    }

    void read_quantity(const Entry& entry) {
        const Value& map = entry.value;
        QuantityEntry quantity{entry.key, entry.key_place, VolumeEntry{}};
        const Value *type = map.find("type"), *command = map.find("command"), *file = map.find("file");
        const bool has_type =
            std::any_of(map.entries.begin(), map.entries.end(), [](auto& e) { return e.key == "type"; });
        const bool has_command =
            std::any_of(map.entries.begin(), map.entries.end(), [](auto& e) { return e.key == "command"; });
        if (map.form == Value::Form::map && has_type == has_command)
            errors_.add(entry.key_place,
                        text("quantities.", printable(entry.key), " must have exactly one of type, command"));
        if (type && type->text == "area") quantity.what = AreaEntry{};
        if (type && type->text == "target_shape") {
            const Value* match = map.find("match");
            quantity.what = TargetShapeEntry{file ? dir_ / file->text : "", match && match->text == "same"};
        }
        if (command) {
            ExternalEntry external;
            external.command = texts(command);
            external.gives = texts(map.find("gives"));
            if (const Value* v = map.find("timeout")) external.timeout_s = v->number;
            if (const Value* v = map.find("format")) external.format = v->text;
            if (const Value* v = map.find("gradients")) external.has_gradients = v->number != 0;
            quantity.what = std::move(external);
        }
        case_.quantities.push_back(std::move(quantity));
    }

    void read_objective(const Value& map) {
        const Value *low = map.find("minimize"), *high = map.find("maximize");
        if (map.entries.size() != 1) errors_.add(map.place, "objective must have exactly one of minimize, maximize");
        const Value* named = low ? low : high;
        if (!named) return;
        case_.objective = {named->text, named->place};
        case_.maximize = named == high;
    }

    void read_constraint(const Entry& entry) {
        const Value& map = entry.value;
        if (!map.accepted) return;
        const std::string shown = "constraints." + printable(entry.key);
        Constraint c;
        c.quantity = entry.key;
        const auto number = [&](const char* key) -> std::optional<double> {
            const Value* v = map.find(key);
            return v ? std::optional<double>(v->number) : std::nullopt;
        };
        c.min = number("min");
        c.max = number("max");
        c.equals = number("equals");
        if (const Value* v = map.find("relative")) c.relative = v->number != 0;
        const auto given = [&](const char* key) {
            return std::any_of(map.entries.begin(), map.entries.end(), [&](auto& e) { return e.key == key; });
        };
        if (!given("min") && !given("max") && !given("equals"))
            errors_.add(entry.key_place, text(shown, " must have min, max or equals"));
        if (given("equals") && (given("min") || given("max")))
            errors_.add(map.find("equals") ? map.find("equals")->place : entry.key_place,
                        text(shown, ".equals excludes min and max"));
        if (c.min && c.max && *c.min > *c.max)
            errors_.add(map.find("min")->place, text(shown, ".min = ", *c.min, " must be <= max = ", *c.max));
        case_.constraints.push_back({c, entry.key_place});
    }

    void read_optimize(const Value& map) {
        OptimizeOptions& o = case_.optimize;
        if (const Value* v = map.find("method"))
            o.method = v->text == "mma"      ? Method::mma
                       : v->text == "lbfgs"  ? Method::lbfgs
                       : v->text == "cobyla" ? Method::cobyla
                                             : Method::slsqp;
        if (const Value* budget = map.find("budget")) {
            if (const Value* v = budget->find("evaluations")) o.max_evaluations = static_cast<int>(v->number);
            if (const Value* v = budget->find("time")) o.max_seconds = v->number;
        }
        if (const Value* refine = map.find("refine_when"))
            if (const Value* v = refine->find("progress_below")) o.progress_below = v->number;
        if (const Value* tolerances = map.find("tolerances")) {
            if (const Value* v = tolerances->find("objective")) o.objective_tolerance = v->number;
            if (const Value* v = tolerances->find("step")) o.step_tolerance = v->number;
            if (const Value* v = tolerances->find("constraint")) o.constraint_tolerance = v->number;
        }
    }

    void read_output(const Value& map) {
        if (const Value* v = map.find("dir"))
            case_.output.dir = dir_ / (v->from_default ? "runs/" + case_.name : v->text);
        if (const Value* v = map.find("paraview"))
            case_.output.paraview = v->text == "best"   ? ParaView::best
                                    : v->text == "none" ? ParaView::none
                                                        : ParaView::every_accepted;
    }
};

}  // namespace

void read_case(const Value& root, const std::filesystem::path& case_dir, Case& the_case, Diagnostics& errors) {
    Reader(case_dir, the_case, errors).read(root);
}

}  // namespace strake
