#include "core/mesh/closest_point.hpp"

#include "core/error.hpp"
#include "core/floating_point_mode.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/point_triangle.hpp"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace strake {
namespace {

constexpr double long_sliver = 0.02;  ///< of the surface's extent
constexpr double is_diagonal = 8;     ///< heights of the triangle that its box is wide
constexpr int max_pieces = 256;       ///< of one triangle

float step(float x, float towards) { return std::nextafter(std::nextafter(x, towards), towards); }
float rounded_down(double x) { return step(static_cast<float>(x), -std::numeric_limits<float>::infinity()); }
float rounded_up(double x) { return step(static_cast<float>(x), std::numeric_limits<float>::infinity()); }

}  // namespace

/// Embree's tree works in single precision and only preselects candidates: their boxes are rounded outward, the search
/// radius is rounded up beyond its arithmetic error, and decisive distances are computed in double precision.
/// Coordinates are first scaled to the unit box, because an offset would cost digits.
/// A long sliver that lies askew is in the tree with several boxes, one behind the other: a single one would be nearly
/// empty, and a search would look into all of a fan's.
struct ClosestPointTree::Impl {
    TriMesh mesh;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double scale = 1;
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    struct Piece {
        int triangle, number, of;
    };
    std::vector<Piece> pieces;  ///< empty: each triangle is one

    Piece piece(unsigned id) const { return pieces.empty() ? Piece{static_cast<int>(id), 0, 1} : pieces[id]; }

    explicit Impl(const TriMesh& m) {
        mesh.vertices = m.vertices;
        mesh.triangles = m.triangles;
        const Box box = bounding_box(mesh);
        centre = box.min + 0.5 * (box.max - box.min);
        const double size = 0.5 * (box.max - box.min).maxCoeff();
        if (size > 0) scale = std::ldexp(1.0, -std::ilogb(size));
        const KeepFloatingPointMode keep;  // Embree recommends flushing subnormal numbers to zero
        cut_slivers();
        device = rtcNewDevice("threads=1,user_threads=1,set_affinity=0");
        if (!device) throw SolverError("closest-point tree: the Embree library cannot be started");
        build();
    }
    ~Impl() {
        if (scene) rtcReleaseScene(scene);
        if (device) rtcReleaseDevice(device);
    }

    Eigen::Vector3d unit(const Eigen::Vector3d& x) const { return (x - centre) * scale; }

    std::array<Eigen::Vector3d, 3> unit_corners(int t) const {
        std::array<Eigen::Vector3d, 3> p;
        for (int k = 0; k < 3; ++k)
            p[static_cast<std::size_t>(k)] = unit(mesh.vertices.row(mesh.triangles(t, k)).transpose());
        return p;
    }

    /// Twice as many boxes as there are triangles are shared out by the root of what is empty in theirs, which makes
    /// the sum of what is left least.
    void cut_slivers() {
        const int count = mesh.num_triangles();
        std::vector<double> empty(static_cast<std::size_t>(count), 0), useful(empty);
        double sum = 0;
        for (int t = 0; t < count; ++t) {
            const auto p = unit_corners(t);
            Eigen::Vector3d size = p[0].cwiseMax(p[1]).cwiseMax(p[2]) - p[0].cwiseMin(p[1]).cwiseMin(p[2]);
            std::sort(size.data(), size.data() + 3);
            if (size[2] < long_sliver) continue;
            const double twice_area = (p[1] - p[0]).cross(p[2] - p[0]).norm();
            if (size[1] * size[2] < is_diagonal * twice_area) continue;
            useful[static_cast<std::size_t>(t)] = size[1] * size[2] / std::max(twice_area, 1e-300);
            sum += empty[static_cast<std::size_t>(t)] = std::sqrt(size[1] * size[2]);
        }
        for (int t = 0; t < count && sum > 0; ++t) {
            const auto i = static_cast<std::size_t>(t);
            const double share = 2.0 * count * empty[i] / sum;
            const int of = 1 + static_cast<int>(std::min({share, useful[i], max_pieces - 1.0}));
            for (int number = 0; number < of; ++number) pieces.push_back({t, number, of});
        }
    }

    /// Of the part of a triangle between two planes across its longest extent.
    Eigen::AlignedBox3d box_of(const Piece& piece) const {
        const auto p = unit_corners(piece.triangle);
        Eigen::AlignedBox3d whole, part;
        for (const Eigen::Vector3d& corner : p) whole.extend(corner);
        if (piece.of == 1) return whole;
        int axis = 0;
        const double length = whole.sizes().maxCoeff(&axis);
        const auto plane = [&](int k) {
            return k == piece.of ? whole.max()[axis] : whole.min()[axis] + length * k / piece.of;
        };
        const double low = plane(piece.number), high = plane(piece.number + 1);
        for (std::size_t k = 0; k < 3; ++k) {
            const Eigen::Vector3d &a = p[k], &b = p[(k + 1) % 3];
            if (a[axis] >= low && a[axis] <= high) part.extend(a);
            for (const double at : {low, high})
                if ((a[axis] < at) != (b[axis] < at))
                    part.extend(Eigen::Vector3d(a + (at - a[axis]) / (b[axis] - a[axis]) * (b - a)));
        }
        return part.isEmpty() ? whole : part;
    }

    void build() {
        scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(
            geometry, static_cast<unsigned>(pieces.empty() ? mesh.num_triangles() : static_cast<int>(pieces.size())));
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
        const Eigen::AlignedBox3d box = self.box_of(self.piece(args->primID));
        const Eigen::Vector3d low = box.min(), high = box.max();
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
        const ClosestPoint found =
            closest_point_on_triangle(query.self->mesh, query.self->piece(args->primID).triangle, query.x);
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
