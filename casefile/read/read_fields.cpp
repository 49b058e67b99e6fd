#include "casefile/read/case_reader.hpp"

namespace strake {

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
    const Value* axis = value.find("axis");
    if (axis && axis->accepted && axis->form == Value::Form::scalar)
        fields.axis = Eigen::Vector3d::Unit(axis->text[0] - 'x');
    else if (axis)
        fields.axis = direction_of(axis, "parameters.fields.axis", errors_);
}

}  // namespace strake
