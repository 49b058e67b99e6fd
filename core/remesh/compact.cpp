#include "core/remesh/working_mesh.hpp"

/// The working mesh without gaps, and as a value.
namespace strake {

void WorkingMesh::compact() {
    std::vector<int> number(num_vertices(), -1), feature_number(features.size(), -1);
    int n = 0, m = 0, k = 0;
    for (int v = 0; v < num_vertices(); ++v) {
        if (half[v] < 0) continue;
        pos[n] = pos[v], normal[n] = normal[v], foot[n] = foot[v], half[n] = half[v], valence[n] = valence[v];
        origin[n] = origin[v], size[n] = size[v], limit[n] = limit[v], role[n] = role[v], calm[n] = calm[v],
        bent[n] = bent[v];
        number[v] = n++;
    }
    for (std::size_t f = 0; f < features.size(); ++f) {
        if (features[f].curve < 0) continue;
        features[k] = features[f];
        for (int& v : features[k].v) v = number[v];
        feature_number[f] = k++;
    }
    std::vector<int> triangle_number(num_triangles(), -1);
    for (int t = 0; t < num_triangles(); ++t)
        if (is_alive(t)) triangle_number[t] = m++;
    for (int t = 0; t < num_triangles(); ++t) {
        const int to = triangle_number[t];
        if (to < 0) continue;
        for (int i = 0; i < 3; ++i) {
            const int h = 3 * t + i, j = twin[h];
            corner[3 * to + i] = number[corner[h]];
            twin[3 * to + i] = j < 0 ? -1 : 3 * triangle_number[j / 3] + j % 3;
            feature[3 * to + i] = feature[h] < 0 ? -1 : feature_number[feature[h]];
        }
        if (!group.empty()) group[to] = group[t];
        patch[to] = patch[t];
    }
    for (int v = 0; v < n; ++v) half[v] = 3 * triangle_number[half[v] / 3] + half[v] % 3;
    pos.resize(n), normal.resize(n), foot.resize(n), half.resize(n), valence.resize(n);
    origin.resize(n), size.resize(n), limit.resize(n), role.resize(n), calm.resize(n), bent.resize(n),
        mark.assign(n, 0);
    corner.resize(3 * m), twin.resize(3 * m), feature.resize(3 * m), features.resize(k);
    if (!group.empty()) group.resize(m);
    patch.resize(m);
    stamp = 0;
}

TriMesh as_mesh(const WorkingMesh& mesh, const std::vector<std::string>& group_names) {
    TriMesh result;
    std::vector<int> number(mesh.num_vertices()), first(mesh.base->points.size(), -1);
    int n = 0, m = 0;
    result.vertices.resize(mesh.num_vertices(), 3);
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        if (mesh.half[v] < 0) continue;
        const int o = mesh.origin[v];
        if (o >= 0 && first[o] >= 0) {
            number[v] = first[o];
            continue;
        }
        result.vertices.row(n) = mesh.pos[v];
        if (o >= 0) first[o] = n;
        number[v] = n++;
    }
    result.vertices.conservativeResize(n, 3);
    result.triangles.resize(mesh.num_triangles(), 3);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (!mesh.is_alive(t)) continue;
        for (int k = 0; k < 3; ++k) result.triangles(m, k) = number[mesh.corner[3 * t + k]];
        if (!mesh.group.empty()) result.group.push_back(mesh.group[t]);
        ++m;
    }
    result.triangles.conservativeResize(m, 3);
    result.group_names = group_names;
    return result;
}

}  // namespace strake
