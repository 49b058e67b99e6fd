#include "core/remesh/crossings.hpp"

#include "core/mesh/topology.hpp"

#include <algorithm>

namespace strake {

void Crossings::look_at_input() {
    TriMesh input;
    input.vertices.resize(base_.points.size(), 3);
    input.triangles.resize(base_.tri.size(), 3);
    for (std::size_t v = 0; v < base_.points.size(); ++v) input.vertices.row(v) = base_.points[v];
    for (std::size_t t = 0; t < base_.tri.size(); ++t)
        for (int k = 0; k < 3; ++k) input.triangles(t, k) = base_.tri[t][k];
    const Intersections pairs = intersections(input);
    input_pairs_ = static_cast<int>(pairs.apart.size() + pairs.adjacent.size());
    std::vector<char> crosses(base_.tri.size(), 0);
    for (const auto* list : {&pairs.apart, &pairs.adjacent})
        for (const auto& pair : *list)
            for (const int t : pair) crosses[t] = 1;
    crossing_ = crosses;  // and those beside them
    for (std::size_t h = 0; h < base_.twin.size(); ++h)
        if (crosses[h / 3] && base_.twin[h] >= 0) crossing_[base_.twin[h] / 3] = 1;
}

bool Crossings::is_old(const WorkingMesh& mesh, const std::array<int, 2>& pair) const {
    for (const int t : pair)
        for (int h = 3 * t; h < 3 * t + 3; ++h)
            if (crossing_[mesh.foot[mesh.corner[h]]]) return true;
    return false;
}

std::vector<std::array<int, 2>> Crossings::fresh(const WorkingMesh& mesh) {
    Intersections found = intersections(as_mesh(mesh, {}));
    std::vector<std::array<int, 2>> pairs = std::move(found.apart);
    pairs.insert(pairs.end(), found.adjacent.begin(), found.adjacent.end());
    if (pairs.empty()) return pairs;
    if (crossing_.empty()) look_at_input();
    const auto old =
        std::stable_partition(pairs.begin(), pairs.end(), [&](const auto& pair) { return !is_old(mesh, pair); });
    // A fold of a few triangles must not grow; where bodies intersect, the number of pairs may differ.
    const int count = static_cast<int>(pairs.end() - old), few = static_cast<int>(base_.tri.size()) / 200;
    if (count <= input_pairs_ || input_pairs_ > few) pairs.erase(old, pairs.end());
    return pairs;
}

void Crossings::mark_beside(const WorkingMesh& mesh, const std::array<int, 2>& pair, double reach,
                            std::vector<char>& marks) const {
    Eigen::AlignedBox3d box;
    for (const int t : pair)
        for (int h = 3 * t; h < 3 * t + 3; ++h) box.extend(mesh.pos[mesh.corner[h]]);
    box.min().array() -= reach;
    box.max().array() += reach;
    for (std::size_t t = 0; t < base_.tri.size(); ++t) {
        Eigen::AlignedBox3d own;
        for (const int v : base_.tri[t]) own.extend(base_.points[v]);
        if (own.intersects(box)) marks[t] = 1;
    }
}

}  // namespace strake
