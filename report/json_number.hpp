#pragma once
#include <cmath>
#include <nlohmann/json.hpp>

namespace strake {

/// A number, or null where there is none: JSON has no NaN.
inline nlohmann::ordered_json json_number(double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace strake
