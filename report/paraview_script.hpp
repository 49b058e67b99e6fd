#pragma once
#include <string>

namespace strake {

/// series.py of a run folder: a state for ParaView (`paraview --script=series.py`, or File > Load State), which shows
/// the start and the designs side by side, with the same camera and the same colours. It reads series.pvd beside it.
std::string paraview_script();

}  // namespace strake
