#include "objectives/aero/pressure.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace strake {

double stagnation_cp(double mach, double gamma) {
    if (!(mach >= 1) || !std::isfinite(mach)) throw InvalidInput(text("mach = ", mach, " must be >= 1 and finite"));
    if (!(gamma > 1) || !(gamma <= 2)) throw InvalidInput(text("gamma = ", gamma, " must be in (1, 2]"));
    const double m2 = mach * mach, g = gamma;
    const double behind = std::pow((g + 1) * (g + 1) / (4 * g - 2 * (g - 1) / m2), g / (g - 1));
    // p02/p over M^2, so that Mach numbers without limit stay finite.
    return 2 / g * (behind * ((1 - g) / m2 + 2 * g) / (g + 1) - 1 / m2);
}

double prandtl_meyer_angle(double mach, double gamma) {
    const double k = std::sqrt((gamma + 1) / (gamma - 1)), b = std::sqrt(std::max(0.0, mach * mach - 1));
    return k * std::atan(b / k) - std::atan(b);
}

PressureCoefficient expanded_cp(double mach, double gamma, double turn) {
    const double k = std::sqrt((gamma + 1) / (gamma - 1)), half = 0.5 * (gamma - 1);
    const double wanted = prandtl_meyer_angle(mach, gamma) + turn;
    const double scale = 2 / (gamma * mach * mach);
    if (wanted >= 0.5 * std::numbers::pi * (k - 1) * (1 - 1e-12)) return {-scale, 0};
    // Newton for q, b = sqrt(M^2 - 1) = k tan q, kept within what is known to enclose the root: nu(q) is convex and
    // concave.
    double low = std::atan(std::sqrt(mach * mach - 1) / k), high = 0.5 * std::numbers::pi, q = 0.5 * (low + high);
    for (int i = 0; i < 100; ++i) {
        const double b = k * std::tan(q), excess = k * q - std::atan(b) - wanted;
        (excess > 0 ? high : low) = q;
        const double next = q - excess / (k - k * (1 + b * b / (k * k)) / (1 + b * b));
        const double before = q;
        q = next > low && next < high ? next : 0.5 * (low + high);
        if (std::abs(q - before) <= 1e-15) break;
    }
    const double b = k * std::tan(q);
    const double m2 = 1 + b * b;
    const double ratio = std::pow((1 + half * mach * mach) / (1 + half * m2), gamma / (gamma - 1));
    return {scale * (ratio - 1), -scale * ratio * gamma * m2 / b};  // dp/p = -g M^2 / b dtheta
}

}  // namespace strake
