#pragma once
#include "core/primo/rest_state.hpp"

namespace strake {

/// Numbers the free prisms anew, from neighbour to neighbour, where the order of the triangles is scattered, as scanned
/// surfaces and much edited ones have it: else every product waits for numbers from all over the memory. Sorts the
/// faces by their prisms. An order that is local is left alone.
void order_locally(RestState& rest);

}  // namespace strake
