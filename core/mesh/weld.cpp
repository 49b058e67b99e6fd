#include "core/mesh/weld.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>

namespace strake {
namespace {

std::uint64_t mixed(std::uint64_t h) {
    h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9ull;
    h = (h ^ (h >> 27)) * 0x94D049BB133111EBull;
    return h ^ (h >> 31);
}

std::uint64_t hash(const double* p) {
    std::uint64_t h = 0;
    for (int k = 0; k < 3; ++k)  // adding 0 turns -0 into 0
        h = mixed(h + 0x9E3779B97F4A7C15ull + std::bit_cast<std::uint64_t>(p[k] + 0.0));
    return h;
}

}  // namespace

std::vector<int> equal_points(const Points& points) {
    const auto n = static_cast<std::size_t>(points.rows());
    const std::size_t mask = std::bit_ceil(2 * n + 1) - 1;
    std::vector<int> table(mask + 1, -1), number(n);  // table: the first point of a class
    int count = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const double* p = points.data() + 3 * i;
        std::size_t slot = hash(p) & mask;
        while (table[slot] >= 0 && !std::equal(p, p + 3, points.data() + 3 * static_cast<std::size_t>(table[slot])))
            slot = (slot + 1) & mask;
        if (table[slot] < 0) {
            table[slot] = static_cast<int>(i);
            number[i] = count++;
        } else {
            number[i] = number[table[slot]];
        }
    }
    return number;
}

TriMesh welded(const TriMesh& mesh) {
    const std::vector<int> number = equal_points(mesh.vertices);
    TriMesh result = mesh;
    int count = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (number[v] == count) result.vertices.row(count++) = mesh.vertices.row(v);
    result.vertices.conservativeResize(count, 3);
    for (int i = 0; i < mesh.triangles.size(); ++i) result.triangles.data()[i] = number[mesh.triangles.data()[i]];
    return result;
}

}  // namespace strake
