#pragma once
#include "core/mesh/surface_map.hpp"
#include "core/mesh/surface_unmap.hpp"
#include "core/volume/cell_check.hpp"

#include <optional>
#include <string>
#include <vector>

/// What `strake apply` was asked for, what it did, and how it reports that.
namespace strake::cli {

struct ApplyArguments {
    std::string run, other, out, design, moved, sensitivities;
    std::vector<std::string> hold;
    int evaluation = 0;
    double reach = SurfaceMapOptions{}.reach;
    bool undo = false, force = false, json = false;
};

struct Applied {
    int points = 0, evaluation = 0, on_surface = 0;
    int beyond_reach = 0;  ///< points that cannot move
    double diagonal = 0, max_displacement = 0, max_surface_displacement = 0;
    double min_distance = 0, max_distance = 0;  ///< from the points to the surface
    std::optional<Unmapped> undone;
    std::optional<CellCheck> cells;
    int unchecked_cells = 0;
    std::vector<std::string> lost_columns;  ///< of a list, which the output format cannot hold
    bool written = true;
};

void warn(const ApplyArguments& args, const Applied& applied);  ///< on standard error
void print_json(const ApplyArguments& args, const Applied& applied);
void print_words(const Applied& applied);

}  // namespace strake::cli
