#pragma once
#include "core/mesh/mesh.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <filesystem>
#include <optional>

/// What `apply`, `mix` and `compare` are given: the folder of a run.
namespace strake::cli {

bool is_run_folder(const std::filesystem::path& path);    ///< holds a case.yaml
bool same_triangles(const TriMesh& a, const TriMesh& b);  ///< of as many vertices

/// The surface of a run at its start and as one of its designs has it.
struct Deformation {
    TriMesh rest;
    Points vertices;
    int evaluation = 0;  ///< 0: not of a run
    std::optional<SymmetryPlane> symmetry;
};

/// @param design a stored design; empty: the run's best. @param evaluation one of the ParaView series; 0: `design`.
/// @throws InvalidInput: no run, no design yet, or the evaluation's shape was not kept.
Deformation run_deformation(const std::filesystem::path& run, const std::filesystem::path& design = {},
                            int evaluation = 0);

/// From one surface file to another one of the same triangles. @throws InputError when they are not.
Deformation surface_deformation(const std::filesystem::path& rest, const std::filesystem::path& moved);

}  // namespace strake::cli
