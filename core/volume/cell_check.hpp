#pragma once
#include "core/volume/volume_mesh.hpp"

/// Do the cells of a volume mesh survive when its points move?
namespace strake {

/// A face is cut into triangles about the mean of its corners, a cell into pyramids over its faces from its centre (the
/// mean of the faces' centres by area): what finite-volume programs do, for cells with any number of faces.
struct CellSizes {
    Eigen::VectorXd volume;   ///< per cell, signed: > 0 when its faces look outwards
    Eigen::VectorXd pyramid;  ///< per cell, signed: the smallest pyramid over a face
    Points centre;            ///< per cell
};
CellSizes cell_sizes(const VolumeMesh& mesh, const Points& points);

struct CellCheck {
    int cells = 0;
    int inverted_before = 0, inverted = 0;  ///< volume <= 0
    int folded_before = 0, folded = 0;      ///< volume > 0, but a pyramid over a face <= 0
    int newly_bad = 0;                      ///< inverted or folded now, neither before
    double smallest_ratio = 1;              ///< of volume after and before, over the cells that were good before
    double largest_ratio = 1;
    int worst = -1;  ///< where the smallest ratio is; where cells have gone bad: among these. -1: no good cells
    Eigen::Vector3d worst_at = Eigen::Vector3d::Zero();  ///< centre of that cell before
    double worst_before = 0, worst_after = 0;            ///< its volume
};

/// From `before` (P x 3) to `after` (P x 3). @throws InvalidInput on another count than the mesh's.
CellCheck check_cells(const VolumeMesh& mesh, const Points& before, const Points& after);

}  // namespace strake
