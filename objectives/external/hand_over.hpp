#pragma once
#include "core/mesh/surface_map.hpp"
#include "objectives/external/point_list.hpp"

/// Files for a program besides its request: the surface in its format, and the program's own points that move with it.
namespace strake {

/// A program's own points (its boundary or volume mesh), at rest, and the map that moves them.
struct ProgramPoints {
    NumberedPoints rest;
    SurfaceMap map;
    bool as_npy = false;      ///< written as points.npy, else as points.csv
    std::string origin = {};  ///< source of map and numbers, for `ExternalCommand::cache`
};

/// Surface formats, and "su2-positions": rows `index x y z` as SU2's DV_KIND= SURFACE_FILE reads them.
void check_hand_over_format(const std::string& format);   ///< @throws InvalidInput with the known ones
std::string handed_over_name(const std::string& format);  ///< "surface.obj", "surface_positions.dat"
std::string points_name(const ProgramPoints& points);     ///< "points.npy", "points.csv"

/// Bytes of that file. su2-positions lists `points` under their own numbers, or the vertices counted from 0.
/// @throws OutputError: coordinates outside the format's range.
std::string handed_over_bytes(const TriMesh& surface, const std::string& format, const ProgramPoints* points);

}  // namespace strake
