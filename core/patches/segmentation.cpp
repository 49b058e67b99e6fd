#include "core/patches/segmentation.hpp"

#include "core/error.hpp"
#include "core/mesh/disjoint_sets.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/names.hpp"
#include "core/patches/small_patches.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace strake {
namespace {

constexpr double radians = std::numbers::pi / 180;

void check(const PatchLevel& level, double angle_deg, std::size_t flags, const SegmentationOptions& options) {
    if (!(angle_deg > 0 && angle_deg <= 90))
        throw InvalidInput(text("segment: angle = ", angle_deg, " deg must be in (0, 90]"));
    if (!(options.sharp_angle_deg >= 0 && options.sharp_angle_deg <= 180))
        throw InvalidInput(text("segment: sharp_angle = ", options.sharp_angle_deg, " deg must be in [0, 180]"));
    if (!(options.min_patch_percent >= 0 && options.min_patch_percent < 100))
        throw InvalidInput(text("segment: min_patch = ", options.min_patch_percent, "% must be in [0, 100)"));
    if (flags != level.patches.size())
        throw InvalidInput(
            text("refine: ", flags, " flags given, the last level has ", level.patches.size(), " patches"));
}

/// Class of each set, at its root: smooth with a smooth vertex; patches that are not chosen keep theirs.
std::vector<PatchClass> classes_of_sets(const SurfaceFeatures& features, const PatchLevel& above,
                                        const std::vector<char>& chosen, double tau, DisjointSets& sets) {
    const TriMesh& mesh = features.mesh;
    std::vector<PatchClass> patch_class(mesh.num_triangles(), PatchClass::nonsmooth);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Patch& parent = above.patches[above.label[t]];
        if (!chosen[parent.id]) {
            patch_class[sets.root(t)] = parent.patch_class;
            continue;
        }
        for (int k = 0; k < 3; ++k)
            if (!is_nonsmooth(features.vertices[mesh.triangles(t, k)], tau))
                patch_class[sets.root(t)] = PatchClass::smooth;
    }
    return patch_class;
}

}  // namespace

SurfaceFeatures surface_features(const TriMesh& mesh, const Adjacency& adjacent) {
    const Points normals = triangle_normals(mesh);
    SurfaceFeatures features{mesh, adjacent, quadric_metric_tensor(mesh, adjacent),
                             std::vector<double>(adjacent.num_edges(), 0), triangle_areas(mesh)};
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (adjacent.is_regular(e)) {
            const auto side = adjacent.edge_triangles[e];
            features.dihedral[e] = dihedral(normals.row(side[0]), normals.row(side[1]));
        }
    return features;
}

std::vector<char> nonsmooth_edges(const SurfaceFeatures& features, double tau) {
    const Adjacency& adjacent = features.adjacent;
    std::vector<char> nonsmooth(features.vertices.size()), barrier(adjacent.num_edges());
    for (std::size_t v = 0; v < nonsmooth.size(); ++v) nonsmooth[v] = is_nonsmooth(features.vertices[v], tau);
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        const auto [a, b] = adjacent.edges[e];
        barrier[e] =
            adjacent.is_regular(e) && nonsmooth[a] && nonsmooth[b] && features.dihedral[e] >= tau / 2 - angle_slack;
    }
    return barrier;
}

PatchHierarchy whole_surface(const TriMesh& mesh) {
    if (mesh.num_triangles() == 0) throw InvalidInput("segment: the surface has no triangles");
    Patch all;
    all.name = "all";
    all.triangles.resize(mesh.num_triangles());
    std::iota(all.triangles.begin(), all.triangles.end(), 0);
    all.area = surface_area(mesh);
    return {{PatchLevel{0, {all}, std::vector<int>(mesh.num_triangles(), 0)}}};
}

std::vector<char> chosen_patches(const PatchLevel& level, const Split& split) {
    std::vector<char> chosen(level.patches.size(), 0);
    if (std::holds_alternative<SplitAll>(split)) {
        chosen.assign(chosen.size(), 1);
    } else if (const auto* largest = std::get_if<SplitLargest>(&split)) {
        if (largest->count < 1) throw InvalidInput(text("split: largest = ", largest->count, " must be >= 1"));
        std::vector<int> order(level.patches.size());
        std::iota(order.begin(), order.end(), 0);
        std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
            return level.patches[a].triangles.size() > level.patches[b].triangles.size();
        });
        order.resize(std::min<std::size_t>(order.size(), largest->count));
        for (const int p : order) chosen[p] = 1;
    } else {
        for (const int t : std::get<SplitContaining>(split).triangles) {
            if (t < 0 || t >= static_cast<int>(level.label.size()))
                throw InvalidInput(text("split: triangle ", t, " must be in [0, ", level.label.size() - 1, "]"));
            chosen[level.label[t]] = 1;
        }
    }
    return chosen;
}

void refine(PatchHierarchy& tree, const SurfaceFeatures& features, double angle_deg, const std::vector<char>& chosen,
            const SegmentationOptions& options) {
    const Adjacency& adjacent = features.adjacent;
    const PatchLevel& above = tree.levels.back();
    check(above, angle_deg, chosen.size(), options);
    const double tau = angle_deg * radians, sigma = options.sharp_angle_deg * radians;
    const std::vector<char> barrier = nonsmooth_edges(features, tau);
    const int m = features.mesh.num_triangles();
    // Only regular edges inside a chosen parent connect anything.
    const auto inside = [&](int e) {
        if (!adjacent.is_regular(e)) return false;
        const auto side = adjacent.edge_triangles[e];
        return above.label[side[0]] == above.label[side[1]] && chosen[above.label[side[0]]];
    };
    DisjointSets sets(m);
    for (const Patch& patch : above.patches)
        if (!chosen[patch.id])
            for (const int t : patch.triangles) sets.join(patch.triangles.front(), t);
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (!barrier[e] && inside(e)) sets.join(adjacent.edge_triangles[e][0], adjacent.edge_triangles[e][1]);

    std::vector<PatchClass> patch_class = classes_of_sets(features, above, chosen, tau, sets);
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (!barrier[e] || !inside(e) || features.dihedral[e] >= sigma - angle_slack) continue;
        const int a = sets.root(adjacent.edge_triangles[e][0]), b = sets.root(adjacent.edge_triangles[e][1]);
        if (patch_class[a] == PatchClass::nonsmooth && patch_class[b] == PatchClass::nonsmooth) sets.join(a, b);
    }
    std::vector<int> root(m);
    for (int t = 0; t < m; ++t) root[t] = sets.root(t);
    if (options.min_patch_percent > 0)
        merge_small_patches(adjacent, above.label, options.min_patch_percent, root, patch_class);
    append_level(tree, features, angle_deg, root, patch_class);
}

void append_level(PatchHierarchy& tree, const SurfaceFeatures& features, double angle_deg,
                  const std::vector<int>& label, const std::vector<PatchClass>& class_of_label) {
    const PatchLevel& above = tree.levels.back();
    PatchLevel level;
    level.angle_deg = angle_deg;
    level.label.resize(label.size());
    std::vector<int> id(class_of_label.size(), -1);
    for (std::size_t t = 0; t < label.size(); ++t) {
        int& p = id[label[t]];
        if (p < 0) {
            p = static_cast<int>(level.patches.size());
            level.patches.emplace_back();
            level.patches.back().id = p;
            level.patches.back().parent = above.label[t];
            level.patches.back().patch_class = class_of_label[label[t]];
        }
        level.label[t] = p;
        level.patches[p].triangles.push_back(static_cast<int>(t));
        level.patches[p].area += features.areas[t];
    }
    name_children(features.mesh, features.areas, above, level);
    tree.levels.push_back(std::move(level));
}

PatchHierarchy segment(const TriMesh& mesh, const Adjacency& adjacent, const std::vector<double>& angles_deg,
                       const SegmentationOptions& options) {
    for (std::size_t i = 0; i < angles_deg.size(); ++i) {
        if (!(angles_deg[i] > 0 && angles_deg[i] <= 90))
            throw InvalidInput(text("segment: angle ", i + 1, " = ", angles_deg[i], " deg must be in (0, 90]"));
        if (i > 0 && !(angles_deg[i] < angles_deg[i - 1]))
            throw InvalidInput(text("segment: angle ", i + 1, " = ", angles_deg[i], " deg must be below angle ", i,
                                    " = ", angles_deg[i - 1], " deg"));
    }
    PatchHierarchy tree = whole_surface(mesh);
    const SurfaceFeatures features = surface_features(mesh, adjacent);
    for (const double angle : angles_deg) {
        std::vector<char> chosen = chosen_patches(tree.levels.back(), options.split);
        if (tree.levels.size() == 1) chosen.assign(1, 1);  // level 1 always splits the whole surface
        refine(tree, features, angle, chosen, options);
    }
    return tree;
}

}  // namespace strake
