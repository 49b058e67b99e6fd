#pragma once
#include <cstddef>
#include <utility>
#include <vector>

/// Numbers that know their derivatives by a few coordinates of the surface. Internal to core/planform.
namespace strake {

/// A value and its nonzero derivatives, by forward differentiation. A coordinate is 3 v + c: c of vertex v.
struct Varying {
    double value = 0;
    std::vector<std::pair<int, double>> slope = {};  ///< (coordinate, derivative), ascending, each once

    Varying(double constant = 0) : value(constant) {}
    Varying(double at, std::vector<std::pair<int, double>> by) : value(at), slope(std::move(by)) {}
};

/// The value f and the derivative a da + b db.
Varying combined(double f, double a, const Varying& da, double b, const Varying& db);
Varying scaled(double f, double a, const Varying& da);  ///< the value f and the derivative a da

inline Varying operator+(const Varying& a, const Varying& b) { return combined(a.value + b.value, 1, a, 1, b); }
inline Varying operator-(const Varying& a, const Varying& b) { return combined(a.value - b.value, 1, a, -1, b); }
inline Varying operator*(const Varying& a, const Varying& b) {
    return combined(a.value * b.value, b.value, a, a.value, b);
}
inline Varying operator/(const Varying& a, const Varying& b) {
    return combined(a.value / b.value, 1 / b.value, a, -a.value / (b.value * b.value), b);
}
inline Varying operator-(const Varying& a) { return scaled(-a.value, -1, a); }
Varying sqrt(const Varying& a);
Varying atan2(const Varying& y, const Varying& x);
/// Sum of all terms, in their order.
Varying sum(const std::vector<Varying>& terms);

/// A point of a section: along the stream and up, both in the section's plane.
struct PlanePoint {
    Varying x, z;
};
inline PlanePoint operator+(const PlanePoint& a, const PlanePoint& b) { return {a.x + b.x, a.z + b.z}; }
inline PlanePoint operator-(const PlanePoint& a, const PlanePoint& b) { return {a.x - b.x, a.z - b.z}; }
inline PlanePoint operator*(const Varying& s, const PlanePoint& a) { return {s * a.x, s * a.z}; }
inline Varying dot(const PlanePoint& a, const PlanePoint& b) { return a.x * b.x + a.z * b.z; }
inline Varying cross(const PlanePoint& a, const PlanePoint& b) { return a.x * b.z - a.z * b.x; }
inline Varying length(const PlanePoint& a) { return sqrt(dot(a, a)); }

}  // namespace strake
