#include "cases/geometry/waverider.hpp"

#include "cases/geometry/rows.hpp"
#include "core/error.hpp"

#include <cmath>

namespace strake::example {
namespace {

/// Right half over (u along, 0 nose to 1 base; v across, 0 plane of symmetry to 1 leading edge).
Eigen::Vector3d skin(const WaveriderShape& shape, double u, double v, bool upper) {
    const double half_width = shape.half_span * std::pow(u, 0.75);
    const double droop = shape.anhedral * half_width * v * v;
    const double thickness = shape.height * std::pow(u, 1.5) * (1 - v * v);
    return {shape.length * u, half_width * v, (upper ? 0.35 : -0.65) * thickness - droop};
}

/// n + 1 values from 0 to 1 whose steps shrink by a constant factor, the last one `ratio` times smaller than the first.
std::vector<double> crowded(int n, double ratio) {
    const double factor = n > 1 ? std::pow(ratio, -1.0 / (n - 1)) : 1;
    std::vector<double> at(n + 1, 0);
    double step = 1;
    for (int k = 1; k <= n; ++k, step *= factor) at[k] = at[k - 1] + step;
    for (double& value : at) value /= at[n];
    return at;
}

TriMesh waverider_of_grid(const WaveriderShape& shape, int across) {
    const int along = across;
    const std::vector<double> v = crowded(across, shape.crowding);
    SurfaceBuilder builder{.mirror_axis = 1};
    const int nose = builder.add(skin(shape, 0, 0, true));
    std::vector<int> upper(across + 1, nose), lower(across + 1, nose);
    const auto quad = [&](int a, int b, int c, int d) {  // a-b the old row, d-c the new one
        const auto triangle = [&](int p, int q, int r) {
            if (p != q && q != r && p != r) builder.triangles.push_back({p, q, r});
        };
        triangle(a, b, c);
        triangle(a, c, d);
    };
    for (int i = 1; i <= along; ++i) {
        const double u = static_cast<double>(i) / along;
        std::vector<int> next_upper, next_lower;
        for (int k = 0; k <= across; ++k) {
            next_upper.push_back(builder.add(skin(shape, u, v[k], true)));
            next_lower.push_back(k < across ? builder.add(skin(shape, u, v[k], false)) : next_upper.back());
        }
        for (int k = 0; k < across; ++k) {
            quad(upper[k + 1], upper[k], next_upper[k], next_upper[k + 1]);
            quad(lower[k], lower[k + 1], next_lower[k + 1], next_lower[k]);
        }
        upper = std::move(next_upper), lower = std::move(next_lower);
    }
    for (int k = 0; k < across; ++k) {  // the base
        builder.triangles.push_back({upper[k], lower[k], upper[k + 1]});
        if (k + 1 < across) builder.triangles.push_back({upper[k + 1], lower[k], lower[k + 1]});
    }
    builder.mirror();
    return builder.mesh();
}

}  // namespace

TriMesh waverider(int triangles, const WaveriderShape& shape) {
    if (!(shape.crowding >= 1 && shape.crowding <= 1e4))
        throw InvalidInput(text("waverider: crowding ", shape.crowding, " must be in [1, 1e4]"));
    if (triangles < 1000 || triangles > 5'000'000)
        throw InvalidInput(text("triangles = ", triangles, " must be in [1000, 5000000]"));
    return waverider_of_grid(shape, static_cast<int>(std::lround(std::sqrt(triangles / 8.0))));
}

}  // namespace strake::example
