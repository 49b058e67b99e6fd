#include "core/volume/cell_check.hpp"

#include "core/error.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>

namespace strake {
namespace {

using Eigen::Vector3d;

struct Faces {
    Points area, centre;  ///< vectors out of the owner; the mean over the triangles by area
};

Faces measured(const Polygons& faces, const Points& points) {
    Faces out{Points::Zero(faces.size(), 3), Points::Zero(faces.size(), 3)};
    for (int f = 0; f < faces.size(); ++f) {
        const std::span<const int> polygon = faces[f];
        Vector3d middle = Vector3d::Zero(), area = Vector3d::Zero(), sum = Vector3d::Zero();
        for (const int v : polygon) middle += points.row(v).transpose();
        middle /= static_cast<double>(polygon.size());
        double total = 0;
        for (std::size_t k = 0; k < polygon.size(); ++k) {
            const Vector3d a = points.row(polygon[k]), b = points.row(polygon[(k + 1) % polygon.size()]);
            const Vector3d normal = 0.5 * (b - a).cross(middle - a);
            const double size = normal.norm();
            area += normal;
            sum += size * (a + b + middle) / 3;
            total += size;
        }
        out.area.row(f) = area;
        out.centre.row(f) = total > 0 ? Vector3d(sum / total) : middle;
    }
    return out;
}

template <class Visit>  // visit(face, cell, sign)
void over_cells(const VolumeMesh& mesh, const Visit& visit) {
    for (int f = 0; f < mesh.faces.size(); ++f) {
        visit(f, mesh.owner[f], 1.0);
        if (mesh.neighbour[f] >= 0) visit(f, mesh.neighbour[f], -1.0);
    }
}

}  // namespace

CellSizes cell_sizes(const VolumeMesh& mesh, const Points& points) {
    const Faces faces = measured(mesh.faces, points);
    CellSizes out{Eigen::VectorXd::Zero(mesh.num_cells),
                  Eigen::VectorXd::Constant(mesh.num_cells, std::numeric_limits<double>::infinity()),
                  Points::Zero(mesh.num_cells, 3)};
    Eigen::VectorXd area = Eigen::VectorXd::Zero(mesh.num_cells);
    over_cells(mesh, [&](int f, int cell, double) {
        const double size = faces.area.row(f).norm();
        out.centre.row(cell) += size * faces.centre.row(f);
        area[cell] += size;
    });
    for (int c = 0; c < mesh.num_cells; ++c)
        if (area[c] > 0) out.centre.row(c) /= area[c];
    over_cells(mesh, [&](int f, int cell, double sign) {
        const double pyramid = sign * faces.area.row(f).dot(faces.centre.row(f) - out.centre.row(cell)) / 3;
        out.volume[cell] += pyramid;
        out.pyramid[cell] = std::min(out.pyramid[cell], pyramid);
    });
    return out;
}

void orient_by_majority(VolumeMesh& mesh, const std::vector<int>& kinds) {
    const CellSizes sizes = cell_sizes(mesh, mesh.points);
    std::map<int, int> balance;
    for (std::size_t c = 0; c < kinds.size(); ++c)
        balance[kinds[c]] += sizes.volume[static_cast<Eigen::Index>(c)] < 0 ? -1 : 1;
    for (int f = 0; f < mesh.faces.size(); ++f)
        if (const auto cell = static_cast<std::size_t>(mesh.owner[f]); cell < kinds.size() && balance[kinds[cell]] < 0)
            std::reverse(mesh.faces.corners.begin() + mesh.faces.first[f],
                         mesh.faces.corners.begin() + mesh.faces.first[f + 1]);
}

CellCheck check_cells(const VolumeMesh& mesh, const Points& before, const Points& after) {
    for (const Points* points : {&before, &after})
        if (points->rows() != mesh.num_points())
            throw InvalidInput(text("check_cells: ", points->rows(), " points, the mesh has ", mesh.num_points()));
    const CellSizes was = cell_sizes(mesh, before), is = cell_sizes(mesh, after);
    CellCheck out;
    out.cells = mesh.num_cells;
    bool worst_is_bad = false;
    for (int c = 0; c < mesh.num_cells; ++c) {
        // Not "<= 0": NaN counts as inverted.
        const bool bad_before = !(was.volume[c] > 0 && was.pyramid[c] > 0);
        const bool inverted = !(is.volume[c] > 0), folded = !inverted && !(is.pyramid[c] > 0);
        out.inverted_before += !(was.volume[c] > 0);
        out.folded_before += bad_before && was.volume[c] > 0;
        out.inverted += inverted;
        out.folded += folded;
        if (bad_before) continue;
        const bool bad = inverted || folded;
        const double ratio = is.volume[c] / was.volume[c];
        out.newly_bad += bad;
        out.largest_ratio = std::max(out.largest_ratio, ratio);
        out.smallest_ratio = std::min(out.smallest_ratio, ratio);
        if (out.worst >= 0 && !(bad && !worst_is_bad) &&
            (bad != worst_is_bad || ratio >= out.worst_after / out.worst_before))
            continue;
        out.worst = c;
        worst_is_bad = bad;
        out.worst_at = was.centre.row(c);
        out.worst_before = was.volume[c];
        out.worst_after = is.volume[c];
    }
    return out;
}

}  // namespace strake
