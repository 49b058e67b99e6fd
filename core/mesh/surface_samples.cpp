#include "core/mesh/surface_samples.hpp"

#include "core/mesh/geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace strake {
namespace {

constexpr int max_levels = 24;
constexpr double coarsest_rel = 0.25;  // of the diagonal

/// The vertices in a frame whose first axis is the plane's normal: images have cells that are images.
Points in_frame(const TriMesh& mesh, const std::optional<SymmetryPlane>& symmetry) {
    const Box box = bounding_box(mesh);
    Eigen::Vector3d origin = 0.5 * (box.min + box.max);
    if (!symmetry) return mesh.vertices.rowwise() - origin.transpose();
    const Eigen::Vector3d& n = symmetry->normal;
    origin -= (n.dot(origin) - symmetry->offset) * n;
    const Eigen::Vector3d a = n.unitOrthogonal(), b = n.cross(a);
    const Points moved = mesh.vertices.rowwise() - origin.transpose();
    Points out(moved.rows(), 3);
    for (Eigen::Index v = 0; v < moved.rows(); ++v)
        out.row(v) << moved.row(v).dot(n), moved.row(v).dot(a), moved.row(v).dot(b);
    return out;
}

double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0;
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

/// Sample per vertex: cells in the order of their coordinates.
int number_cells(const Points& frame, double edge, std::vector<int>& of) {
    std::vector<std::pair<std::array<std::int64_t, 3>, int>> cells;
    for (std::size_t v = 0; v < of.size(); ++v) {
        if (of[v] < 0) continue;
        std::array<std::int64_t, 3> cell{};
        // Rounded, not truncated: a cell is centred at the origin.
        for (int c = 0; c < 3; ++c)
            cell[c] = static_cast<std::int64_t>(std::round(frame(static_cast<Eigen::Index>(v), c) / edge));
        cells.emplace_back(cell, static_cast<int>(v));
    }
    std::sort(cells.begin(), cells.end());
    int count = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (i > 0 && cells[i].first != cells[i - 1].first) ++count;
        of[cells[i].second] = count;
    }
    return cells.empty() ? 0 : count + 1;
}

void add_level(SurfaceSamples& samples, const TriMesh& mesh, double spacing, std::vector<int> of, int count) {
    SurfaceSamples::Level level;
    level.first = samples.size();
    level.spacing = spacing;
    Points position = Points::Zero(count, 3);
    Eigen::VectorXd area = Eigen::VectorXd::Zero(count);
    for (std::size_t v = 0; v < of.size(); ++v)
        if (of[v] >= 0) {
            const auto row = static_cast<Eigen::Index>(v);
            area[of[v]] += samples.vertex_area[row];
            position.row(of[v]) += samples.vertex_area[row] * mesh.vertices.row(row);
        }
    for (int i = 0; i < count; ++i) position.row(i) /= area[i];
    samples.position.conservativeResize(level.first + count, 3);
    samples.position.bottomRows(count) = position;
    samples.area.conservativeResize(level.first + count);
    samples.area.tail(count) = area;
    level.of = std::move(of);
    level.tree = PointTree(position);
    samples.levels.push_back(std::move(level));
}

}  // namespace

Points SurfaceSamples::mean(const Points& at_vertices) const {
    Points out = Points::Zero(size(), 3);
    for (const Level& level : levels)
        for (std::size_t v = 0; v < level.of.size(); ++v)
            if (const int i = level.of[v]; i >= 0) {
                const auto row = static_cast<Eigen::Index>(v);
                out.row(level.first + i) += vertex_area[row] / area[level.first + i] * at_vertices.row(row);
            }
    return out;
}

Points SurfaceSamples::transposed_mean(const Points& at_samples) const {
    Points out = Points::Zero(vertex_area.size(), 3);
    for (const Level& level : levels)
        for (std::size_t v = 0; v < level.of.size(); ++v)
            if (const int i = level.of[v]; i >= 0) {
                const auto row = static_cast<Eigen::Index>(v);
                out.row(row) += vertex_area[row] / area[level.first + i] * at_samples.row(level.first + i);
            }
    return out;
}

SurfaceSamples surface_samples(const TriMesh& mesh, const Eigen::VectorXd& edge_length,
                               const std::optional<SymmetryPlane>& symmetry) {
    SurfaceSamples samples;
    samples.vertex_area = vertex_areas(mesh);
    samples.position.resize(0, 3);
    std::vector<int> of(static_cast<std::size_t>(mesh.num_vertices()), -1);
    std::vector<double> lengths;
    int count = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (samples.vertex_area[v] > 0) {
            of[static_cast<std::size_t>(v)] = count++;
            lengths.push_back(edge_length[v]);
        }
    const double coarsest = coarsest_rel * box_diagonal(mesh);
    const double finest = std::max(quantile(std::move(lengths), 0.01), std::ldexp(coarsest, -max_levels));
    const Points frame = in_frame(mesh, symmetry);
    add_level(samples, mesh, finest, of, count);
    for (double spacing = 2 * finest; spacing < 2 * coarsest; spacing *= 2) {
        const int cells = number_cells(frame, spacing, of);
        add_level(samples, mesh, spacing, of, cells);
    }
    return samples;
}

}  // namespace strake
