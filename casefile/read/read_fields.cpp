#include "casefile/read/case_reader.hpp"

namespace strake {
namespace {

/// From "x" or a list.
std::optional<Eigen::Vector3d> axis_of(const Value* value, const std::string& shown, Diagnostics& errors) {
    if (!value || !value->accepted) return {};
    if (value->form == Value::Form::scalar) return Eigen::Vector3d(Eigen::Vector3d::Unit(value->text[0] - 'x'));
    return direction_of(value, shown, errors);
}

}  // namespace

void CaseReader::read_hold(const Value& value) {
    case_.hold.place = value.place;
    if (!value.accepted) return;
    if (value.form == Value::Form::map) {
        case_.hold.by = HoldEntry::By::point;
        case_.hold.point = vector_of(value.find("point"));
    } else if (value.text != "fixed") {
        case_.hold.by = value.text == "point" ? HoldEntry::By::point : HoldEntry::By::none;
    }
}

void CaseReader::read_invariance(const Value& map) {
    if (!map.accepted) return;
    case_.invariance_place = map.place;
    const Value *extrude = map.find("extrude"), *revolve = map.find("revolve"), *cyclic = map.find("cyclic"),
                *about = map.find("about"), *through = map.find("through");
    if ((extrude != nullptr) + (revolve != nullptr) + (cyclic != nullptr) != 1) {
        errors_.add(map.place, "invariance: exactly one of extrude, revolve, cyclic is needed");
        return;
    }
    if ((about != nullptr) != (cyclic != nullptr)) {
        errors_.add(map.place,
                    about ? "invariance.about belongs to cyclic" : "invariance.cyclic needs its axis, about");
        return;
    }
    if (through && extrude) errors_.add(through->place, "invariance.through belongs to revolve and cyclic");
    ShapeKind kind;
    kind.type = extrude ? ShapeKind::Type::extruded : revolve ? ShapeKind::Type::revolved : ShapeKind::Type::cyclic;
    const auto axis = extrude   ? axis_of(extrude, "invariance.extrude", errors_)
                      : revolve ? axis_of(revolve, "invariance.revolve", errors_)
                                : axis_of(about, "invariance.about", errors_);
    if (!axis) return;
    kind.axis = *axis;
    kind.through = vector_of(through).value_or(Eigen::Vector3d::Zero());
    if (cyclic) set(kind.count, cyclic);
    case_.invariance = kind;
}

void CaseReader::read_fields(const Value& value) {
    FieldsEntry& fields = case_.parameters.fields;
    fields.place = value.place;
    const auto read_number = [&](const Value* number) {
        if (number && number->accepted && number->text != "auto" && number->text != "none")
            fields.number = static_cast<int>(number->number);
    };
    if (value.form == Value::Form::scalar) {
        fields.is_wanted = value.accepted && value.text != "none";
        read_number(&value);
        return;
    }
    fields.is_wanted = value.accepted != nullptr;
    read_number(value.find("number"));
    if (const Value* on = value.find("on"); on && on->accepted) fields.on = Reference{on->text, on->place};
    fields.axis = axis_of(value.find("axis"), "parameters.fields.axis", errors_);
    fields.motions = texts(value.find("motions"));
    if (const Value* along = value.find("along"); along && along->accepted)
        fields.along = along->text == "splines" ? AlongAxis::splines : AlongAxis::polynomials;
    if (const Value* kind = value.find("kind"); kind && kind->accepted)
        fields.kind = kind->text == "wing"       ? FieldsEntry::Kind::wing
                      : kind->text == "sections" ? FieldsEntry::Kind::sections
                                                 : FieldsEntry::Kind::automatic;
}

}  // namespace strake
