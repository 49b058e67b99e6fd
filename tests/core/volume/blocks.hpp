#pragma once
#include "core/volume/cell_check.hpp"

#include <array>

/// Volume meshes to test with.
namespace strake {

/// A box of n x n x n hexahedra on [0, 1]^3, numbered as VTK does; faces of each cell are its own.
struct Block {
    Points points;
    std::vector<std::array<int, 8>> cells;
};

inline Block block(int n) {
    Block out;
    const int m = n + 1;
    out.points.resize(m * m * m, 3);
    const auto number = [&](int i, int j, int k) { return i + m * (j + m * k); };
    for (int k = 0; k < m; ++k)
        for (int j = 0; j < m; ++j)
            for (int i = 0; i < m; ++i) out.points.row(number(i, j, k)) << i, j, k;
    out.points /= n;
    for (int k = 0; k < n; ++k)
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i)
                out.cells.push_back({number(i, j, k), number(i + 1, j, k), number(i + 1, j + 1, k), number(i, j + 1, k),
                                     number(i, j, k + 1), number(i + 1, j, k + 1), number(i + 1, j + 1, k + 1),
                                     number(i, j + 1, k + 1)});
    return out;
}

inline VolumeMesh mesh_of(const Block& block) {
    VolumeMesh mesh;
    mesh.points = block.points;
    std::vector<int> kinds;
    for (const auto& cell : block.cells) add_cell(mesh, 12, cell, kinds);
    orient_by_majority(mesh, kinds);
    return mesh;
}

}  // namespace strake
