#include "core/wrap/halves.hpp"

#include "core/mesh/adjacency.hpp"

#include <array>
#include <map>

namespace strake {
namespace {

double height(const SymmetryPlane& plane, const Eigen::RowVector3d& x) {
    return plane.normal.dot(x.transpose()) - plane.offset;
}

/// The foot of the perpendicular; along an axis exactly on the plane.
Eigen::RowVector3d on_plane(const SymmetryPlane& plane, const Eigen::RowVector3d& x) {
    Eigen::Index axis = 0;
    if (plane.normal.cwiseAbs().maxCoeff(&axis) == 1) {
        Eigen::RowVector3d foot = x;
        foot[axis] = plane.offset * plane.normal[axis];
        return foot;
    }
    return x - height(plane, x) * plane.normal.transpose();
}

/// Cuts triangles at the plane, with one new vertex for each edge across it.
class Cutter {
public:
    Cutter(const TriMesh& mesh, const SymmetryPlane& plane, double snap) : mesh_(mesh), plane_(plane) {
        for (int v = 0; v < mesh.num_vertices(); ++v) {
            const double above = height(plane, mesh.vertices.row(v));
            side_.push_back(std::abs(above) <= snap ? 0 : above > 0 ? 1 : -1);
            points_.push_back(side_.back() == 0 ? on_plane(plane, mesh.vertices.row(v)) : mesh.vertices.row(v));
        }
    }

    TriMesh cut() {
        for (int t = 0; t < mesh_.num_triangles(); ++t) add(mesh_.triangles.row(t));
        return used();
    }

private:
    /// What of the triangle is above: a polygon of three or four corners.
    void add(const Eigen::RowVector3i& corners) {
        std::vector<int> polygon;
        bool any_above = false;
        for (int k = 0; k < 3; ++k) {
            const int a = corners[k], b = corners[(k + 1) % 3];
            any_above |= side_[static_cast<std::size_t>(a)] > 0;
            if (side_[static_cast<std::size_t>(a)] >= 0) polygon.push_back(a);
            if (side_[static_cast<std::size_t>(a)] * side_[static_cast<std::size_t>(b)] < 0)
                polygon.push_back(crossing(a, b));
        }
        if (!any_above) return;
        for (std::size_t k = 2; k < polygon.size(); ++k) triangles_.push_back({polygon[0], polygon[k - 1], polygon[k]});
    }

    int crossing(int a, int b) {
        const auto [entry, is_new] = crossing_.try_emplace(std::minmax(a, b), static_cast<int>(points_.size()));
        if (is_new) {
            const auto [low, high] = entry->first;
            const Eigen::RowVector3d x = mesh_.vertices.row(low), y = mesh_.vertices.row(high);
            const double at_x = height(plane_, x), at_y = height(plane_, y);
            points_.push_back(on_plane(plane_, x + at_x / (at_x - at_y) * (y - x)));
        }
        return entry->second;
    }

    /// Without vertices that no triangle uses.
    TriMesh used() const {
        std::vector<int> number(points_.size(), -1);
        for (const auto& t : triangles_)
            for (const int v : t) number[static_cast<std::size_t>(v)] = 0;
        int count = 0;
        for (int& n : number)
            if (n == 0) n = count++;
        TriMesh out;
        out.vertices.resize(count, 3);
        out.triangles.resize(static_cast<Eigen::Index>(triangles_.size()), 3);
        for (std::size_t v = 0; v < points_.size(); ++v)
            if (number[v] >= 0) out.vertices.row(number[v]) = points_[v];
        for (std::size_t t = 0; t < triangles_.size(); ++t)
            for (int k = 0; k < 3; ++k)
                out.triangles(static_cast<Eigen::Index>(t), k) =
                    number[static_cast<std::size_t>(triangles_[t][static_cast<std::size_t>(k)])];
        return out;
    }

    const TriMesh& mesh_;
    const SymmetryPlane& plane_;
    std::vector<int> side_;  ///< per vertex of the mesh: above 1, on the plane 0, below -1
    std::vector<Eigen::RowVector3d> points_;
    std::map<std::pair<int, int>, int> crossing_;
    std::vector<std::array<int, 3>> triangles_;
};

}  // namespace

Eigen::RowVector3d mirrored_point(const SymmetryPlane& plane, const Eigen::RowVector3d& x) {
    return x - 2 * height(plane, x) * plane.normal.transpose();
}

Eigen::RowVector3d mirrored_vector(const SymmetryPlane& plane, const Eigen::RowVector3d& u) {
    return u - 2 * u.dot(plane.normal.transpose()) * plane.normal.transpose();
}

BothHalves with_mirror_image(const TriMesh& half, const SymmetryPlane& plane, double near) {
    const int n = half.num_vertices(), m = half.num_triangles();
    BothHalves both;
    both.image.resize(static_cast<std::size_t>(n));
    int count = n;
    for (int v = 0; v < n; ++v)
        both.image[static_cast<std::size_t>(v)] = std::abs(height(plane, half.vertices.row(v))) <= near ? v : count++;
    both.mesh.vertices.resize(count, 3);
    both.mesh.vertices.topRows(n) = half.vertices;
    both.image.resize(static_cast<std::size_t>(count));
    for (int v = 0; v < n; ++v) {
        const int other = both.image[static_cast<std::size_t>(v)];
        both.image[static_cast<std::size_t>(other)] = v;
        if (other != v) both.mesh.vertices.row(other) = mirrored_point(plane, half.vertices.row(v));
    }
    both.mesh.triangles.resize(2 * m, 3);
    both.mesh.triangles.topRows(m) = half.triangles;
    for (int t = 0; t < m; ++t)
        for (int k = 0; k < 3; ++k)
            both.mesh.triangles(m + t, k) = both.image[static_cast<std::size_t>(half.triangles(t, 2 - k))];
    return both;
}

TriMesh clipped(const TriMesh& mesh, const SymmetryPlane& plane, double snap) {
    return Cutter(mesh, plane, snap).cut();
}

double put_borders_on(const SymmetryPlane& plane, TriMesh& mesh) {
    const Adjacency adjacent = adjacency(mesh);
    double farthest = 0;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (adjacent.edge_triangles[e].size() != 1) continue;
        for (const int v : adjacent.edges[e]) {
            farthest = std::max(farthest, std::abs(height(plane, mesh.vertices.row(v))));
            mesh.vertices.row(v) = on_plane(plane, mesh.vertices.row(v));
        }
    }
    return farthest;
}

}  // namespace strake
