#pragma once
#include "cases/geometry/wing.hpp"
#include "core/mesh/mesh.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

/// Wings whose planform is known exactly, for tests.
namespace strake {

/// Everything by the fraction of the semispan; sections are scaled NACA four-digit forms with a parabolic mean line.
struct Loft {
    using By = std::function<double(double)>;
    double semispan = 3;
    By chord = [](double s) { return 1 - 0.5 * s; };
    By quarter = [](double s) { return 0.25 + 1.2 * s; };     ///< x of the quarter chord
    By height = [](double s) { return 0.3 * s; };             ///< z of the quarter chord
    By twist = [](double s) { return 0.05 - 0.08 * s; };      ///< radians, nose up, about the quarter chord
    By thickness = [](double s) { return 0.14 - 0.04 * s; };  ///< over the chord
    By camber = [](double) { return 0.02; };                  ///< over the chord, at half of it
    double blunt = 0;                                         ///< thickness of the trailing edge over the chord
    double winglet = 0;                                       ///< share of the semispan's line that stands upright
    int panels = 40, cells = 24;
};

/// Structured surface, sections streamwise (upright on the winglet), closed by a flat tip; open at the root (y = 0)
/// where it is half, else closed by its mirror image in y.
inline TriMesh lofted(const Loft& loft, bool whole = false) {
    using Eigen::Vector3d;
    const int n = loft.panels, around = loft.blunt > 0 ? 2 * n + 1 : 2 * n;
    const double straight = 1 - loft.winglet;
    const auto row = [&](double s) {
        std::vector<Vector3d> points;
        const double c = loft.chord(s), a = loft.twist(s);
        const bool upright = s > straight + 1e-12;
        // The last point of the straight part lies in the mitre between both.
        const double lean = upright                                              ? std::numbers::pi / 2
                            : std::abs(s - straight) < 1e-12 && loft.winglet > 0 ? std::numbers::pi / 4
                                                                                 : 0;
        for (int k = 0; k < around; ++k) {
            const int i = k <= n ? k : loft.blunt > 0 ? 2 * n - k : 2 * n - k;  // from the trailing edge over the top
            const double x = 0.5 * (1 + std::cos(std::numbers::pi * i / n));
            const double half = example::naca_half_thickness(loft.thickness(s), x) + 0.5 * loft.blunt * x;
            const double z = 4 * loft.camber(s) * x * (1 - x) + (k <= n ? half : -half);
            const double dx = (x - 0.25) * c, dz = z * c / (lean > 0 && !upright ? std::cos(lean) : 1);
            const double along = loft.quarter(s) + std::cos(a) * dx + std::sin(a) * dz;
            const double normal = -std::sin(a) * dx + std::cos(a) * dz;
            const double y = std::min(s, straight) * loft.semispan, up = std::max(0.0, s - straight) * loft.semispan;
            points.emplace_back(along, y - std::sin(lean) * normal, loft.height(s) + up + std::cos(lean) * normal);
        }
        return points;
    };
    TriMesh mesh;
    const int first = whole ? -loft.cells : 0, rows = loft.cells - first + 1;
    mesh.vertices.resize(rows * around, 3);
    std::vector<Eigen::RowVector3i> triangles;
    for (int r = 0; r < rows; ++r) {
        const auto points = row(std::abs(first + r) / double(loft.cells));
        for (int k = 0; k < around; ++k) {
            Vector3d p = points[static_cast<std::size_t>(k)];
            if (first + r < 0) p[1] = -p[1];
            mesh.vertices.row(r * around + k) = p;
        }
        for (int k = 0; k < around && r + 1 < rows; ++k) {
            const int a = r * around + k, b = r * around + (k + 1) % around, c = a + around, d = b + around;
            if (first + r < 0) {  // the mirror image of the other side's diagonals
                triangles.emplace_back(a, c, d), triangles.emplace_back(a, d, b);
            } else {
                triangles.emplace_back(a, c, b), triangles.emplace_back(b, c, d);
            }
        }
    }
    const auto cap = [&](int r, bool flipped) {
        const auto add = [&](int a, int b, int c) {
            if (a != b && b != c && a != c) flipped ? triangles.emplace_back(a, c, b) : triangles.emplace_back(a, b, c);
        };
        for (int k = 0; k < n; ++k) {
            const int upper = r * around + k, next = upper + 1;
            const int lower = r * around + (around - k) % around, beyond = r * around + (around - k - 1) % around;
            const int low = loft.blunt > 0 ? r * around + around - 1 - k : lower;
            const int low_next = loft.blunt > 0 ? low - 1 : beyond;
            add(upper, low, next);
            add(next, low, low_next);
        }
    };
    cap(rows - 1, true);
    if (whole) cap(0, false);
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t) mesh.triangles.row(static_cast<Eigen::Index>(t)) = triangles[t];
    return mesh;
}

}  // namespace strake
