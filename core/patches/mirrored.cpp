#include "core/patches/mirrored.hpp"

#include "core/mesh/closest_point.hpp"
#include "core/mesh/disjoint_sets.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/segmentation.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <queue>
#include <tuple>

namespace strake {
namespace {

constexpr int nobody = -1;
constexpr double own_image = 0.7;     ///< of its area: what a patch shares with its image
constexpr double min_share = 1. / 3;  ///< of its area: what a patch has on the side that is kept

/// Labels of triangles, and their propagation along the surface.
class Labels {
public:
    Labels(const TriMesh& mesh, const Adjacency& adjacent)
        : mesh_(mesh), adjacent_(adjacent), centroid_(triangle_centroids(mesh)) {}

    const Points& centroids() const { return centroid_; }

    void for_neighbours(int t, const std::function<void(int)>& visit) const {
        for (int k = 0; k < 3; ++k)
            for (const int n : adjacent_.edge_triangles[adjacent_.triangle_edges(t, k)])
                if (n != t) visit(n);
    }

    /// Per triangle the smallest one of its edge-connected component of equal label.
    std::vector<int> components(const std::vector<int>& label) const {
        DisjointSets sets(mesh_.num_triangles());
        for (int t = 0; t < mesh_.num_triangles(); ++t)
            for_neighbours(t, [&](int n) {
                if (n < t && label[n] == label[t]) sets.join(n, t);
            });
        std::vector<int> root(mesh_.num_triangles());
        for (int t = 0; t < mesh_.num_triangles(); ++t) root[t] = sets.root(t);
        return root;
    }

    /// Gives unlabelled triangles in `may` the nearest label along the surface, within `above`.
    void fill(std::vector<int>& label, const std::vector<int>& above, const std::vector<char>& may) const {
        using Entry = std::tuple<double, int, int>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
        const auto spread = [&](int t, double distance) {
            for_neighbours(t, [&](int n) {
                if (label[n] == nobody && may[n] && above[n] == above[t])
                    queue.push({distance + (centroid_.row(n) - centroid_.row(t)).norm(), n, label[t]});
            });
        };
        for (int t = 0; t < mesh_.num_triangles(); ++t)
            if (label[t] != nobody) spread(t, 0);
        while (!queue.empty()) {
            const auto [distance, t, from] = queue.top();
            queue.pop();
            if (label[t] != nobody) continue;
            label[t] = from;
            spread(t, distance);
        }
    }

private:
    const TriMesh& mesh_;
    const Adjacency& adjacent_;
    Points centroid_;
};

/// Builds one level after the other. A group is the part of a patch on the kept side; its label there is twice its
/// number, on the other side the same if it is its own image, else one more.
class Mirror {
public:
    Mirror(const TriMesh& mesh, const Adjacency& adjacent, const SymmetryPlane& plane)
        : features_(surface_features(mesh, adjacent)), labels_(mesh, adjacent) {
        const int m = mesh.num_triangles();
        image_.resize(m);
        kept_.resize(m);
        const ClosestPointTree surface(mesh);
        for (int t = 0; t < m; ++t) {
            const Eigen::Vector3d c = labels_.centroids().row(t);
            const double height = plane.normal.dot(c) - plane.offset;
            image_[t] = surface.find(c - 2 * height * plane.normal).triangle;
            kept_[t] = height >= 0 || image_[t] == t;
        }
        above_.assign(m, 0);
        groups_ = {{0, true}};
    }

    void append(PatchHierarchy& made, const PatchLevel& level) {
        level_ = &level;
        find_connected();
        std::vector<Group> groups = keep_side();
        find_own(groups);
        std::vector<int> label = both_sides(groups);
        std::vector<PatchClass> classes;
        for (const Group& group : groups) classes.insert(classes.end(), 2, level.patches[group.patch].patch_class);
        append_level(made, features_, level.angle_deg, label, classes);
        above_ = std::move(label);
        groups_ = std::move(groups);
    }

private:
    struct Group {
        int patch;
        bool is_own_image;
    };

    int num_triangles() const { return static_cast<int>(image_.size()); }

    void find_connected() {
        connected_.assign(level_->patches.size(), 1);
        const std::vector<int> component = labels_.components(level_->label);
        for (int t = 0; t < num_triangles(); ++t) {
            const Patch& patch = level_->patches[level_->label[t]];
            if (component[t] != patch.triangles.front()) connected_[patch.id] = 0;
        }
    }

    /// Of a connected patch, unlabels all but the largest component.
    void drop_pieces(std::vector<int>& label, const std::function<int(int)>& patch_of) const {
        std::vector<int> component = labels_.components(label);
        std::map<int, double> area;
        for (int t = 0; t < num_triangles(); ++t) area[component[t]] += features_.areas[t];
        std::map<int, int> largest;  // of a label
        for (const auto& [root, size] : area) {
            const auto [at, is_new] = largest.insert({label[root], root});
            if (!is_new && size > area[at->second]) at->second = root;
        }
        for (int t = 0; t < num_triangles(); ++t)
            if (label[t] != nobody && connected_[patch_of(label[t])] && largest[label[t]] != component[t])
                component[t] = nobody;
        for (int t = 0; t < num_triangles(); ++t)
            if (component[t] == nobody) label[t] = nobody;
    }

    /// Groups and their triangles on the side that is kept (`half_`).
    std::vector<Group> keep_side() {
        std::map<std::pair<int, int>, double> area;  // by label above and patch
        for (int t = 0; t < num_triangles(); ++t)
            if (kept_[t]) area[{above_[t], level_->label[t]}] += features_.areas[t];
        std::map<int, std::pair<double, int>> largest;  // by label above: area and patch
        for (const auto& [key, size] : area)
            if (auto& best = largest[key.first]; size > best.first) best = {size, key.second};
        std::map<std::pair<int, int>, int> number;
        std::vector<Group> groups;
        for (const auto& [key, size] : area)
            if (size >= min_share * level_->patches[key.second].area || largest[key.first].second == key.second) {
                number[key] = static_cast<int>(groups.size());
                groups.push_back({key.second, false});
            }
        half_.assign(image_.size(), nobody);
        for (int t = 0; t < num_triangles(); ++t)
            if (kept_[t])
                if (const auto at = number.find({above_[t], level_->label[t]}); at != number.end())
                    half_[t] = at->second;
        drop_pieces(half_, [&](int g) { return groups[g].patch; });
        labels_.fill(half_, above_, kept_);
        complete(half_, groups, kept_, 1);
        return groups;
    }

    /// Unreached triangles become new groups, one per label above.
    void complete(std::vector<int>& label, std::vector<Group>& groups, const std::vector<char>& may,
                  int labels_of_group) const {
        std::map<int, int> fresh;
        for (int t = 0; t < num_triangles(); ++t) {
            if (label[t] != nobody || !may[t]) continue;
            const auto [at, is_new] = fresh.insert({above_[t], static_cast<int>(groups.size())});
            if (is_new) groups.push_back({level_->label[t], false});
            label[t] = labels_of_group * at->second + labels_of_group - 1;
        }
    }

    void find_own(std::vector<Group>& groups) const {
        std::vector<double> met(level_->patches.size(), 0);
        for (int t = 0; t < num_triangles(); ++t)
            if (level_->label[image_[t]] == level_->label[t]) met[level_->label[t]] += features_.areas[t];
        std::vector<char> reaches_plane(groups.size(), 0);
        for (int t = 0; t < num_triangles(); ++t) {
            if (!kept_[t]) continue;
            if (image_[t] == t) reaches_plane[half_[t]] = 1;
            labels_.for_neighbours(t, [&](int n) {
                if (!kept_[n] && half_[image_[n]] == half_[t]) reaches_plane[half_[t]] = 1;
            });
        }
        for (int t = 0; t < num_triangles(); ++t) {
            if (!kept_[t]) continue;
            Group& group = groups[half_[t]];
            const Patch& patch = level_->patches[group.patch];
            group.is_own_image = reaches_plane[half_[t]] && groups_[above_[t] / 2].is_own_image &&
                                 met[patch.id] >= own_image * patch.area;
        }
    }

    std::vector<int> both_sides(std::vector<Group>& groups) const {
        const auto other_side = [](const Group& group, int number) {
            return 2 * number + (group.is_own_image ? 0 : 1);
        };
        std::vector<int> label(image_.size(), nobody);
        for (int t = 0; t < num_triangles(); ++t) {
            if (kept_[t]) {
                label[t] = 2 * half_[t];
                continue;
            }
            const int s = image_[t];
            if (!kept_[s] || above_[t] != other_side(groups_[above_[s] / 2], above_[s] / 2)) continue;
            label[t] = other_side(groups[half_[s]], half_[s]);
        }
        drop_pieces(label, [&](int l) { return groups[l / 2].patch; });
        const std::vector<char> anywhere(image_.size(), 1);
        labels_.fill(label, above_, anywhere);
        complete(label, groups, anywhere, 2);
        return label;
    }

    SurfaceFeatures features_;
    Labels labels_;
    std::vector<int> image_;     ///< per triangle
    std::vector<char> kept_;     ///< per triangle: on the side that is kept
    std::vector<int> above_;     ///< labels of the level above
    std::vector<Group> groups_;  ///< of the level above
    const PatchLevel* level_ = nullptr;
    std::vector<char> connected_;  ///< patches of the level
    std::vector<int> half_;        ///< groups of the level on the side that is kept
};

}  // namespace

PatchHierarchy mirrored(const PatchHierarchy& tree, const TriMesh& mesh, const Adjacency& adjacent,
                        const SymmetryPlane& plane) {
    Mirror mirror(mesh, adjacent, plane);
    PatchHierarchy made{{tree.levels.at(0)}};
    for (std::size_t k = 1; k < tree.levels.size(); ++k) mirror.append(made, tree.levels[k]);
    return made;
}

}  // namespace strake
