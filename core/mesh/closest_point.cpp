#include "core/mesh/closest_point.hpp"

#include "core/error.hpp"
#include "core/floating_point_mode.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/point_triangle.hpp"

#include <embree3/rtcore.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace strake {
namespace {

constexpr double needle = 16;           ///< square of the longest edge over twice the area: from here on a needle
constexpr double box_rounding = 1e-12;  ///< of coordinates

/// A rectangle around a needle in its plane. Boxes along the axes of a needle askew hold most points nearby, and many
/// needles' boxes hold the same ones; of these few are as near as the rectangle tells.
struct Rectangle {
    Eigen::Vector3d corner, along, across, normal;  ///< unit vectors
    double length, height;

    /// At most the distance of x from the needle.
    double distance(const Eigen::Vector3d& x) const {
        const Eigen::Vector3d d = x - corner;
        const auto beyond = [](double t, double end) { return std::max({-t, t - end, 0.0}); };
        const double s = beyond(along.dot(d), length), w = beyond(across.dot(d), height), n = normal.dot(d);
        return std::sqrt(s * s + w * w + n * n);
    }
};

float step(float x, float towards) { return std::nextafter(std::nextafter(x, towards), towards); }
float rounded_down(double x) { return step(static_cast<float>(x), -std::numeric_limits<float>::infinity()); }
float rounded_up(double x) { return step(static_cast<float>(x), std::numeric_limits<float>::infinity()); }

}  // namespace

/// Embree's tree works in single precision and only preselects candidates: their boxes are rounded outward, the search
/// radius is rounded up beyond its arithmetic error, and decisive distances are computed in double precision.
/// Coordinates are first scaled to the unit box, because an offset would cost digits.
struct ClosestPointTree::Impl {
    TriMesh mesh;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double scale = 1;
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::vector<Rectangle> rectangles;
    std::vector<int> rectangle_of;  ///< per triangle, -1: it is no needle; empty: none is

    explicit Impl(const TriMesh& m) {
        mesh.vertices = m.vertices;
        mesh.triangles = m.triangles;
        const Box box = bounding_box(mesh);
        centre = box.min + 0.5 * (box.max - box.min);
        const double size = 0.5 * (box.max - box.min).maxCoeff();
        if (size > 0) scale = std::ldexp(1.0, -std::ilogb(size));
        find_needles();
        const KeepFloatingPointMode keep;  // Embree recommends flushing subnormal numbers to zero
        device = rtcNewDevice("threads=1,user_threads=1,set_affinity=0");
        if (!device) throw SolverError("closest-point tree: the Embree library cannot be started");
        build();
    }
    ~Impl() {
        if (scene) rtcReleaseScene(scene);
        if (device) rtcReleaseDevice(device);
    }

    Eigen::Vector3d unit(const Eigen::Vector3d& x) const { return (x - centre) * scale; }

    void find_needles() {
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            const auto corner = [&](int k) -> Eigen::Vector3d { return mesh.vertices.row(mesh.triangles(t, k % 3)); };
            int longest = 0;
            double length2 = 0;
            for (int k = 0; k < 3; ++k)
                if (const double l2 = (corner(k + 1) - corner(k)).squaredNorm(); l2 > length2)
                    longest = k, length2 = l2;
            const Eigen::Vector3d a = corner(longest), e = corner(longest + 1) - a, f = corner(longest + 2) - a;
            const double twice_area = e.cross(f).norm(), length = std::sqrt(length2);
            if (!(length2 > needle * twice_area)) continue;
            Rectangle found{a, e / length, {}, {}, length, 0};
            // Of a triangle without area the third corner may lie beside the edge by rounding: any plane will do then.
            const Eigen::Vector3d side = f - found.along.dot(f) * found.along;
            found.across = side.norm() > box_rounding * length ? side.normalized() : found.along.unitOrthogonal();
            found.normal = found.along.cross(found.across);
            found.height = std::max(0.0, found.across.dot(f));
            if (rectangle_of.empty()) rectangle_of.assign(static_cast<std::size_t>(mesh.num_triangles()), -1);
            rectangle_of[static_cast<std::size_t>(t)] = static_cast<int>(rectangles.size());
            rectangles.push_back(found);
        }
    }

    void build() {
        scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(mesh.num_triangles()));
        rtcSetGeometryUserData(geometry, this);
        rtcSetGeometryBoundsFunction(geometry, &Impl::bounds, nullptr);
        rtcSetGeometryPointQueryFunction(geometry, &Impl::visit);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene);
        if (rtcGetDeviceError(device) != RTC_ERROR_NONE)
            throw SolverError(
                text("closest-point tree: Embree cannot build a tree of ", mesh.num_triangles(), " triangles"));
    }

    static void bounds(const RTCBoundsFunctionArguments* args) {
        const auto& self = *static_cast<const Impl*>(args->geometryUserPtr);
        const auto t = static_cast<int>(args->primID);
        Eigen::Vector3d low = self.unit(self.mesh.vertices.row(self.mesh.triangles(t, 0))), high = low;
        for (int k = 1; k < 3; ++k) {
            const Eigen::Vector3d p = self.unit(self.mesh.vertices.row(self.mesh.triangles(t, k)));
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        }
        RTCBounds& out = *args->bounds_o;
        out.lower_x = rounded_down(low.x());
        out.lower_y = rounded_down(low.y());
        out.lower_z = rounded_down(low.z());
        out.upper_x = rounded_up(high.x());
        out.upper_y = rounded_up(high.y());
        out.upper_z = rounded_up(high.z());
    }

    struct Query {
        const Impl* self;
        Eigen::Vector3d x;
        double slack;     ///< what rounding x may shift it by
        double rounding;  ///< likewise of the distance to a rectangle
        ClosestPoint best;
    };

    /// By the rectangle of a needle: surely farther than what is known.
    bool is_farther(int t, const Query& query) const {
        if (rectangle_of.empty()) return false;
        const int r = rectangle_of[static_cast<std::size_t>(t)];
        return r >= 0 && rectangles[static_cast<std::size_t>(r)].distance(query.x) >
                             query.best.distance * (1 + 1e-9) + query.rounding;
    }

    /// A radius that stays above the distance found despite rounding in the tree.
    float radius(const Query& query) const {
        return rounded_up(query.best.distance * scale * (1 + 1e-5) + query.slack + 1e-30);
    }

    static bool visit(RTCPointQueryFunctionArguments* args) {
        auto& query = *static_cast<Query*>(args->userPtr);
        ClosestPoint& best = query.best;
        if (query.self->is_farther(static_cast<int>(args->primID), query)) return false;
        const ClosestPoint found = closest_point_on_triangle(query.self->mesh, static_cast<int>(args->primID), query.x);
        if (found.distance > best.distance) return false;
        if (found.distance == best.distance && found.triangle > best.triangle) return false;
        best = found;
        args->query->radius = query.self->radius(query);
        return true;
    }
};

ClosestPointTree::ClosestPointTree(const TriMesh& mesh) {
    if (mesh.num_triangles() == 0) throw InvalidInput("closest-point tree: the surface has no triangles");
    for (int i = 0; i < mesh.triangles.size(); ++i) {
        const int v = mesh.triangles.data()[i];
        if (v < 0 || v >= mesh.num_vertices() || !mesh.vertices.row(v).allFinite())
            throw InvalidInput(text("closest-point tree: triangle ", i / 3, " has vertex ", v, ", which is not one of ",
                                    mesh.num_vertices(), " finite vertices"));
    }
    impl_ = std::make_unique<Impl>(mesh);
}

ClosestPointTree::~ClosestPointTree() = default;

ClosestPoint ClosestPointTree::find(const Eigen::Vector3d& x) const {
    if (!x.allFinite()) throw InvalidInput(text("closest point: ", x.transpose(), " is not finite"));
    const Eigen::Vector3d unit = impl_->unit(x);
    const double size = 1 + unit.norm();
    // Coordinates far from the origin lose digits in the distances, too.
    const double rounding = box_rounding * (size / impl_->scale + x.norm());
    Impl::Query query{impl_.get(), x, 1e-6 * size, rounding, {}};
    query.best.triangle = std::numeric_limits<int>::max();
    query.best.distance = std::numeric_limits<double>::infinity();
    RTCPointQuery point{};
    point.x = static_cast<float>(unit.x());
    point.y = static_cast<float>(unit.y());
    point.z = static_cast<float>(unit.z());
    point.radius = std::numeric_limits<float>::infinity();
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(impl_->scene, &point, &context, nullptr, &query);
    return query.best;
}

}  // namespace strake
