#include "core/repair/checkup.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace strake {
namespace {

Histogram histogram(const std::vector<double>& limits, const std::vector<double>& values) {
    Histogram h{limits, std::vector<int>(limits.size() - 1)};
    for (const double value : values) {
        const auto above = std::upper_bound(limits.begin(), limits.end(), value) - limits.begin();
        ++h.counts[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(above - 1, 0, std::ssize(h.counts) - 1))];
    }
    return h;
}

std::vector<double> even(double last, int bins) {
    std::vector<double> limits;
    for (int i = 0; i <= bins; ++i) limits.push_back(last * i / bins);
    return limits;
}

}  // namespace

SurfaceQuality surface_quality(const TriMesh& mesh, const Adjacency& adjacent) {
    SurfaceQuality q;
    std::vector<double> lengths, angles_deg, ratios;
    for (const auto& [a, b] : adjacent.edges)
        lengths.push_back((mesh.vertices.row(a) - mesh.vertices.row(b)).stableNorm());
    for (const double length : lengths) q.edge_mean += length / static_cast<double>(lengths.size());
    const Points angles = corner_angles(mesh);
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        double product = 8;  // inradius = 4 circumradius sin(a/2) sin(b/2) sin(c/2)
        for (int k = 0; k < 3; ++k) {
            angles_deg.push_back(angles(t, k) * 180 / std::numbers::pi);
            product *= std::sin(0.5 * angles(t, k));
        }
        ratios.push_back(std::clamp(product, 0.0, 1.0));
        q.mean += ratios.back() / mesh.num_triangles();
    }
    std::vector<double> relative = lengths;
    for (double& length : relative) length = q.edge_mean > 0 ? length / q.edge_mean : 0;
    q.edges = histogram({0, 0.1, 0.25, 0.5, 0.8, 1.25, 2, 4, 10}, relative);
    q.angles_deg = histogram(even(180, 12), angles_deg);
    q.ratios = histogram(even(1, 10), ratios);
    for (auto* values : {&lengths, &angles_deg, &ratios}) std::sort(values->begin(), values->end());
    if (!lengths.empty()) {
        q.edge_min = lengths.front();
        q.edge_max = lengths.back();
        q.edge_median = lengths[lengths.size() / 2];
    }
    if (!ratios.empty()) {
        q.angle_min_deg = angles_deg.front();
        q.angle_max_deg = angles_deg.back();
        q.smallest = ratios.front();
        q.fifth_percentile = ratios[ratios.size() / 20];
    }
    for (int v = 0; v < mesh.num_vertices(); ++v)
        q.max_valence = std::max(q.max_valence, static_cast<int>(adjacent.vertex_triangles[v].size()));
    return q;
}

}  // namespace strake
