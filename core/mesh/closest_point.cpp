#include "core/mesh/closest_point.hpp"

#include "core/error.hpp"
#include "core/floating_point_mode.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/point_triangle.hpp"

#include <embree3/rtcore.h>

#include <cmath>
#include <limits>

namespace strake {
namespace {

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

    explicit Impl(const TriMesh& m) {
        mesh.vertices = m.vertices;
        mesh.triangles = m.triangles;
        const Box box = bounding_box(mesh);
        centre = box.min + 0.5 * (box.max - box.min);
        const double size = 0.5 * (box.max - box.min).maxCoeff();
        if (size > 0) scale = std::ldexp(1.0, -std::ilogb(size));
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
        double slack;  ///< what rounding x may shift it by
        ClosestPoint best;
    };

    /// A radius that stays above the distance found despite rounding in the tree.
    float radius(const Query& query) const {
        return rounded_up(query.best.distance * scale * (1 + 1e-5) + query.slack + 1e-30);
    }

    static bool visit(RTCPointQueryFunctionArguments* args) {
        auto& query = *static_cast<Query*>(args->userPtr);
        const ClosestPoint found = closest_point_on_triangle(query.self->mesh, static_cast<int>(args->primID), query.x);
        ClosestPoint& best = query.best;
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
    Impl::Query query{impl_.get(), x, 1e-6 * (1 + unit.norm()), {}};
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
