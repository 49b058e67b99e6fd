#pragma once
#include "objectives/quantity/quantity.hpp"

namespace strake {

/// Thrown within this folder only; `external` turns it into the result's failure.
struct Refused {
    Failure failure;
};

}  // namespace strake
