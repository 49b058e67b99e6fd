#include "casefile/model/built_in.hpp"
#include "casefile/read/case_reader.hpp"
#include "objectives/aero/friction.hpp"
#include "objectives/aero/newtonian.hpp"
#include "objectives/aero/projected_area.hpp"
#include "objectives/aero/wave_drag.hpp"

namespace strake {
namespace {

void set(double& number, const Value* value) {
    if (value) number = value->number;
}

FlowAngle angle_of(const Value* value, std::vector<Reference>& variables) {
    if (!value) return {};
    if (value->form == Value::Form::scalar) return {value->number};
    const Value* name = value->find("variable");
    if (!name) return {};
    variables.push_back({name->text, name->place});
    return {0, name->text};
}

Stream stream_of(const Value& map, const std::string& shown, std::vector<Reference>& variables, Diagnostics& errors) {
    Stream stream;
    if (const auto d = direction_of(map.find("forward"), shown + ".forward", errors)) stream.forward = *d;
    if (const auto d = direction_of(map.find("up"), shown + ".up", errors)) stream.up = *d;
    stream.alpha = angle_of(map.find("alpha"), variables);
    stream.beta = angle_of(map.find("beta"), variables);
    return stream;
}

BuiltInEntry read_newtonian(const Value& map, const std::string& shown, Diagnostics& errors) {
    BuiltInEntry made;
    NewtonianFlow flow;
    flow.stream = stream_of(map, shown, made.variables, errors);
    const Value *mach = map.find("mach"), *cp_max = map.find("cp_max"), *leeward = map.find("leeward"),
                *shadows = map.find("shadows");
    if (!mach && !cp_max) errors.add(map.place, text(shown, " must have mach or cp_max"));
    set(flow.mach, mach);
    set(flow.gamma, map.find("gamma"));
    if (cp_max) flow.cp_max = cp_max->number;
    if (leeward && leeward->text == "prandtl_meyer") flow.leeward = LeewardPressure::prandtl_meyer;
    if (flow.leeward == LeewardPressure::prandtl_meyer && !mach)
        errors.add(leeward->place, text(shown, ".leeward: prandtl_meyer needs mach"));
    if (shadows) flow.shadows = shadows->number != 0;
    if (const auto about = vector_of(map.find("moment_center"))) flow.moment_center = *about;
    set(flow.reference_area, map.find("reference_area"));
    set(flow.reference_length, map.find("reference_length"));
    made.outputs = newtonian_values;
    made.make = [flow](const std::string& name, const QuantityContext& ground) {
        return newtonian(name, ground.start, flow);
    };
    return made;
}

BuiltInEntry read_wave_drag(const Value& map, const std::string& shown, Diagnostics& errors) {
    BuiltInEntry made;
    WaveDrag flow;
    if (const auto d = direction_of(map.find("forward"), shown + ".forward", errors)) flow.forward = *d;
    set(flow.mach, map.find("mach"));
    set(flow.reference_area, map.find("reference_area"));
    if (const Value* v = map.find("stations")) flow.stations = static_cast<int>(v->number);
    if (const Value* v = map.find("angles")) flow.angles = static_cast<int>(v->number);
    if (const Value* v = map.find("base")) made.regions.push_back({v->text, v->place});
    made.make = [flow, base = made.regions](const std::string& name, const QuantityContext& ground) {
        WaveDrag with_base = flow;
        if (!base.empty()) with_base.base = ground.marks(base.front());
        return wave_drag(name, ground.start, with_base, ground.symmetry);
    };
    return made;
}

BuiltInEntry read_friction(const Value& map, const std::string& shown, Diagnostics& errors) {
    BuiltInEntry made;
    FrictionFlow flow;
    flow.stream = stream_of(map, shown, made.variables, errors);
    set(flow.reynolds_per_length, map.find("reynolds"));
    set(flow.mach, map.find("mach"));
    set(flow.gamma, map.find("gamma"));
    set(flow.temperature, map.find("temperature"));
    set(flow.reference_area, map.find("reference_area"));
    if (const Value* v = map.find("wall_temperature")) flow.wall_temperature = v->number;
    if (const Value* v = map.find("boundary_layer")) flow.turbulent = v->text == "turbulent";
    made.make = [flow](const std::string& name, const QuantityContext& ground) {
        return friction(name, ground.start, flow, ground.symmetry);
    };
    return made;
}

}  // namespace

std::optional<BuiltInEntry> read_aero(const std::string& type, const Value& map, const std::string& shown,
                                      Diagnostics& errors) {
    if (type == "newtonian") return read_newtonian(map, shown, errors);
    if (type == "wave_drag") return read_wave_drag(map, shown, errors);
    if (type == "friction") return read_friction(map, shown, errors);
    if (type == "projected_area") {
        BuiltInEntry made;
        const Stream stream = stream_of(map, shown, made.variables, errors);
        made.make = [stream](const std::string& name, const QuantityContext& ground) {
            return projected_area(name, ground.start, stream);
        };
        return made;
    }
    return {};
}

}  // namespace strake
