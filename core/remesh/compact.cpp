#include "core/remesh/working_mesh.hpp"

#include <algorithm>

/// The working mesh without gaps, and as a value.
namespace strake {
namespace {

/// The numbers i of 0..n with key(i) >= 0 by their keys, all below `keys`; equal ones as they come.
template <class Key>
std::vector<int> sorted_by(int n, int keys, const Key& key) {
    std::vector<int> begin(keys + 1, 0);
    int count = 0;
    for (int i = 0; i < n; ++i)
        if (key(i) >= 0) ++begin[key(i) + 1], ++count;
    for (int k = 0; k < keys; ++k) begin[k + 1] += begin[k];
    std::vector<int> order(count);
    for (int i = 0; i < n; ++i)
        if (key(i) >= 0) order[begin[key(i)]++] = i;
    return order;
}

template <class Keep>
std::vector<int> in_order(int n, const Keep& keep) {
    std::vector<int> order;
    order.reserve(n);
    for (int i = 0; i < n; ++i)
        if (keep(i)) order.push_back(i);
    return order;
}

/// values[order[0]], values[order[1]], …
template <class T>
void take(std::vector<T>& values, const std::vector<int>& order, bool is_ascending) {
    if (is_ascending) {
        for (std::size_t i = 0; i < order.size(); ++i) values[i] = values[order[i]];
        values.resize(order.size());
        return;
    }
    std::vector<T> taken;
    taken.reserve(order.size());
    for (const int i : order) taken.push_back(values[i]);
    values.swap(taken);
}

std::vector<int> inverse(const std::vector<int>& order, int n) {
    std::vector<int> number(n, -1);
    for (std::size_t i = 0; i < order.size(); ++i) number[order[i]] = static_cast<int>(i);
    return number;
}

/// Removes the features of no curve and renumbers the vertices of the others. @return their new numbers
std::vector<int> compact_features(const std::vector<int>& vertex_number, std::vector<FeatureEdge>& features) {
    std::vector<int> number(features.size(), -1);
    int k = 0;
    for (std::size_t f = 0; f < features.size(); ++f) {
        if (features[f].curve < 0) continue;
        features[k] = features[f];
        for (int& v : features[k].v) v = vertex_number[v];
        number[f] = k++;
    }
    features.resize(k);
    return number;
}

}  // namespace

/// After many changes, sorts vertices by their triangles of the input, which are in spatial order, and triangles by
/// their first vertices: neighbours in space become neighbours in memory.
void WorkingMesh::compact(double few) {
    int removed = 0;
    for (int t = 0; t < num_triangles(); ++t) removed += !is_alive(t);
    constexpr double many = 0.05;
    const int made = num_triangles() - compact_triangles;
    const bool sorts = changes + removed + made > many * num_triangles();
    if (!sorts && removed < few * num_triangles()) return;
    changes = sorts ? 0 : changes + removed + made;
    const std::vector<int> vertices = sorts ? sorted_by(num_vertices(), static_cast<int>(base->tri.size()),
                                                        [&](int v) { return half[v] >= 0 ? foot[v] : -1; })
                                            : in_order(num_vertices(), [&](int v) { return half[v] >= 0; });
    const std::vector<int> number = inverse(vertices, num_vertices());
    for (int& v : corner)
        if (v >= 0) v = number[v];
    const int n = static_cast<int>(vertices.size());
    const std::vector<int> triangles =
        sorts ? sorted_by(num_triangles(), n,
                          [&](int t) {
                              return std::min({corner[3 * t], corner[3 * t + 1], corner[3 * t + 2]});
                          })
              : in_order(num_triangles(), [&](int t) { return is_alive(t); });
    compact_triangles = static_cast<int>(triangles.size());
    const std::vector<int> triangle_number = inverse(triangles, num_triangles());
    const std::vector<int> feature_number = compact_features(number, features);

    std::vector<int> halves;
    halves.reserve(3 * triangles.size());
    for (const int t : triangles) halves.insert(halves.end(), {3 * t, 3 * t + 1, 3 * t + 2});
    take(corner, halves, !sorts), take(twin, halves, !sorts), take(feature, halves, !sorts);
    const auto renumber = [&](int h) { return h < 0 ? -1 : 3 * triangle_number[h / 3] + h % 3; };
    for (int& h : twin) h = renumber(h);
    for (int& f : feature) f = f < 0 ? -1 : feature_number[f];
    if (!group.empty()) take(group, triangles, !sorts);
    take(patch, triangles, !sorts);

    take(pos, vertices, !sorts), take(normal, vertices, !sorts), take(foot, vertices, !sorts),
        take(half, vertices, !sorts), take(valence, vertices, !sorts);
    take(origin, vertices, !sorts), take(size, vertices, !sorts), take(limit, vertices, !sorts),
        take(role, vertices, !sorts), take(settled, vertices, !sorts), take(bent, vertices, !sorts);
    for (int& h : half) h = renumber(h);
    mark.assign(n, 0);
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
