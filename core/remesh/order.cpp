#include "core/remesh/order.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace strake {
namespace {

/// Two zero bits after each of the lowest 21.
std::uint64_t spread_bits(std::uint64_t x) {
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffff;
    x = (x | x << 16) & 0x1f0000ff0000ff;
    x = (x | x << 8) & 0x100f00f00f00f00f;
    x = (x | x << 4) & 0x10c30c30c30c30c3;
    return (x | x << 2) & 0x1249249249249249;
}

/// Valid triangles sorted by their centres on the Z-shaped curve (Morton 1966); stable.
std::vector<int> order_of_triangles(const TriMesh& mesh) {
    const Eigen::RowVector3d low = mesh.vertices.colwise().minCoeff(), high = mesh.vertices.colwise().maxCoeff();
    const double extent = (high - low).maxCoeff(), scale = extent > 0 ? 2097151 / extent : 0;
    std::vector<std::pair<std::uint64_t, int>> keys;
    keys.reserve(mesh.num_triangles());
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const int a = mesh.triangles(t, 0), b = mesh.triangles(t, 1), c = mesh.triangles(t, 2);
        if (a == b || b == c || c == a) continue;
        const Eigen::RowVector3d x =
            ((mesh.vertices.row(a) - low) + (mesh.vertices.row(b) - low) + (mesh.vertices.row(c) - low)) / 3 * scale;
        std::uint64_t key = 0;
        for (int k = 0; k < 3; ++k) key |= spread_bits(static_cast<std::uint64_t>(std::max(0.0, x[k]))) << k;
        keys.push_back({key, t});
    }
    std::sort(keys.begin(), keys.end());
    std::vector<int> order;
    order.reserve(keys.size());
    for (const auto& [key, t] : keys) order.push_back(t);
    return order;
}

}  // namespace

TriMesh in_order_of_space(const TriMesh& mesh) {
    TriMesh result;
    result.group_names = mesh.group_names;
    if (mesh.num_triangles() == 0) return result;
    const std::vector<int> order = order_of_triangles(mesh);
    std::vector<int> number(mesh.num_vertices(), -1);
    int vertices = 0, triangles = 0;
    result.vertices.resize(mesh.num_vertices(), 3);
    result.triangles.resize(static_cast<Eigen::Index>(order.size()), 3);
    for (const int t : order) {
        for (int k = 0; k < 3; ++k) {
            const int v = mesh.triangles(t, k);
            if (number[v] < 0) {
                result.vertices.row(vertices) = mesh.vertices.row(v);
                number[v] = vertices++;
            }
            result.triangles(triangles, k) = number[v];
        }
        if (!mesh.group.empty()) result.group.push_back(mesh.group[t]);
        ++triangles;
    }
    result.vertices.conservativeResize(vertices, 3);
    return result;
}

}  // namespace strake
