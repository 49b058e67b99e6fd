#pragma once
#include <cmath>
#include <nlohmann/json.hpp>

namespace strake {

/// A number, or null if it is not finite: JSON has no NaN.
inline nlohmann::ordered_json json_number(double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace strake
