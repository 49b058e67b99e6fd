#include "core/mesh/surface_map.hpp"

#include "core/error.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/near_part.hpp"
#include "core/mesh/surface_samples.hpp"

#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>

namespace strake {
namespace {

using Eigen::RowVector3d;
using Eigen::Vector3d;
using Weights = Eigen::SparseMatrix<double, Eigen::RowMajor>;

constexpr double on_plane_rel = 1e-9;  // of the diagonal, as for regions

double wendland(double x) {
    if (x >= 1) return 0;
    const double rest = (1 - x) * (1 - x);
    return rest * rest * (4 * x + 1);
}

double smoothstep(double x) {
    const double t = std::clamp(x, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

Eigen::VectorXd edge_lengths(const TriMesh& mesh) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(mesh.num_vertices()), count = sum;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            const int a = mesh.triangles(t, k), b = mesh.triangles(t, (k + 1) % 3);
            const double length = (mesh.vertices.row(a) - mesh.vertices.row(b)).norm();
            for (const int v : {a, b}) sum[v] += length, count[v] += 1;
        }
    return sum.cwiseQuotient(count.cwiseMax(1));
}

/// Barycentric coordinates of the closest point in its triangle; exactly 1 at a vertex.
std::array<double, 3> barycentric(const TriMesh& mesh, const ClosestPoint& at) {
    std::array<double, 3> b{0, 0, 0};
    const auto corner = [&](int k) { return Vector3d(mesh.vertices.row(mesh.triangles(at.triangle, k))); };
    if (at.corner_a >= 0 && at.corner_b < 0) {
        b[at.corner_a] = 1;
    } else if (at.corner_a >= 0) {
        const Vector3d a = corner(at.corner_a), edge = corner(at.corner_b) - a;
        const double length = edge.squaredNorm();
        b[at.corner_b] = length > 0 ? std::clamp((at.point - a).dot(edge) / length, 0.0, 1.0) : 0;
        b[at.corner_a] = 1 - b[at.corner_b];
    } else {
        const Vector3d n = (corner(1) - corner(0)).cross(corner(2) - corner(0));
        for (int k = 0; k < 3; ++k) {
            const Vector3d p = corner((k + 1) % 3), q = corner((k + 2) % 3);
            b[k] = std::max(0.0, (q - p).cross(at.point - p).dot(n) / n.squaredNorm());
        }
        const double sum = b[0] + b[1] + b[2];
        for (double& share : b) share /= sum;
    }
    return b;
}

/// The surface with its mirror image; vertices on the plane are shared. source[k]: vertex of which k is the image.
TriMesh with_image(const TriMesh& half, const std::optional<SymmetryPlane>& plane, double tolerance,
                   std::vector<int>& source) {
    TriMesh whole{half.vertices, half.triangles, {}, {}};
    if (!plane) return whole;
    std::vector<int> image(static_cast<std::size_t>(half.num_vertices()));
    const Vector3d& n = plane->normal;
    for (int v = 0; v < half.num_vertices(); ++v) {
        const double height = half.vertices.row(v).dot(n) - plane->offset;
        image[v] = std::abs(height) <= tolerance ? v : half.num_vertices() + static_cast<int>(source.size());
        if (image[v] != v) source.push_back(v);
    }
    whole.vertices.conservativeResize(half.num_vertices() + static_cast<int>(source.size()), 3);
    for (std::size_t i = 0; i < source.size(); ++i) {
        const RowVector3d x = half.vertices.row(source[i]);
        whole.vertices.row(half.num_vertices() + static_cast<int>(i)) =
            x - 2 * (x.dot(n) - plane->offset) * n.transpose();
    }
    whole.triangles.conservativeResize(2 * half.num_triangles(), 3);
    for (int t = 0; t < half.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k)  // reversed to keep the orientation
            whole.triangles(half.num_triangles() + t, k) = image[half.triangles(t, 2 - k)];
    return whole;
}

}  // namespace

struct SurfaceMap::Impl {
    SurfaceMapOptions options;
    double diagonal;
    Points rest, points;      ///< as given
    std::vector<int> source;  ///< of the vertices that are images
    TriMesh whole;            ///< with the image
    LocalRotation rotation;
    LocalGradient gradient;
    SurfaceSamples samples;
    Vector3d centre;  ///< arms of far rotations are measured from here
    NearPart near;
    Weights far;  ///< P x samples
    Eigen::VectorXd distance;
    std::vector<int> vertex;     ///< per point: the coinciding vertex, else -1
    std::vector<char> on_plane;  ///< per point

    Impl(const TriMesh& surface, const Points& given, const SurfaceMapOptions& wanted)
        : options(wanted),
          diagonal(box_diagonal(surface)),
          rest(surface.vertices),
          points(given),
          whole(with_image(surface, wanted.symmetry, on_plane_rel * diagonal, source)),
          rotation(whole),
          gradient(whole),
          samples(surface_samples(whole, edge_lengths(whole), wanted.symmetry)),
          centre(0.5 * (bounding_box(surface).min + bounding_box(surface).max)),
          near(given.rows(), whole.num_vertices()),
          far(given.rows(), samples.size()),
          distance(given.rows()),
          vertex(static_cast<std::size_t>(given.rows()), -1),
          on_plane(static_cast<std::size_t>(given.rows()), 0) {
        const ClosestPointTree tree(whole);
        const Eigen::VectorXd edge = edge_lengths(whole);
        for (int p = 0; p < static_cast<int>(given.rows()); ++p) add_point(p, tree, edge);
        near.finish();
        far.finalize();
        samples.position.rowwise() -= centre.transpose();
    }

    void add_point(int p, const ClosestPointTree& tree, const Eigen::VectorXd& edge) {
        far.startVec(p);
        const Vector3d x = points.row(p);
        const ClosestPoint at = tree.find(x);
        distance[p] = at.distance;
        if (options.symmetry)
            on_plane[p] =
                std::abs(x.dot(options.symmetry->normal) - options.symmetry->offset) <= on_plane_rel * diagonal;
        const double fade = wendland(at.distance / (options.reach * diagonal));
        std::vector<std::pair<int, double>> corners;
        if (fade == 0) return near.add(p, whole.vertices, corners, at.point, Vector3d::Zero());
        const std::array<double, 3> b = barycentric(whole, at);
        double h = 0;
        for (int k = 0; k < 3; ++k) {
            const int v = whole.triangles(at.triangle, k);
            if (b[k] > 0) corners.emplace_back(v, b[k]);
            h += b[k] * edge[v];
            if (b[k] == 1 && at.distance == 0 && v < rest.rows()) vertex[p] = v;
        }
        const double share = at.distance == 0 ? 0 : smoothstep(at.distance / h);
        std::sort(corners.begin(), corners.end());
        for (auto& corner : corners) corner.second *= fade * (1 - share);
        if (share == 1) corners.clear();
        near.add(p, whole.vertices, corners, at.point, x - at.point);
        if (share > 0) add_far(p, x, at.distance, fade * share);
    }

    /// Two levels, blended by the logarithm of the distance.
    void add_far(int p, const Vector3d& x, double d, double share) {
        const auto& levels = samples.levels;
        const double depth = std::clamp(std::log2(d / levels[0].spacing), 0.0, static_cast<double>(levels.size()) - 1);
        const auto fine = static_cast<std::size_t>(depth);
        const double blend = smoothstep(depth - static_cast<double>(fine));
        if (blend < 1) add_level(p, x, levels[fine], share * (1 - blend));
        if (blend > 0) add_level(p, x, levels[fine + 1], share * blend);
    }

    void add_level(int p, const Vector3d& x, const SurfaceSamples::Level& level, double share) {
        const double radius = 1.5 * level.tree.nearest(x).second + level.spacing;
        std::vector<int> found;
        level.tree.within(x, radius, found);
        Eigen::VectorXd weight(static_cast<Eigen::Index>(found.size()));
        for (std::size_t i = 0; i < found.size(); ++i) {
            const int sample = level.first + found[i];
            weight[static_cast<Eigen::Index>(i)] =
                samples.area[sample] * wendland((samples.position.row(sample).transpose() - x).norm() / radius);
        }
        const double sum = weight.sum();
        for (std::size_t i = 0; i < found.size(); ++i)
            if (const double w = weight[static_cast<Eigen::Index>(i)]; w > 0)
                far.insertBack(p, level.first + found[i]) = share * w / sum;
    }

    /// The images' displacements are images.
    Points extended(const Points& u) const {
        Points all(whole.num_vertices(), 3);
        all.topRows(u.rows()) = u;
        for (std::size_t i = 0; i < source.size(); ++i) {
            const Vector3d& n = options.symmetry->normal;
            const RowVector3d row = u.row(source[i]);
            all.row(u.rows() + static_cast<Eigen::Index>(i)) = row - 2 * row.dot(n) * n.transpose();
        }
        return all;
    }

    Points folded(const Points& all) const {
        Points u = all.topRows(rest.rows());
        for (std::size_t i = 0; i < source.size(); ++i) {
            const Vector3d& n = options.symmetry->normal;
            const RowVector3d row = all.row(u.rows() + static_cast<Eigen::Index>(i));
            u.row(source[i]) += row - 2 * row.dot(n) * n.transpose();
        }
        return u;
    }

    void keep_on_plane(Points& at_points) const {
        for (std::size_t p = 0; p < on_plane.size(); ++p)
            if (on_plane[p]) {
                const RowVector3d row = at_points.row(static_cast<Eigen::Index>(p)), n = options.symmetry->normal;
                at_points.row(static_cast<Eigen::Index>(p)) = row - row.dot(n) * n;
            }
    }

    Points arms() const { return points.rowwise() - centre.transpose(); }

    Points apply(const Points& displacement) const {
        const Points u = extended(displacement), w = rotation.apply(u);
        const Points su = samples.mean(u), sw = samples.mean(w);
        const Points still = su - cross_rows(sw, samples.position);  // u_i + w_i x (p - r_i) = still_i + w_i x p
        Points out = near.apply(u, w, gradient.apply(u)) + far * still + cross_rows(far * sw, arms());
        keep_on_plane(out);
        return out;
    }

    Points transpose(const Points& sensitivities) const {
        Points g = sensitivities;
        keep_on_plane(g);
        const Points at_samples = far.transpose() * g;
        const Points turning =
            Points(far.transpose() * cross_rows(arms(), g)) - cross_rows(samples.position, at_samples);
        const NearPart::Sensitivities close = near.transpose(g);
        Points u = close.u + samples.transposed_mean(at_samples);
        u += rotation.transpose(close.w + samples.transposed_mean(turning));
        u += gradient.transpose(close.gradients);
        return folded(u);
    }
};

namespace {

void check(const TriMesh& rest, const Points& points, const SurfaceMapOptions& options) {
    if (!(options.reach > 0) || !std::isfinite(options.reach))
        throw InvalidInput(text("surface map: reach = ", options.reach, " must be > 0 and finite"));
    if (!rest.vertices.allFinite()) throw InvalidInput("surface map: a vertex of the surface is not finite");
    for (Eigen::Index p = 0; p < points.rows(); ++p)
        if (!points.row(p).allFinite())
            throw InvalidInput(text("surface map: point ", p, " = ", points.row(p), " is not finite"));
    if (!(surface_area(rest) > 0)) throw InvalidInput("surface map: the surface has no area");
}

void check_rows(const Points& given, int expected, const char* what) {
    if (given.rows() != expected)
        throw InvalidInput(text("surface map: ", given.rows(), " rows of ", what, ", must be ", expected));
}

}  // namespace

SurfaceMap::SurfaceMap(const TriMesh& rest, const Points& points, const SurfaceMapOptions& options) {
    check(rest, points, options);
    impl_ = std::make_unique<Impl>(rest, points, options);
}
SurfaceMap::~SurfaceMap() = default;
SurfaceMap::SurfaceMap(SurfaceMap&&) noexcept = default;
SurfaceMap& SurfaceMap::operator=(SurfaceMap&&) noexcept = default;

int SurfaceMap::num_vertices() const { return static_cast<int>(impl_->rest.rows()); }
int SurfaceMap::num_points() const { return static_cast<int>(impl_->points.rows()); }
const Eigen::VectorXd& SurfaceMap::distances() const { return impl_->distance; }

Points SurfaceMap::apply(const Points& displacement) const {
    check_rows(displacement, num_vertices(), "displacements of vertices");
    return impl_->apply(displacement);
}

Points SurfaceMap::transpose(const Points& sensitivities) const {
    check_rows(sensitivities, num_points(), "sensitivities at points");
    return impl_->transpose(sensitivities);
}

Points SurfaceMap::moved(const Points& vertices) const {
    check_rows(vertices, num_vertices(), "vertices");
    Points out = impl_->points + impl_->apply(vertices - impl_->rest);
    for (std::size_t p = 0; p < impl_->vertex.size(); ++p)
        if (const int v = impl_->vertex[p]; v >= 0) out.row(static_cast<Eigen::Index>(p)) = vertices.row(v);
    return out;
}

}  // namespace strake
