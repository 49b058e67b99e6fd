#pragma once
#include "core/fields/invariance.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <filesystem>
#include <optional>

/// Run folders as arguments of `apply`, `mix` and `compare`.
namespace strake::cli {

bool is_run_folder(const std::filesystem::path& path);    ///< contains a case.yaml
bool same_triangles(const TriMesh& a, const TriMesh& b);  ///< and the same number of vertices

/// The start surface of a run and one of its designs.
struct Deformation {
    TriMesh rest;
    Points vertices;
    int evaluation = 0;  ///< 0: not from a run
    std::optional<SymmetryPlane> symmetry;
    std::optional<ShapeKind> kind;  ///< that every design of the run keeps
};

/// @param design a stored design; empty: the run's best. @param evaluation one from the ParaView series; 0: use
/// `design`.
/// @throws InvalidInput: not a run, no design yet, or the evaluation's shape was not kept.
Deformation run_deformation(const std::filesystem::path& run, const std::filesystem::path& design = {},
                            int evaluation = 0);

/// From one surface file to another with the same triangles. @throws InputError if they differ.
Deformation surface_deformation(const std::filesystem::path& rest, const std::filesystem::path& moved);

}  // namespace strake::cli
