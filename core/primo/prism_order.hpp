#pragma once
#include "core/primo/rest_state.hpp"

namespace strake {

/// Renumbers the free prisms from neighbour to neighbour when the triangles are in scattered order (scanned and heavily
/// edited surfaces), which would slow down products by random memory access. Sorts the faces by their prisms. Keeps an
/// order that is already local.
void order_locally(RestState& rest);

}  // namespace strake
