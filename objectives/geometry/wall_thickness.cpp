#include "objectives/geometry/wall_thickness.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/geometry/ray_tree.hpp"
#include "objectives/quantity/closed.hpp"
#include "objectives/quantity/finite.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace strake {
namespace {

using Eigen::Vector3d;

struct Ray {
    int from;
    RayHit hit;
};

/// From the first `count` triangles.
std::vector<Ray> rays(const TriMesh& mesh, int count, const std::vector<char>& region) {
    const RayTree tree(mesh);
    std::vector<Ray> all;
    for (int t = 0; t < count; ++t) {
        if (!region.empty() && !region[t]) continue;
        const Vector3d s = area_vector(mesh, t);
        const double area = s.norm();
        if (!(area > 0)) continue;
        const Vector3d centroid = (mesh.vertices.row(mesh.triangles(t, 0)) + mesh.vertices.row(mesh.triangles(t, 1)) +
                                   mesh.vertices.row(mesh.triangles(t, 2))) /
                                  3;
        const RayHit hit = tree.first(centroid, -s / area, t);
        if (hit.triangle >= 0) all.push_back({t, hit});
    }
    return all;
}

/// Adds weight dt/dv: dt = n . (sum b_k dp_k - dc + t dN) / (n . d), d = -N.
void add_gradient(const TriMesh& mesh, const Ray& ray, double weight, Points& dJ_dv) {
    const Vector3d s = area_vector(mesh, ray.from), n = area_vector(mesh, ray.hit.triangle).normalized();
    const double area = s.norm();
    const Vector3d N = s / area;
    const Vector3d by_point = weight / -n.dot(N) * n;
    for (int k = 0; k < 3; ++k) dJ_dv.row(mesh.triangles(ray.hit.triangle, k)) += ray.hit.b[k] * by_point;
    const Vector3d by_s = ray.hit.s / area * (by_point - N * N.dot(by_point));
    for (int k = 0; k < 3; ++k) {
        const Vector3d opposite = mesh.vertices.row(mesh.triangles(ray.from, (k + 2) % 3)) -
                                  mesh.vertices.row(mesh.triangles(ray.from, (k + 1) % 3));
        dJ_dv.row(mesh.triangles(ray.from, k)) += 0.5 * by_s.cross(opposite) - by_point / 3;
    }
}

void check(const std::string& name, const TriMesh& start, const WallThickness& what,
           const std::optional<SymmetryPlane>& symmetry) {
    if (!(what.sharpness >= 1 && what.sharpness <= 1000))
        throw InvalidInput(text(name, ": sharpness = ", what.sharpness, " must be in [1, 1000]"));
    if (!what.region.empty() && static_cast<int>(what.region.size()) != start.num_triangles())
        throw InvalidInput(text(name, ": ", what.region.size(), " marks for ", start.num_triangles(), " triangles"));
    if (const auto failure = vertices_finite(name, start)) throw InvalidInput(failure->message);
    require_oriented(name, start);
    const TriMesh whole = symmetry ? whole_of(start, *symmetry) : start;
    const double V = enclosed_volume(whole), d = box_diagonal(whole);
    if (V < -1e-6 * d * d * d)
        throw InvalidInput(text(name, ": the surface is inside out (volume ", V, "); orient it outward"));
    if (rays(whole, start.num_triangles(), what.region).empty())
        throw InvalidInput(text(name, ": no ray from the region against its normals meets the surface"));
}

QuantityResult measure(const std::string& name, const QuantityRequest& request, const WallThickness& what,
                       const std::optional<SymmetryPlane>& symmetry) {
    const TriMesh whole = symmetry ? whole_of(request.surface, *symmetry) : TriMesh();
    const TriMesh& mesh = symmetry ? whole : request.surface;
    const std::vector<Ray> all = rays(mesh, request.surface.num_triangles(), what.region);
    if (all.empty()) throw InvalidInput(text(name, ": no ray meets the surface"));
    std::size_t thinnest = 0;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].hit.s < all[thinnest].hit.s) thinnest = i;
    const double least = all[thinnest].hit.s, p = what.sharpness;
    double sum = 0;
    for (const Ray& ray : all) sum += std::pow(least / ray.hit.s, p);
    const double smooth = least * std::pow(sum, -1 / p);
    QuantityResult result{{smooth, least}, {}, {}};
    if (!request.want_sensitivities) return result;
    result.dJ_dv.resize(2);
    if (request.wants(0)) {
        result.dJ_dv[0] = Points::Zero(mesh.num_vertices(), 3);
        for (const Ray& ray : all)
            add_gradient(mesh, ray, smooth / sum * std::pow(least / ray.hit.s, p) / ray.hit.s, result.dJ_dv[0]);
    }
    if (request.wants(1)) {
        result.dJ_dv[1] = Points::Zero(mesh.num_vertices(), 3);
        add_gradient(mesh, all[thinnest], 1, result.dJ_dv[1]);
    }
    if (symmetry)
        for (Points& g : result.dJ_dv)
            if (g.rows() > 0) g = folded(g, *symmetry);
    return result;
}

}  // namespace

Quantity wall_thickness(const std::string& name, const TriMesh& start, const WallThickness& what,
                        const std::optional<SymmetryPlane>& symmetry) {
    check(name, start, what, symmetry);
    const std::vector<std::string> names{name + ".smooth", name + ".smallest"};
    return checked_quantity(name, names, start,
                            [=](const QuantityRequest& request) { return measure(name, request, what, symmetry); });
}

}  // namespace strake
