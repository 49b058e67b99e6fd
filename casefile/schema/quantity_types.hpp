#pragma once
#include <string>
#include <vector>

/// The built-in quantities: the words of `quantities.*.type`.
namespace strake {

struct QuantityType {
    std::string word;
    std::string doc;     ///< one sentence
    std::string values;  ///< names behind the dot; empty: one value, named like the quantity
};
const std::vector<QuantityType>& quantity_types();
std::vector<std::string> quantity_type_words();

/// What to use for a goal that is not a quantity, "drag"; empty: no idea.
std::string quantity_hint(const std::string& goal);

}  // namespace strake
