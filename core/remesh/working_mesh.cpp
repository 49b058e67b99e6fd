#include "core/remesh/working_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace strake {

using Eigen::Vector3d;

WorkingMesh working_mesh(const BaseSurface& base) {
    WorkingMesh mesh;
    mesh.base = &base;
    const std::size_t n = base.points.size(), m = base.tri.size();
    mesh.pos = base.points;
    mesh.role = base.role;
    mesh.half = base.first_half;
    mesh.twin = base.twin;
    mesh.feature = base.feature_of;
    mesh.group = base.group;
    mesh.patch = base.patch;
    mesh.features = base.features;
    mesh.corner.resize(3 * m);
    mesh.compact_triangles = static_cast<int>(m);
    for (std::size_t h = 0; h < 3 * m; ++h) mesh.corner[h] = base.tri[h / 3][h % 3];
    mesh.foot.assign(n, 0);
    mesh.normal.assign(n, Vector3d::Zero());
    mesh.valence.assign(n, 0);
    mesh.origin.assign(n, -1);
    mesh.size.assign(n, 0.0);
    mesh.limit.assign(n, std::numeric_limits<double>::infinity());
    mesh.mark.assign(n, 0);
    mesh.settled.assign(n, 0);
    mesh.bent.assign(n, 0);
    for (std::size_t v = 0; v < n; ++v) {
        if (mesh.half[v] < 0) continue;
        mesh.foot[v] = mesh.half[v] / 3;
        mesh.normal[v] = base.corner_normal[mesh.half[v]];
        if (mesh.role[v] == VertexRole::fixed) mesh.origin[v] = base.origin[v];
        mesh.neighbours(static_cast<int>(v), [&](int) { ++mesh.valence[v]; });
    }
    return mesh;
}

int WorkingMesh::new_triangle(int a, int b, int c, int like) {
    const int t = num_triangles();
    corner.insert(corner.end(), {a, b, c});
    twin.insert(twin.end(), {-1, -1, -1});
    feature.insert(feature.end(), {-1, -1, -1});
    if (!group.empty()) group.push_back(group[like]);
    patch.push_back(patch[like]);
    return t;
}

void WorkingMesh::place_on_curve(int v, int curve, double s) {
    pos[v] = base->curves.at(curve, s);
    foot[v] = base->curves.triangle_at(curve, s);
    normal[v] = normal_at(*base, foot[v], pos[v]);
}

double WorkingMesh::split_place(int f) const {
    const FeatureEdge& edge = features[f];
    const double middle = 0.5 * (edge.s[0] + edge.s[1]), vertex = base->curves.nearest_vertex(edge.curve, middle);
    return std::abs(vertex - middle) < 0.25 * (edge.s[1] - edge.s[0]) ? vertex : middle;
}

int WorkingMesh::split_feature(int f, int a, int m) {
    const FeatureEdge edge = features[f];
    const double s = split_place(f);
    const int beyond = static_cast<int>(features.size());
    features.push_back(edge);
    const int end = edge.v[0] == a ? 1 : 0;  // of f, which stays at a
    features[f].v[end] = features[beyond].v[1 - end] = m;
    features[f].s[end] = features[beyond].s[1 - end] = s;
    place_on_curve(m, edge.curve, s);
    return beyond;
}

void WorkingMesh::find_foot(int m, int h) {
    const int a = from(h), b = to(h);
    const bool a_tells = role[a] == VertexRole::free, b_tells = role[b] == VertexRole::free;
    if (a_tells || b_tells) {  // the others' normals are those of one side of their feature
        foot[m] = foot[a_tells ? a : b];
        const Vector3d sum = (a_tells ? normal[a] : Vector3d::Zero()) + (b_tells ? normal[b] : Vector3d::Zero());
        normal[m] = sum.squaredNorm() > 0.5 ? Vector3d(sum.normalized()) : base->normal[foot[m]];
        // Across a bend, or half a wing away, neither end describes the surface in the middle.
        const bool both_tell = a_tells && b_tells;
        if (both_tell ? normal[a].dot(normal[b]) > 0.97 : (pos[m] - pos[a]).squaredNorm() < size[m] * size[m]) return;
        const Foot below = project(*base, pos[m], foot[m], size[m]);
        const Vector3d there = normal_at(*base, below);
        if (there.dot(normal[m]) < 0) return;  // the other side of a thin part
        foot[m] = below.triangle;
        normal[m] = there;
        return;
    }
    double near2 = std::numeric_limits<double>::infinity();  // a bound from what lies beside makes the search short
    for (const int v : {a, b, apex(h), twin[h] >= 0 ? apex(twin[h]) : a}) {
        if (base->patch[foot[v]] != patch[h / 3]) continue;
        const Foot beside = project(*base, pos[m], foot[v], size[m]);
        if (!(beside.distance2 < near2)) continue;
        near2 = beside.distance2;
        foot[m] = beside.triangle;
    }
    const int nearest = base->tree.closest(base->points, base->tri, base->patch, patch[h / 3], pos[m], near2);
    if (nearest >= 0) foot[m] = nearest;
    normal[m] = normal_at(*base, foot[m], pos[m]);
}

int WorkingMesh::split(int h) {
    const int a = from(h), b = to(h), c = apex(h), g = twin[h], f = feature[h], m = num_vertices();
    pos.push_back(0.5 * (pos[a] + pos[b]));
    foot.push_back(-1);
    normal.push_back(Vector3d::Zero());
    size.push_back(wanted(a, b));
    limit.push_back(std::max(limit[a], limit[b]));
    role.push_back(f >= 0 ? VertexRole::ridge : VertexRole::free);
    origin.push_back(-1);
    mark.push_back(0);
    settled.push_back(0);
    bent.push_back(bent[a] || bent[b]);
    for (const int v : {a, b, c}) wake(v);
    valence.push_back(g >= 0 ? 4 : 3);
    half.push_back(-1);
    if (f < 0) find_foot(m, h);
    const int beyond = f >= 0 ? split_feature(f, a, m) : -1;

    const int n = next(h), t2 = new_triangle(m, b, c, h / 3);  // h: a to m, n: m to c
    join(3 * t2 + 1, twin[n]);
    feature[3 * t2 + 1] = feature[n];
    if (half[b] == n || half[b] == g) half[b] = 3 * t2 + 1;
    corner[n] = m;
    join(n, 3 * t2 + 2);
    feature[n] = -1;
    feature[3 * t2] = beyond;
    half[m] = 3 * t2;
    ++valence[c];
    if (g < 0) return m;

    const int d = apex(g), p = prev(g), t3 = new_triangle(b, m, d, g / 3);  // g: m to a, p: d to m
    join(3 * t3 + 2, twin[p]);
    feature[3 * t3 + 2] = feature[p];
    if (half[d] == p) half[d] = 3 * t3 + 2;
    corner[g] = m;
    join(p, 3 * t3 + 1);
    feature[p] = -1;
    feature[3 * t3] = beyond;
    join(3 * t2, 3 * t3);
    ++valence[d];
    wake(d);
    return m;
}

void WorkingMesh::flip(int h) {
    const int g = twin[h], n = next(h), ng = next(g);
    const int a = from(h), b = from(g), c = apex(h), d = apex(g);
    const int outer_h = twin[ng], outer_g = twin[n];
    corner[n] = d;   // h: a to d, n: d to c
    corner[ng] = c;  // g: b to c, ng: c to d
    feature[h] = feature[ng];
    feature[g] = feature[n];
    feature[n] = feature[ng] = -1;
    twin[h] = twin[g] = -1;
    join(h, outer_h);
    join(g, outer_g);
    join(n, ng);
    if (half[a] == ng) half[a] = h;
    if (half[b] == n) half[b] = g;
    --valence[a], --valence[b], ++valence[c], ++valence[d];
    for (const int v : {a, b, c, d}) wake(v);
}

int WorkingMesh::other_feature(int v, int f) const {
    int other = -1;
    around(v, [&](int h) {
        const int back = prev(h);
        if (feature[h] >= 0 && feature[h] != f) other = feature[h];
        if (twin[back] < 0 && feature[back] >= 0 && feature[back] != f) other = feature[back];
        return true;
    });
    return other;
}

bool WorkingMesh::can_collapse(int h, int gone) {
    const int a = gone, b = from(h) + to(h) - gone, c = apex(h), g = twin[h];
    if (role[a] == VertexRole::fixed || (role[a] == VertexRole::ridge && feature[h] < 0)) return false;
    const int n = next(h), p = prev(h);
    if ((feature[n] >= 0 && feature[p] >= 0) || (twin[n] < 0 && twin[p] < 0)) return false;
    if (valence[c] <= (is_boundary(c) ? 2 : 3)) return false;
    if (g >= 0) {
        const int ng = next(g), pg = prev(g), d = apex(g);
        if (c == d || (feature[ng] >= 0 && feature[pg] >= 0) || (twin[ng] < 0 && twin[pg] < 0)) return false;
        if (valence[d] <= (is_boundary(d) ? 2 : 3)) return false;
        if (is_boundary(a) && is_boundary(b)) return false;
    }
    ++stamp;
    neighbours(a, [&](int v) { mark[v] = stamp; });
    int common = 0;
    neighbours(b, [&](int v) { common += mark[v] == stamp; });
    return common == (g >= 0 ? 2 : 1);
}

bool WorkingMesh::collapse_fits_curve(int h, int gone, double slack) const {
    const FeatureEdge& edge = features[feature[h]];
    const int a = gone, f2 = other_feature(a, feature[h]);
    if (f2 < 0 || features[f2].curve != edge.curve) return false;
    const FeatureEdge& rest = features[f2];
    const double longer = edge.s[1] - edge.s[0];
    const int end = rest.end_at(a);
    double s0 = rest.s[0], s1 = rest.s[1];
    (end == 1 ? s1 : s0) += end == 1 ? longer : -longer;
    return base->curves.chord_fits(edge.curve, s0, s1, slack);
}

void WorkingMesh::set_half(int v, int out) {
    for (int i = out; true;) {
        if (twin[i] < 0) {
            half[v] = i;
            return;
        }
        i = next(twin[i]);
        if (i == out) break;
    }
    half[v] = out;
}

void WorkingMesh::collapse(int h, int gone) {
    const int a = gone, b = from(h) + to(h) - gone, c = apex(h), g = twin[h], f = feature[h];
    if (f >= 0) {
        const FeatureEdge removed = features[f];
        FeatureEdge& rest = features[other_feature(a, f)];
        const int end = rest.end_at(a);
        rest.v[end] = b;
        const bool is_exact = !base->curves.is_closed(removed.curve);
        const double longer = removed.s[1] - removed.s[0];
        rest.s[end] = is_exact ? removed.s[removed.end_at(b)] : rest.s[end] + (end == 1 ? longer : -longer);
        features[f].curve = -1;
    }
    around(a, [&](int out) {
        corner[out] = b;
        return true;
    });
    const auto close = [&](int in, int out) {  // the two other sides of a triangle that goes
        const int x = twin[in], y = twin[out];
        const int kept = feature[in] >= 0 ? feature[in] : feature[out];
        if (x >= 0) feature[x] = kept, twin[x] = -1;
        if (y >= 0) feature[y] = kept, twin[y] = -1;
        join(x, y);
        for (int k = 0; k < 3; ++k) corner[3 * (in / 3) + k] = -1;
        return std::array<int, 2>{x, y};
    };
    valence[b] += valence[a] - (g >= 0 ? 4 : 3);
    --valence[c];
    int d = -1, out_of_d = -1;
    if (g >= 0) {
        d = apex(g);
        --valence[d];
        const auto [x, y] = close(next(g), prev(g));  // x: d to b (once a), y: b to d
        out_of_d = x >= 0 ? x : next(y);
    }
    const auto [x, y] = close(next(h), prev(h));  // x: c to b, y: b (once a) to c
    set_half(c, x >= 0 ? x : next(y));
    if (d >= 0) set_half(d, out_of_d);
    set_half(b, y >= 0 ? y : next(x));
    half[a] = -1;
    wake_around(b);
}

}  // namespace strake
