#pragma once
#include "core/volume/volume_mesh.hpp"

/// Checks the cells of a volume mesh after its points have moved.
namespace strake {

/// Splits a face into triangles about the mean of its corners and a cell into pyramids over its faces from its centre
/// (the area-weighted mean of the faces' centres), like finite-volume programs; for any number of faces.
struct CellSizes {
    Eigen::VectorXd volume;   ///< per cell, signed: > 0 when its faces look outwards
    Eigen::VectorXd pyramid;  ///< per cell, signed: the smallest pyramid over a face
    Points centre;            ///< per cell
};
CellSizes cell_sizes(const VolumeMesh& mesh, const Points& points);

/// Programs disagree on the orientation of some kinds: when most cells of a kind have negative volume, flips all of
/// that kind. @param kinds per cell, from `add_cell`
void orient_by_majority(VolumeMesh& mesh, const std::vector<int>& kinds);

struct CellCheck {
    int cells = 0;
    int inverted_before = 0, inverted = 0;  ///< volume <= 0
    int folded_before = 0, folded = 0;      ///< volume > 0, but a pyramid over a face <= 0
    int newly_bad = 0;                      ///< inverted or folded now, neither before
    double smallest_ratio = 1;              ///< of volume after and before, over the cells that were good before
    double largest_ratio = 1;
    int worst = -1;  ///< cell of the smallest ratio, among newly bad cells if there are any; -1: no good cells
    Eigen::Vector3d worst_at = Eigen::Vector3d::Zero();  ///< centre of that cell before
    double worst_before = 0, worst_after = 0;            ///< its volume
};

/// From `before` (P x 3) to `after` (P x 3). @throws InvalidInput when a count differs from the mesh's.
CellCheck check_cells(const VolumeMesh& mesh, const Points& before, const Points& after);

}  // namespace strake
