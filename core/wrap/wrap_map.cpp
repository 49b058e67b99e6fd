#include "core/wrap/wrap_map.hpp"

#include "core/error.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "core/parallel.hpp"
#include "core/wrap/halves.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

constexpr double on_cut = 1e-6;    ///< diagonals: vertices of the body that a half ends with
constexpr double rounding = 1e-9;  ///< diagonals: of what a wrap has on its plane
constexpr int block = 64;

/// Mirror images of the vertices of a wrap that has both of its halves one after the other, or interleaved.
std::vector<int> images(const Points& x, const SymmetryPlane& plane, double diagonal) {
    constexpr double same = 1e-9;  // diagonals
    std::vector<int> order(static_cast<std::size_t>(x.rows())), image(order.size(), -1);
    for (std::size_t v = 0; v < order.size(); ++v) order[v] = static_cast<int>(v);
    std::ranges::sort(order, {}, [&](int v) { return std::pair(x(v, 0), v); });
    // Neighbours in x, or along another axis where the plane is across x: found by bisection.
    const auto find = [&](const Eigen::RowVector3d& y) {
        auto at = std::ranges::lower_bound(order, y[0] - same * diagonal, {}, [&](int v) { return x(v, 0); });
        for (; at != order.end() && x(*at, 0) <= y[0] + same * diagonal; ++at)
            if ((x.row(*at) - y).norm() <= same * diagonal) return *at;
        return -1;
    };
    for (Eigen::Index v = 0; v < x.rows(); ++v)
        if ((image[static_cast<std::size_t>(v)] = find(mirrored_point(plane, x.row(v)))) < 0)
            throw InvalidInput(text("wrap: vertex ", v, " has no mirror image about the plane of symmetry"));
    return image;
}

}  // namespace

std::vector<int> nearest_triangles(const TriMesh& from, const TriMesh& to) {
    const Points middle = triangle_centroids(from);
    const ClosestPointTree closest(to);
    std::vector<int> nearest(static_cast<std::size_t>(middle.rows()));
    for_blocks(static_cast<int>(middle.rows()), block, [&](int begin, int end) {
        for (int t = begin; t < end; ++t)
            nearest[static_cast<std::size_t>(t)] = closest.find(middle.row(t).transpose()).triangle;
    });
    return nearest;
}

WrapMap::WrapMap(TriMesh wrap, const TriMesh& body, const WrapMapOptions& options)
    : mesh_(std::move(wrap)),
      adjacent_(adjacency(mesh_)),
      held_(options.held),
      binding_([&] {
          WrapBindingOptions binding{options.held};
          binding.sums = options.sums;
          binding.max_centers = options.max_centers;
          const double diagonal = box_diagonal(mesh_);
          if (!options.plane) return WrapBinding(mesh_, body.vertices, binding);
          if (!options.is_half) {
              binding.image = images(mesh_.vertices, *options.plane, diagonal);
              return WrapBinding(mesh_, body.vertices, binding);
          }
          half_ = options.plane;
          BothHalves whole = with_mirror_image(mesh_, *options.plane, rounding * diagonal);
          image_ = binding.image = std::move(whole.image);
          return WrapBinding(whole.mesh, body.vertices, binding);
      }()),
      middle_(binding_.places(triangle_centroids(body))),
      wrap_triangle_(nearest_triangles(body, mesh_)),
      body_triangle_(nearest_triangles(mesh_, body)) {
    if (held_.empty()) held_.assign(static_cast<std::size_t>(body.num_vertices()), 0);
    set_held_triangles(body);
    if (!half_) return;
    const double near = on_cut * box_diagonal(body);
    for (int v = 0; v < body.num_vertices(); ++v)
        if (std::abs(half_->normal.dot(body.vertices.row(v)) - half_->offset) <= near) on_plane_.push_back(v);
}

void WrapMap::set_held_triangles(const TriMesh& body) {
    if (std::ranges::find(held_, 1) == held_.end()) return;
    is_held_triangle_.assign(static_cast<std::size_t>(body.num_triangles()), 1);
    for (int t = 0; t < body.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k)
            is_held_triangle_[static_cast<std::size_t>(t)] &=
                held_[static_cast<std::size_t>(body.triangles(t, k))] != 0;
}

/// Displacements of the whole wrap by those of its half.
Points WrapMap::both(const Points& of_half) const {
    if (of_half.rows() != mesh_.num_vertices())
        throw InvalidInput(text("wrap: ", of_half.rows(), " displacements for ", mesh_.num_vertices(), " vertices"));
    Points whole(static_cast<Eigen::Index>(image_.size()), 3);
    whole.topRows(of_half.rows()) = of_half;
    for (Eigen::Index v = of_half.rows(); v < whole.rows(); ++v)
        whole.row(v) = mirrored_vector(*half_, of_half.row(image_[static_cast<std::size_t>(v)]));
    return whole;
}

Points WrapMap::displacement(const Points& of_wrap) const {
    if (!half_) return binding_.displacement(of_wrap);
    Points moved = binding_.displacement(both(of_wrap));
    const Eigen::RowVector3d n = half_->normal.transpose();
    for (const int v : on_plane_) moved.row(v) -= moved.row(v).dot(n) * n;
    return moved;
}

std::vector<Points> WrapMap::transpose(const std::vector<Points>& of_body) const {
    if (!half_) return binding_.transpose(of_body);
    std::vector<Points> all = of_body;
    const Eigen::RowVector3d n = half_->normal.transpose();
    for (Points& g : all)
        for (const int v : on_plane_)
            if (g.rows() == static_cast<Eigen::Index>(held_.size())) g.row(v) -= g.row(v).dot(n) * n;
    return folded(binding_.transpose(all));
}

/// What acts on the mirror image acts on the half.
std::vector<Points> WrapMap::folded(std::vector<Points> all) const {
    for (Points& whole : all) {
        Points of_half = whole.topRows(mesh_.num_vertices());
        for (Eigen::Index v = of_half.rows(); v < whole.rows(); ++v)
            of_half.row(image_[static_cast<std::size_t>(v)]) += mirrored_vector(*half_, whole.row(v));
        whole = std::move(of_half);
    }
    return all;
}

std::vector<Points> WrapMap::transpose_at(const std::vector<int>& vertex, const Points& of_body) const {
    if (!half_) return binding_.transpose_at(vertex, of_body);
    Points g = of_body;
    const Eigen::RowVector3d n = half_->normal.transpose();
    for (std::size_t i = 0; i < vertex.size(); ++i)
        if (const auto row = static_cast<Eigen::Index>(i); std::ranges::binary_search(on_plane_, vertex[i]))
            g.row(row) -= g.row(row).dot(n) * n;
    return folded(binding_.transpose_at(vertex, g));
}

Points WrapMap::transpose(const Points& of_body) const { return transpose(std::vector<Points>{of_body})[0]; }

std::vector<Eigen::Matrix3d> WrapMap::local_maps(const Points& of_wrap) const {
    std::vector<Eigen::Matrix3d> maps(wrap_triangle_.size(), Eigen::Matrix3d::Identity());
    binding_.each_local_map(half_ ? both(of_wrap) : of_wrap, *middle_, [&](Eigen::Index t, const Eigen::Matrix3d& F) {
        if (!is_held_triangle(t)) maps[static_cast<std::size_t>(t)] = F;
    });
    return maps;
}

void WrapMap::add_to_maps(const Points& of_wrap, std::vector<Eigen::Matrix3d>& maps) const {
    if (maps.size() != wrap_triangle_.size())
        throw InvalidInput(text("wrap: ", maps.size(), " maps for ", wrap_triangle_.size(), " triangles of the body"));
    binding_.each_local_map(half_ ? both(of_wrap) : of_wrap, *middle_, [&](Eigen::Index t, const Eigen::Matrix3d& F) {
        if (!is_held_triangle(t)) maps[static_cast<std::size_t>(t)] += F - Eigen::Matrix3d::Identity();
    });
}

std::vector<int> WrapMap::carried(const std::vector<int>& body_triangles) const {
    std::vector<char> is_listed(wrap_triangle_.size(), 0), is_carried(body_triangle_.size(), 0);
    for (const int t : body_triangles) is_listed[static_cast<std::size_t>(t)] = 1;
    bool any = false;
    for (std::size_t w = 0; w < body_triangle_.size(); ++w)
        any |= is_carried[w] = is_listed[static_cast<std::size_t>(body_triangle_[w])];
    if (!any)
        for (const int t : body_triangles)
            is_carried[static_cast<std::size_t>(wrap_triangle_[static_cast<std::size_t>(t)])] = 1;
    std::vector<int> carried;
    for (std::size_t w = 0; w < is_carried.size(); ++w)
        if (is_carried[w]) carried.push_back(static_cast<int>(w));
    return carried;
}

ThinPlaces thinner_than(const TriMesh& body, const TriMesh& wrap, double than, int samples) {
    constexpr double surely = 0.9, opposite = 0.5;
    const Points middle = triangle_centroids(body), normal = triangle_normals(body);
    const Eigen::VectorXd area = triangle_areas(body);
    const ClosestPointTree near_body(body), near_wrap(wrap);
    const int stride = std::max(1, body.num_triangles() / std::max(1, samples));
    ThinPlaces thin;
    double sampled = 0, largest = 0;
    for (int t = 0; t < body.num_triangles(); t += stride) {
        sampled += area[t];
        const Eigen::Vector3d x = middle.row(t), n = normal.row(t), out = near_wrap.find(x).point - x;
        const Eigen::Vector3d inward = out.dot(n) > 0 ? Eigen::Vector3d(-n) : n;
        const ClosestPoint met = near_body.find(x + 0.5 * than * inward);
        if (met.distance > surely * 0.5 * than || std::abs(n.dot(normal.row(met.triangle))) < opposite) continue;
        thin.share += area[t];
        if (area[t] > largest) largest = area[t], thin.at = x;
    }
    if (sampled > 0) thin.share /= sampled;
    return thin;
}

}  // namespace strake
