#include "core/patches/names.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <algorithm>
#include <array>

namespace strake {
namespace {

Eigen::Vector3d centroid(const Points& centroids, const Eigen::VectorXd& areas, const Patch& patch) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const int t : patch.triangles) sum += areas[t] * centroids.row(t).transpose();
    return patch.area > 0 ? Eigen::Vector3d(sum / patch.area) : Eigen::Vector3d(centroids.row(patch.triangles[0]));
}

/// Sorts siblings by their centroids along the coordinate axis of largest spread. Positions, not triangle numbers, give
/// the same names on a renumbered or remeshed surface.
void sort_by_place(const std::vector<Eigen::Vector3d>& place, std::vector<int>& siblings) {
    Eigen::Vector3d low = place[siblings[0]], high = low;
    for (const int s : siblings) low = low.cwiseMin(place[s]), high = high.cwiseMax(place[s]);
    std::array<int, 3> axes{0, 1, 2};
    std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return (high - low)[a] > (high - low)[b]; });
    std::stable_sort(siblings.begin(), siblings.end(), [&](int a, int b) {
        for (const int axis : axes)
            if (place[a][axis] != place[b][axis]) return place[a][axis] < place[b][axis];
        return a < b;
    });
}

}  // namespace

void name_children(const TriMesh& mesh, const Eigen::VectorXd& areas, const PatchLevel& above, PatchLevel& level) {
    std::vector<std::vector<int>> children(above.patches.size());
    for (const Patch& patch : level.patches) children[patch.parent].push_back(patch.id);
    const Points centroids = triangle_centroids(mesh);
    std::vector<Eigen::Vector3d> place;
    for (const Patch& patch : level.patches) place.push_back(centroid(centroids, areas, patch));
    for (const Patch& parent : above.patches) {
        std::vector<int>& siblings = children[parent.id];
        if (siblings.size() == 1) {
            level.patches[siblings[0]].name = parent.name;
            continue;
        }
        sort_by_place(place, siblings);
        const std::string stem = parent.name == "all" ? "p" : parent.name + ".";
        for (std::size_t i = 0; i < siblings.size(); ++i) level.patches[siblings[i]].name = text(stem, i + 1);
    }
}

}  // namespace strake
