#include "casefile/check/cheap_models.hpp"

#include "optimize/nlp/program/methods.hpp"

#include <algorithm>
#include <set>

namespace strake {
namespace {

using Names = std::vector<std::string>;

bool holds(const Names& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

const QuantityEntry* quantity_of(const Case& c, const std::string& value) {
    for (const QuantityEntry& quantity : c.quantities)
        if (holds(quantity.value_names(), value)) return &quantity;
    return nullptr;
}

/// Volume and area have no entry before they are used.
bool is_value(const Case& c, const std::string& name) {
    return name == "volume" || name == "area" || quantity_of(c, name);
}

/// The quantities that a value is made of, formulas and their parts.
void add_parts(const Case& c, const std::string& value, std::set<const QuantityEntry*>& parts) {
    const QuantityEntry* quantity = quantity_of(c, value);
    if (!quantity || !parts.insert(quantity).second) return;
    if (const auto* formula = std::get_if<FormulaEntry>(&quantity->what))
        for (const std::string& part : formula->of) add_parts(c, part, parts);
}

/// The quantities that objective and constraints take.
std::set<const QuantityEntry*> asked_for(const Case& c) {
    std::set<const QuantityEntry*> asked;
    add_parts(c, c.objective.name, asked);
    for (const ConstraintEntry& constraint : c.constraints) add_parts(c, constraint.constraint.quantity, asked);
    return asked;
}

class Reader {
public:
    Reader(const Case& c, const QuantityEntry& quantity, const ExternalEntry& program, Diagnostics& errors)
        : case_(c), quantity_(quantity), program_(program), errors_(errors) {}

    void add_to(std::vector<CheapModel>& models) {
        if (program_.low_fidelity.empty())
            refuse(program_.low_fidelity_place, "names nothing; write a quantity, or a map of outputs to values");
        for (const auto& [output, low] : program_.low_fidelity) {
            if (output.name.empty())
                add_all(low, models);
            else if (!holds(program_.outputs, output.name))
                refuse(output.place, text("the program has no output '", printable(output.name), "'",
                                          program_.outputs.empty() ? "; it has one value: write the name alone"
                                                                   : text("; outputs: ", joined(program_.outputs))));
            else
                add(text(quantity_.name, ".", output.name), low, models);
        }
    }

private:
    void refuse(const Place& place, const std::string& why) {
        errors_.add(place, text("quantities.", printable(quantity_.name), ".low_fidelity: ", why));
    }

    /// A whole quantity: the values of the same names.
    void add_all(const Reference& low, std::vector<CheapModel>& models) {
        if (program_.outputs.empty()) return add(quantity_.name, low, models);
        const auto is_named = [&](const QuantityEntry& q) { return q.name == low.name; };
        const auto named = std::find_if(case_.quantities.begin(), case_.quantities.end(), is_named);
        if (named == case_.quantities.end()) {
            if (is_value(case_, low.name))
                return refuse(low.place,
                              text("'", low.name, "' is one value, and the program has ", program_.outputs.size(),
                                   ": write a map, for example {", program_.outputs[0], ": ", low.name, "}"));
            return unknown(low);
        }
        bool any = false;
        for (const std::string& output : program_.outputs) {
            const std::string value = text(low.name, ".", output);
            if (!quantity_of(case_, value)) continue;
            any = true;
            add(text(quantity_.name, ".", output), {value, low.place}, models);
        }
        if (!any)
            refuse(low.place,
                   text("'", low.name, "' has no value of the same name as one of ", joined(program_.outputs),
                        ": write a map, for example {", program_.outputs[0], ": ", named->value_names()[0], "}"));
    }

    void add(const std::string& value, const Reference& low, std::vector<CheapModel>& models) {
        if (!is_value(case_, low.name)) return unknown(low);
        std::set<const QuantityEntry*> parts;
        add_parts(case_, low.name, parts);
        if (parts.count(&quantity_))
            return refuse(low.place, text("'", low.name, "' depends on '", quantity_.name,
                                          "' itself; a cheap model is another quantity"));
        models.push_back({value, low.name});
    }

    void unknown(const Reference& low) {
        const Names known = known_values(case_);
        Names candidates = known;  // a whole quantity may be meant, too
        for (const QuantityEntry& quantity : case_.quantities) candidates.push_back(quantity.name);
        const std::string near = nearest(low.name, candidates);
        refuse(low.place, text("quantity '", printable(low.name), "' is not known",
                               near.empty() ? "" : text("; did you mean '", near, "'?"), near.empty() ? "; q" : " Q",
                               "uantities: ", joined(known)));
    }

    const Case& case_;
    const QuantityEntry& quantity_;
    const ExternalEntry& program_;
    Diagnostics& errors_;
};

/// A cheap model of what nobody asks for would be ignored; so would that of a cheap model.
void refuse_unused(const Case& c, const std::vector<CheapModel>& models, const std::vector<const QuantityEntry*>& of,
                   Diagnostics& errors) {
    if (c.objective.name.empty()) return;
    const std::set<const QuantityEntry*> asked = asked_for(c);
    for (const QuantityEntry* quantity : of) {
        if (asked.contains(quantity)) continue;
        const auto stands_in = std::ranges::find_if(models, [&](const CheapModel& model) {
            std::set<const QuantityEntry*> parts;
            add_parts(c, model.low, parts);
            return parts.contains(quantity);
        });
        const std::string shown = text("quantities.", printable(quantity->name), ".low_fidelity: ");
        const Place& place = std::get<ExternalEntry>(quantity->what).low_fidelity_place;
        if (stands_in != models.end())
            errors.add(place,
                       text(shown, "'", printable(quantity->name), "' is itself the cheap model of '", stands_in->value,
                            "', and a chain of cheap models is not used; remove this one, or "
                            "name it in place of '",
                            printable(quantity->name), "'"));
        else
            errors.add(place, text(shown, "neither the objective nor a constraint takes '", printable(quantity->name),
                                   "'; remove low_fidelity, or state it for the program that they take"));
    }
}

}  // namespace

std::vector<CheapModel> cheap_models(const Case& c, Diagnostics& errors) {
    std::vector<CheapModel> models;
    std::vector<const QuantityEntry*> have_models;
    for (const QuantityEntry& quantity : c.quantities) {
        const auto* program = std::get_if<ExternalEntry>(&quantity.what);
        if (!program || program->low_fidelity_place.line == 0) continue;
        if (!c.fit.empty())
            errors.add(program->low_fidelity_place, "low_fidelity is not used by fit");
        else if (c.optimize.method != Method::sqp)
            errors.add(program->low_fidelity_place, text("low_fidelity needs optimize.method: sqp; ",
                                                         method_facts(c.optimize.method).name, " does not use it"));
        Reader(c, quantity, *program, errors).add_to(models);
        have_models.push_back(&quantity);
    }
    refuse_unused(c, models, have_models, errors);
    return models;
}

std::vector<const QuantityEntry*> cheap_programs(const Case& c, const std::vector<CheapModel>& models) {
    std::set<const QuantityEntry*> parts;
    for (const CheapModel& model : models) add_parts(c, model.low, parts);
    std::vector<const QuantityEntry*> programs;
    for (const QuantityEntry& quantity : c.quantities)
        if (parts.count(&quantity) && std::holds_alternative<ExternalEntry>(quantity.what))
            programs.push_back(&quantity);
    return programs;
}

}  // namespace strake
