#include "objectives/aero/stream.hpp"

#include "core/error.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace strake {
namespace {

/// Current angle; sets `at` to its position among the parameters.
double angle_of(const std::string& name, const FlowAngle& angle,
                const std::vector<std::pair<std::string, double>>& parameters, int& at) {
    if (angle.variable.empty()) return angle.value;
    for (std::size_t i = 0; i < parameters.size(); ++i)
        if (parameters[i].first == angle.variable) {
            at = static_cast<int>(i);
            return parameters[i].second;
        }
    throw InvalidInput(text(name, ": there is no variable '", angle.variable, "'"));
}

}  // namespace

Eigen::VectorXd own_derivatives(const StreamState& at, const QuantityRequest& request,
                                const std::array<double, 2>& by_angle) {
    if (at.parameters[0] < 0 && at.parameters[1] < 0) return {};
    Eigen::VectorXd by_parameter = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(request.parameters.size()));
    for (int angle = 0; angle < 2; ++angle)
        if (at.parameters[angle] >= 0) by_parameter[at.parameters[angle]] += by_angle[angle];
    return by_parameter;
}

Eigen::VectorXd own_derivatives(const StreamState& at, const QuantityRequest& request,
                                const Eigen::Vector3d& by_drag_axis) {
    return own_derivatives(
        at, request,
        std::array<double, 2>{by_drag_axis.dot(at.by_angle[0].drag), by_drag_axis.dot(at.by_angle[1].drag)});
}

void check_stream(const std::string& name, const Stream& stream) {
    const double across = stream.forward.stableNormalized().cross(stream.up.stableNormalized()).norm();
    if (!stream.forward.allFinite() || !stream.up.allFinite() || !(across > 1e-6))
        throw InvalidInput(text(name, ": forward (", stream.forward.transpose(), ") and up (", stream.up.transpose(),
                                ") must be finite, not zero and not parallel"));
    for (const FlowAngle* angle : {&stream.alpha, &stream.beta})
        if (!std::isfinite(angle->value)) throw InvalidInput(text(name, ": angle = ", angle->value, " is not finite"));
}

StreamState stream_state(const std::string& name, const Stream& stream,
                         const std::vector<std::pair<std::string, double>>& parameters) {
    StreamState s;
    s.x = stream.forward.stableNormalized();
    const Eigen::Vector3d up = stream.up.stableNormalized();
    s.z = (up - up.dot(s.x) * s.x).normalized();
    s.y = s.z.cross(s.x);
    const double a = angle_of(name, stream.alpha, parameters, s.parameters[0]),
                 b = angle_of(name, stream.beta, parameters, s.parameters[1]);
    const double ca = std::cos(a), sa = std::sin(a), cb = std::cos(b), sb = std::sin(b);
    s.axes = {ca * cb * s.x - sb * s.y + sa * cb * s.z, ca * sb * s.x + cb * s.y + sa * sb * s.z, -sa * s.x + ca * s.z};
    s.by_angle[0] = {-sa * cb * s.x + ca * cb * s.z, -sa * sb * s.x + ca * sb * s.z, -ca * s.x - sa * s.z};
    s.by_angle[1] = {-ca * sb * s.x - cb * s.y - sa * sb * s.z, ca * cb * s.x - sb * s.y + sa * cb * s.z,
                     Eigen::Vector3d::Zero()};
    return s;
}

}  // namespace strake
