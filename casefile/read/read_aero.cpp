#include "casefile/model/built_in.hpp"
#include "casefile/read/case_reader.hpp"
#include "core/formats/io.hpp"
#include "objectives/aero/friction.hpp"
#include "objectives/aero/newtonian.hpp"
#include "objectives/aero/projected_area.hpp"
#include "objectives/aero/wave_drag.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace strake {
namespace {

FlowAngle angle_of(const Value* value, std::vector<Reference>& variables) {
    if (!value) return {};
    if (value->form == Value::Form::scalar) return {value->number};
    const Value* name = value->find("variable");
    if (!name) return {};
    variables.push_back({name->text, name->place});
    return {0, name->text};
}

/// "axes.downstream", from what a quantity gives under its old name.
struct OldDirection {
    const Value* value;
    std::string shown, now;
};

bool contradicts(const Eigen::Vector3d& one, const Eigen::Vector3d& other) { return !((one - other).norm() < 1e-6); }

/// A quantity while it is read.
struct AeroForm {
    const Value& map;
    const std::string& shown;
    const std::filesystem::path& dir;
    const AeroGround& ground;
    Diagnostics& errors;
    BuiltInEntry made = {};

    /// The axes of the case, those of the quantity's old keys, or the default. @param has_up the type has a key `up`
    BodyAxes axes(bool has_up) {
        const OldDirection forward{map.find("forward"), shown + ".forward", "axes.downstream"},
            up{has_up ? map.find("up") : nullptr, shown + ".up", "axes.up"};
        BodyAxes at = ground.axes.value_or(BodyAxes{});
        for (const OldDirection& old : {forward, up})
            if (old.value) {
                errors.note(old.value->place,
                            text("'", old.shown, "' is now called '", old.now, "', stated once for the case"));
                at.is_stated = true;
            }
        if (const auto d = direction_of(forward.value, forward.shown, errors)) {
            if (ground.axes && contradicts(*d, at.downstream)) refuse(forward);
            at.downstream = *d;
        }
        if (const auto d = direction_of(up.value, up.shown, errors)) {
            const Eigen::Vector3d across = *d - d->dot(at.downstream) * at.downstream;
            if (ground.axes && !(across.norm() > 1e-6 && !contradicts(across.normalized(), at.up))) refuse(up);
            at.up = *d;
        }
        made.axes = at;
        return at;
    }

    Stream stream() {
        const BodyAxes at = axes(true);
        Stream stream;
        stream.forward = at.downstream;
        stream.up = at.up;
        stream.alpha = angle_of(map.find("alpha"), made.variables);
        stream.beta = angle_of(map.find("beta"), made.variables);
        return stream;
    }

    /// Of coefficients: half of the whole body's doubles those of the half.
    void set_reference_area(double& area) const {
        set(area, map.find("reference_area"));
        if (ground.symmetry && ground.whole_coefficients) area /= 2;
    }

    /// A half model on whose plane the stream has no component, with the right wing along the plane's normal.
    bool is_symmetric_half(const Stream& stream) const {
        if (!ground.symmetry || stream.beta.value != 0 || !stream.beta.variable.empty()) return false;
        const Eigen::Vector3d& normal = ground.symmetry->normal;
        return std::max(std::abs(normal.dot(stream.forward.stableNormalized())),
                        std::abs(normal.dot(stream.up.stableNormalized()))) <= 1e-6;
    }

private:
    void refuse(const OldDirection& old) const {
        errors.add(old.value->place,
                   text(old.shown, " contradicts ", old.now, " (", line_words(ground.axes->place), "); remove it"));
    }
};

BuiltInEntry read_newtonian(AeroForm& form) {
    const Value& map = form.map;
    NewtonianFlow flow;
    flow.stream = form.stream();
    const Value *mach = map.find("mach"), *cp_max = map.find("cp_max"), *leeward = map.find("leeward"),
                *shadows = map.find("shadows");
    if (!mach && !cp_max) form.errors.add(map.place, text(form.shown, " must have mach or cp_max"));
    set(flow.mach, mach);
    set(flow.gamma, map.find("gamma"));
    if (cp_max) flow.cp_max = cp_max->number;
    if (leeward && leeward->text == "prandtl_meyer") flow.leeward = LeewardPressure::prandtl_meyer;
    if (flow.leeward == LeewardPressure::prandtl_meyer && !mach)
        form.errors.add(leeward->place, text(form.shown, ".leeward: prandtl_meyer needs mach"));
    set(flow.shadows, shadows);
    if (const auto about = vector_of(map.find("moment_center"))) flow.moment_center = *about;
    form.set_reference_area(flow.reference_area);
    set(flow.reference_length, map.find("reference_length"));
    const bool is_symmetric = form.is_symmetric_half(flow.stream);
    if (form.ground.symmetry && form.ground.whole_coefficients && !is_symmetric)
        form.errors.add(map.place, text(form.shown,
                                        ": symmetry.coefficients: whole needs a stream without sideslip (beta) and "
                                        "axes whose downstream and up lie in the symmetry plane"));
    flow.has_side_values = !is_symmetric || form.ground.keeps_side_values;
    for (const std::string& name : newtonian_values)
        (flow.has_side_values || !is_side_value(name) ? form.made.outputs : form.made.omitted).push_back(name);
    form.made.make = [flow](const std::string& name, const QuantityContext& ground) {
        return newtonian(name, ground.start, flow);
    };
    return form.made;
}

BuiltInEntry read_wave_drag(AeroForm& form) {
    const Value& map = form.map;
    WaveDrag flow;
    flow.forward = form.axes(false).downstream;
    set(flow.mach, map.find("mach"));
    form.set_reference_area(flow.reference_area);
    set(flow.stations, map.find("stations"));
    set(flow.angles, map.find("angles"));
    if (const Value* v = map.find("base")) form.made.regions.push_back({v->text, v->place});
    std::filesystem::path beside;
    if (const Value* v = map.find("beside"); v && v->accepted) beside = form.dir / v->text;
    form.made.make = [flow, beside, base = form.made.regions](const std::string& name, const QuantityContext& ground) {
        WaveDrag complete = flow;
        if (!base.empty()) complete.base = ground.marks(base.front());
        if (!beside.empty()) complete.beside = read_surface(beside).mesh;
        return wave_drag(name, ground.start, complete, ground.symmetry);
    };
    return form.made;
}

BuiltInEntry read_friction(AeroForm& form) {
    const Value& map = form.map;
    FrictionFlow flow;
    flow.stream = form.stream();
    set(flow.reynolds_per_length, map.find("reynolds"));
    set(flow.mach, map.find("mach"));
    set(flow.gamma, map.find("gamma"));
    set(flow.temperature, map.find("temperature"));
    form.set_reference_area(flow.reference_area);
    if (const Value* v = map.find("wall_temperature")) flow.wall_temperature = v->number;
    if (const Value* v = map.find("boundary_layer")) flow.turbulent = v->text == "turbulent";
    form.made.make = [flow](const std::string& name, const QuantityContext& ground) {
        return friction(name, ground.start, flow, ground.symmetry);
    };
    return form.made;
}

BuiltInEntry read_projected_area(AeroForm& form) {
    form.made.make = [stream = form.stream()](const std::string& name, const QuantityContext& ground) {
        return projected_area(name, ground.start, stream);
    };
    return form.made;
}

}  // namespace

std::optional<BuiltInEntry> read_aero(const std::string& type, const Value& map, const std::string& shown,
                                      const std::filesystem::path& dir, const AeroGround& ground, Diagnostics& errors) {
    AeroForm form{map, shown, dir, ground, errors};
    if (type == "newtonian") return read_newtonian(form);
    if (type == "wave_drag") return read_wave_drag(form);
    if (type == "friction") return read_friction(form);
    if (type == "projected_area") return read_projected_area(form);
    return {};
}

}  // namespace strake
