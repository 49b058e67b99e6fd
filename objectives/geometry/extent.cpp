#include "objectives/geometry/extent.hpp"

#include "core/error.hpp"
#include "objectives/quantity/finite.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace strake {

double smooth_max(const Eigen::VectorXd& x, double s, Eigen::VectorXd* weight) {
    Eigen::Index first = 0;
    const double top = x.maxCoeff(&first);
    if (s == 0) {
        if (weight) *weight = Eigen::VectorXd::Unit(x.size(), first);
        return top;
    }
    double sum = 0;
    if (weight) weight->resize(x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) {
        const double e = std::exp((x[i] - top) / s);
        sum += e;
        if (weight) (*weight)[i] = e;
    }
    if (weight) *weight /= sum;
    return top + s * std::log(sum);
}

Quantity extent(const std::string& name, const TriMesh& start, const Eigen::Vector3d& direction, double smoothing) {
    if (!direction.allFinite() || direction.isZero(0))
        throw InvalidInput(text(name, ": the direction (", direction.transpose(), ") must be finite and not zero"));
    if (!(smoothing >= 0) || !std::isfinite(smoothing))
        throw InvalidInput(text(name, ": smoothing = ", smoothing, " must be >= 0 and finite"));
    if (start.num_vertices() == 0) throw InvalidInput(text(name, ": the surface has no vertices"));
    const Eigen::Vector3d n = direction.stableNormalized();
    std::vector<std::string> names;
    for (const std::string& value : extent_values) names.push_back(name + "." + value);
    return checked_quantity(name, names, start, [=](const QuantityRequest& request) {
        const Eigen::VectorXd along = request.surface.vertices * n;
        const bool any = request.want_sensitivities;
        Eigen::VectorXd above, below;
        const double high = smooth_max(along, smoothing, any ? &above : nullptr);
        const double low = -smooth_max(-along, smoothing, any ? &below : nullptr);
        QuantityResult result{{high - low, low, high}, {}, {}};
        if (!any) return result;
        result.dJ_dv.resize(3);
        if (request.wants(0)) result.dJ_dv[0] = (above - below) * n.transpose();
        if (request.wants(1)) result.dJ_dv[1] = below * n.transpose();
        if (request.wants(2)) result.dJ_dv[2] = above * n.transpose();
        return result;
    });
}

}  // namespace strake
