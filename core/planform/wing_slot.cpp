#include "core/error.hpp"
#include "core/planform/wing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

/// The slot between two parts of a wing.
namespace strake {
namespace {

/// Whether the closed outlines go around the point an odd number of times.
bool is_inside(const PlanePoint& point, const std::vector<Outline>& outlines) {
    bool inside = false;
    for (const Outline& outline : outlines) {
        const auto& p = outline.points;
        for (std::size_t i = 0; outline.is_closed && i < p.size(); ++i) {
            const PlanePoint &a = p[i], &b = p[(i + 1) % p.size()];
            if ((a.z.value > point.z.value) == (b.z.value > point.z.value)) continue;
            const double share = (point.z.value - a.z.value) / (b.z.value - a.z.value);
            inside ^= point.x.value < a.x.value + share * (b.x.value - a.x.value);
        }
    }
    return inside;
}

/// Distance of the point from the outlines, negative inside of closed ones.
Varying signed_distance(const PlanePoint& point, const std::vector<Outline>& outlines) {
    struct {
        double distance = std::numeric_limits<double>::infinity(), share = 0;
        const PlanePoint *from = nullptr, *to = nullptr;
    } nearest;
    for (const Outline& outline : outlines) {
        const std::size_t count = outline.points.size(), last = outline.is_closed ? count : count - 1;
        for (std::size_t i = 0; i < last; ++i) {
            const PlanePoint &a = outline.points[i], &b = outline.points[(i + 1) % count];
            const double x = b.x.value - a.x.value, z = b.z.value - a.z.value, length2 = x * x + z * z;
            const double to_x = point.x.value - a.x.value, to_z = point.z.value - a.z.value;
            const double share = length2 > 0 ? std::clamp((to_x * x + to_z * z) / length2, 0.0, 1.0) : 0;
            const double distance = std::hypot(to_x - share * x, to_z - share * z);
            if (distance < nearest.distance) nearest = {distance, share, &a, &b};
        }
    }
    if (!nearest.from) throw InvalidInput("a section without points");
    const double sign = is_inside(point, outlines) ? -1 : 1;
    if (nearest.share <= 0 || nearest.share >= 1)
        return sign * length(point - (nearest.share <= 0 ? *nearest.from : *nearest.to));
    const PlanePoint along = *nearest.to - *nearest.from;
    const Varying height = cross(along, point - *nearest.from) / length(along);
    return (height.value < 0 ? -sign : sign) * height;
}

}  // namespace

SlotFacts Wing::slot(const TriMesh& surface, const Wing& ahead, double station, bool sensitivities) const {
    SlotFacts slot;
    const double share = 1.0 / num_sides();
    for (const Side& side : sides_) {
        const auto front = std::find_if(ahead.sides_.begin(), ahead.sides_.end(),
                                        [&](const Side& other) { return other.span.dot(side.span) > 0; });
        const double place = place_of(side, station);
        const auto refuse = [&](const Wing& wing) {
            throw InvalidInput(text("wing '", wing.declared_.name, "' has no section at ", 100 * place,
                                    " % of the semispan of '", declared_.name, "'"));
        };
        if (front == ahead.sides_.end()) refuse(ahead);
        Plane at = plane(surface, side, place, sensitivities);
        const std::vector<Outline> own = outlines(surface, side, at, sensitivities);
        const auto rear = Airfoil::from(own, corner_of_noses());
        if (!rear) refuse(*this);
        at.near.reset();
        const auto before = ahead.section(surface, *front, at, sensitivities);
        if (!before) refuse(ahead);
        slot.gap = slot.gap + share * signed_distance(before->trailing_edge(), own);
        slot.overlap = slot.overlap + share * (before->trailing_edge().x - rear->leading_edge().x);
    }
    return slot;
}

}  // namespace strake
