#include "cases/geometry/slender_body.hpp"

#include "cases/geometry/closed_body.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace strake::example {
namespace {

constexpr double pi = std::numbers::pi;

BodySkin revolved(const std::function<Eigen::Vector2d(double along)>& meridian) {
    return [meridian](double along, double around) {
        const Eigen::Vector2d m = meridian(along);
        return Eigen::Vector3d(m[0], m[1] * std::sin(pi * around), m[1] * std::cos(pi * around));
    };
}

}  // namespace

double sears_haack_radius(double k, double max_radius) {
    return max_radius * std::pow(std::max(0.0, 4 * k * (1 - k)), 0.75);
}

TriMesh wavy_body(int triangles, const WavyBodyShape& shape) {
    if (!(shape.waviness >= 0 && shape.waviness <= 0.9))
        throw InvalidInput(text("wavy_body: waviness ", shape.waviness, " must be in [0, 0.9]"));
    return closed_body(
        triangles, revolved([shape](double along) {
            const double k = 0.5 * (1 - std::cos(pi * along));  // dense at the pointed ends
            const double waves = 1 + shape.waviness * 4 * k * (1 - k) * std::sin(2 * pi * shape.waves * k);
            return Eigen::Vector2d(shape.length * k, sears_haack_radius(k, shape.max_radius) * std::sqrt(waves));
        }));
}

}  // namespace strake::example
