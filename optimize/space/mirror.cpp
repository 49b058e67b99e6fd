#include "optimize/space/mirror.hpp"

#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>
#include <map>

namespace strake {
namespace {

constexpr double good_image = 1e-3;   ///< diagonals
constexpr double exact_image = 1e-7;  ///< diagonals: below it misfits are rounding, and planes as good as each other
constexpr double flat = 0.4;          ///< thickness over the middle extent: less is a wing
constexpr double longer = 1.01;       ///< times the other: extents that differ by less are as long as each other
constexpr double agreement = 0.9;
constexpr double orthogonal = 1e-3;  ///< cosine of two normals
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

struct FittedPlane {
    SymmetryPlane plane;
    double misfit = 0, extent = 0;  ///< extent: of the surface along the normal
};

/// The least belongs to the plane between left and right. @param size extents of the body in rising order
int rank_of(const FittedPlane& f, const Eigen::Vector3d& size) {
    const bool is_across_longest = longer * f.extent > size[2];
    const bool is_across_thickness = f.extent < longer * size[0] && longer * size[0] < size[1];
    const int other = is_across_thickness ? 2 : 1;
    if (size[0] < flat * size[1]) return is_across_longest ? 0 : other;
    const bool has_longest = longer * size[1] <= size[2];
    return has_longest && is_across_longest ? 2 : other - 1;
}

/// Of planes that fit as well as each other, the one between left and right: a body is longest along the stream, which
/// the plane contains; a flat one may be a wing, whose span it crosses. What that leaves open goes to y, x, z, as if up
/// were z.
SymmetryPlane between_left_and_right(const std::vector<FittedPlane>& planes, const TriMesh& mesh) {
    const Box box = bounding_box(mesh);
    Eigen::Vector3d size = box.max - box.min;
    std::sort(size.data(), size.data() + 3);
    const auto place = [](const FittedPlane& f) {  // y, x, z, other axes
        const Eigen::Vector3d n = f.plane.normal.cwiseAbs();
        return n[1] > 1 - exact_image ? 0 : n[0] > 1 - exact_image ? 1 : n[2] > 1 - exact_image ? 2 : 3;
    };
    const auto key = [&](const FittedPlane& f) { return std::pair(rank_of(f, size), place(f)); };
    return std::min_element(planes.begin(), planes.end(),
                            [&](const FittedPlane& a, const FittedPlane& b) { return key(a) < key(b); })
        ->plane;
}

/// Across coordinate directions and principal axes, through the area centroid.
std::vector<SymmetryPlane> candidates(const TriMesh& mesh) {
    const Points centre = triangle_centroids(mesh);
    const Eigen::VectorXd area = triangle_areas(mesh);
    const Eigen::Vector3d middle = centre.transpose() * area / area.sum();
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Eigen::Vector3d arm = centre.row(t).transpose() - middle;
        spread += area[t] * arm * arm.transpose();
    }
    const Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors();
    std::vector<SymmetryPlane> planes;
    for (int k = 0; k < 6; ++k) {
        const Eigen::Vector3d normal = k < 3 ? Eigen::Vector3d(Eigen::Vector3d::Unit(k)) : axes.col(k - 3);
        SymmetryPlane plane{normal, normal.dot(middle)};
        if (std::abs(plane.offset) < exact_image * box_diagonal(mesh)) plane.offset = 0;
        planes.push_back(plane);
    }
    return planes;
}

}  // namespace

std::optional<SymmetryPlane> plane_of_symmetry(const TriMesh& mesh) {
    const ClosestPointTree tree(mesh);
    const double diagonal = box_diagonal(mesh), rounding = exact_image * diagonal;
    std::vector<FittedPlane> planes;
    double least = good_image * diagonal;
    for (const SymmetryPlane& plane : candidates(mesh)) {
        const double off = std::max(misfit(mesh, tree, plane, least), rounding);
        if (planes.empty() ? off > least : off >= 0.5 * least && off > rounding) continue;
        const Eigen::VectorXd height = mesh.vertices * plane.normal;
        if (off < 0.5 * least) planes.clear();
        planes.push_back({plane, off, height.maxCoeff() - height.minCoeff()});
        least = std::min(least, off);
    }
    if (planes.empty()) return std::nullopt;
    return between_left_and_right(planes, mesh);
}

std::vector<SymmetryPlane> planes_of_symmetry(const TriMesh& mesh) {
    const ClosestPointTree tree(mesh);
    const double most = good_image * box_diagonal(mesh);
    std::vector<std::pair<double, SymmetryPlane>> fitting;
    for (const SymmetryPlane& plane : candidates(mesh))
        if (const double off = misfit(mesh, tree, plane, most); off <= most) fitting.emplace_back(off, plane);
    if (const auto first = plane_of_symmetry(mesh)) fitting.emplace_back(-1, *first);
    std::ranges::stable_sort(fitting, {}, &std::pair<double, SymmetryPlane>::first);
    std::vector<SymmetryPlane> planes;
    for (const auto& [off, plane] : fitting)
        if (std::ranges::all_of(planes, [&](const SymmetryPlane& other) {
                return std::abs(other.normal.dot(plane.normal)) < orthogonal;
            }))
            planes.push_back(plane);
    return planes;
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
