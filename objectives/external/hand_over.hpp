#pragma once
#include "core/mesh/surface_map.hpp"
#include "objectives/point_list.hpp"

/// What a program is given beside its request: the surface in its format, and points of its own that move with it.
namespace strake {

/// A program's own points (its boundary or volume mesh), at rest, and the map that moves them.
struct ProgramPoints {
    NumberedPoints rest;
    SurfaceMap map;
    bool as_npy = false;      ///< handed over as points.npy, else as points.csv
    std::string origin = {};  ///< what map and numbers were made from, for `ExternalCommand::cache`
};

/// Formats of files, and "su2-positions": rows `index x y z` as SU2's DV_KIND= SURFACE_FILE reads them.
void check_hand_over_format(const std::string& format);   ///< @throws InvalidInput with the known ones
std::string handed_over_name(const std::string& format);  ///< "surface.obj", "surface_positions.dat"
std::string points_name(const ProgramPoints& points);     ///< "points.npy", "points.csv"

/// Bytes of that file. With `points`, su2-positions lists these under their own numbers, else the vertices counted from
/// 0.
/// @throws OutputError: coordinates that the format cannot hold.
std::string handed_over_bytes(const TriMesh& surface, const std::string& format, const ProgramPoints* points);

}  // namespace strake
