#include "optimize/space/mirror.hpp"

#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"

#include <Eigen/Eigenvalues>
#include <limits>
#include <map>

namespace strake {
namespace {

constexpr double good_image = 1e-3;   ///< diagonals
constexpr double exact_image = 1e-7;  ///< diagonals: below it misfits are rounding, and planes as good as each other
constexpr double agreement = 0.9;
constexpr int mirror_samples = 4000;

/// Root mean square distance of the mirrored triangle centres from the surface; infinite once it exceeds `most`, which
/// a few centres often tell.
double misfit(const TriMesh& mesh, const ClosestPointTree& tree, const SymmetryPlane& plane, double most) {
    const Points centre = triangle_centroids(mesh);
    const Eigen::VectorXd area = triangle_areas(mesh);
    const int stride = std::max(1, mesh.num_triangles() / mirror_samples);
    double sum = 0, weight = 0;
    for (int t = 0; t < mesh.num_triangles(); t += stride) weight += area[t];
    const double too_much = (1 + 1e-9) * most * most * weight;
    for (int t = 0; t < mesh.num_triangles(); t += stride) {
        const Eigen::Vector3d c = centre.row(t);
        const Eigen::Vector3d image = c - 2 * (plane.normal.dot(c) - plane.offset) * plane.normal;
        sum += area[t] * (tree.find(image).point - image).squaredNorm();
        if (sum > too_much) return std::numeric_limits<double>::infinity();
    }
    return std::sqrt(sum / weight);
}

}  // namespace

std::optional<SymmetryPlane> plane_of_symmetry(const TriMesh& mesh) {
    const Points centre = triangle_centroids(mesh);
    const Eigen::VectorXd area = triangle_areas(mesh);
    const Eigen::Vector3d middle = centre.transpose() * area / area.sum();
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Eigen::Vector3d arm = centre.row(t).transpose() - middle;
        spread += area[t] * arm * arm.transpose();
    }
    const Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors();
    const ClosestPointTree tree(mesh);
    std::optional<SymmetryPlane> best;
    double least = good_image * box_diagonal(mesh);
    for (int k = 0; k < 6; ++k) {
        const Eigen::Vector3d normal = k < 3 ? Eigen::Vector3d(Eigen::Vector3d::Unit(k)) : axes.col(k - 3);
        const SymmetryPlane plane{normal, normal.dot(middle)};
        const double off = std::max(misfit(mesh, tree, plane, least), exact_image * box_diagonal(mesh));
        if (best ? off < 0.5 * least : off <= least) best = plane, least = off;
    }
    return best;
}

Eigen::Matrix3d reflection(const SymmetryPlane& plane) {
    return Eigen::Matrix3d::Identity() - 2 * plane.normal * plane.normal.transpose();
}

std::vector<int> mirror_images(const TriMesh& mesh, const PatchLevel& level, const SymmetryPlane& plane) {
    const Points centre = triangle_centroids(mesh);
    const Eigen::VectorXd area = triangle_areas(mesh);
    const ClosestPointTree tree(mesh);
    std::vector<std::map<int, double>> covered(level.patches.size());
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Eigen::Vector3d c = centre.row(t);
        const Eigen::Vector3d image = c - 2 * (plane.normal.dot(c) - plane.offset) * plane.normal;
        covered[level.label[t]][level.label[tree.find(image).triangle]] += area[t];
    }
    std::vector<int> found(level.patches.size(), -1);
    for (const Patch& patch : level.patches)
        for (const auto& [other, share] : covered[patch.id])
            if (share >= agreement * std::max(patch.area, level.patches[other].area)) found[patch.id] = other;
    for (std::size_t p = 0; p < found.size(); ++p)
        if (found[p] >= 0 && found[found[p]] != static_cast<int>(p)) found[p] = -1;
    return found;
}

}  // namespace strake
