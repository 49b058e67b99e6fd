#include "bench/coarse_to_fine/quantities.hpp"

#include "core/mesh/adjacency.hpp"
#include "core/mesh/geometry.hpp"

#include <cmath>
#include <cstring>
#include <numbers>

namespace strake::evidence {
namespace {

std::uint64_t mixed(std::uint64_t z) {  // the finalizer of splitmix64
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
}

double hash_of(const Points& v, std::uint64_t seed) {
    std::uint64_t h = mixed(seed);
    for (Eigen::Index i = 0; i < v.size(); ++i) {
        std::uint64_t bits;
        std::memcpy(&bits, v.data() + i, sizeof bits);
        h = mixed(h ^ bits);
    }
    return static_cast<double>(h >> 11) * 0x1p-52 - 1;
}

double value_at(const Quantity& q, const TriMesh& surface) {
    return q.evaluate({surface, false, 0, 0, {}}).values.at(0);
}

QuantityResult one(double value, Points dJ_dv) {
    QuantityResult result;
    result.values = {value};
    if (dJ_dv.rows() > 0) result.dJ_dv = {std::move(dJ_dv)};
    return result;
}

}  // namespace

double Draw::between(double low, double high) {
    state_ += 0x9E3779B97F4A7C15ull;
    return low + (high - low) * static_cast<double>(mixed(state_) >> 11) * 0x1p-53;
}

Eigen::Vector3d Draw::direction() {
    const double z = between(-1, 1), a = between(0, 2 * std::numbers::pi), r = std::sqrt(1 - z * z);
    return {r * std::cos(a), r * std::sin(a), z};
}

Quantity with_noise(const std::string& name, const Quantity& smooth, const TriMesh& start, std::uint64_t seed) {
    const double J0 = value_at(smooth, start);
    Quantity quantity;
    quantity.names = {name};
    quantity.evaluate = [smooth, J0, seed](const QuantityRequest& request) {
        QuantityResult r = smooth.evaluate(request);
        if (r.failure) return r;
        r.values[0] = (1 + r.values[0] / J0) * (1 + 1e-4 * hash_of(request.surface.vertices, seed));
        if (request.want_sensitivities) r.dJ_dv[0] /= J0;
        return r;
    };
    return quantity;
}

Quantity with_ripples(const std::string& name, const Quantity& smooth, const TriMesh& start, const Points& wanted,
                      const std::vector<std::vector<int>>& parcels, double share) {
    const Eigen::VectorXd area = vertex_areas(start);
    const auto mean = [area, wanted, parcels](const Points& v, std::size_t j) {
        double sum = 0, weight = 0;
        for (const int k : parcels[j]) sum += area[k] * (v(k, 2) - wanted(k, 2)), weight += area[k];
        return std::pair(sum / weight, weight);
    };
    Eigen::VectorXd wave(static_cast<Eigen::Index>(parcels.size()));
    for (Eigen::Index j = 0; j < wave.size(); ++j)
        wave[j] = std::abs(mean(start.vertices, static_cast<std::size_t>(j)).first) / 2.5;
    wave = wave.cwiseMax(0.1 * wave.maxCoeff()).eval();
    Quantity quantity;
    quantity.names = {name};
    quantity.evaluate = [=, J0 = value_at(smooth, start)](const QuantityRequest& request) {
        QuantityResult r = smooth.evaluate(request);
        if (r.failure) return r;
        r.values[0] /= J0;
        if (request.want_sensitivities) r.dJ_dv[0] /= J0;
        for (std::size_t j = 0; j < parcels.size(); ++j) {
            const auto [c, weight] = mean(request.surface.vertices, j);
            const double k = 2 * std::numbers::pi / wave[static_cast<Eigen::Index>(j)];
            const double height = share / static_cast<double>(parcels.size());
            r.values[0] += height * (1 - std::cos(k * c));
            if (request.want_sensitivities)
                for (const int v : parcels[j]) r.dJ_dv[0](v, 2) += height * k * std::sin(k * c) * area[v] / weight;
        }
        return r;
    };
    return quantity;
}

Quantity pair_thickness(const TriMesh& start, const std::vector<std::pair<int, int>>& pairs) {
    Eigen::VectorXd rest(static_cast<Eigen::Index>(pairs.size()));
    for (Eigen::Index i = 0; i < rest.size(); ++i) {
        const auto [a, b] = pairs[static_cast<std::size_t>(i)];
        rest[i] = start.vertices(a, 2) - start.vertices(b, 2);
    }
    Quantity quantity;
    quantity.names = {"thinnest", "thickest"};
    quantity.evaluate = [rest, pairs](const QuantityRequest& request) {
        constexpr double exponent = 60;
        QuantityResult result;
        for (const double sign : {-1.0, 1.0}) {
            Eigen::VectorXd weight(rest.size());
            for (Eigen::Index i = 0; i < rest.size(); ++i) {
                const auto [a, b] = pairs[static_cast<std::size_t>(i)];
                const double ratio = (request.surface.vertices(a, 2) - request.surface.vertices(b, 2)) / rest[i];
                weight[i] = sign * exponent * (ratio - 1);
            }
            const double largest = weight.maxCoeff();
            weight = (weight.array() - largest).exp();
            const double sum = weight.sum();
            result.values.push_back(1 + sign / exponent * (largest + std::log(sum / static_cast<double>(rest.size()))));
            if (!request.want_sensitivities) continue;
            Points d = Points::Zero(request.surface.num_vertices(), 3);
            for (Eigen::Index i = 0; i < rest.size(); ++i) {
                const auto [a, b] = pairs[static_cast<std::size_t>(i)];
                d(a, 2) += weight[i] / sum / rest[i];
                d(b, 2) -= weight[i] / sum / rest[i];
            }
            result.dJ_dv.push_back(std::move(d));
        }
        return result;
    };
    return quantity;
}

Quantity curvature_change(const TriMesh& start) {
    const Adjacency adjacent = adjacency(start);
    const int n = start.num_vertices();
    std::vector<std::vector<int>> neighbours(n);
    for (const auto& [a, b] : adjacent.edges) neighbours[a].push_back(b), neighbours[b].push_back(a);
    const Eigen::VectorXd area = vertex_areas(start);
    Eigen::VectorXd factor(n), share = area / area.sum() * std::pow(box_diagonal(start), 2);
    for (int k = 0; k < n; ++k) {
        double squares = 0;
        for (const int m : neighbours[k]) squares += (start.vertices.row(m) - start.vertices.row(k)).squaredNorm();
        factor[k] = 4 * static_cast<double>(neighbours[k].size()) / squares;
    }
    Quantity quantity;
    quantity.names = {"curvature_change"};
    quantity.evaluate = [=, rest = start.vertices](const QuantityRequest& request) {
        const Points u = request.surface.vertices - rest;
        Points Lu = Points::Zero(n, 3);
        double sum = 0;
        for (int k = 0; k < n; ++k) {
            Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
            for (const int m : neighbours[k]) mean += u.row(m);
            Lu.row(k) = factor[k] * (mean / static_cast<double>(neighbours[k].size()) - u.row(k));
            sum += share[k] * Lu.row(k).squaredNorm();
        }
        if (!request.want_sensitivities) return one(sum, {});
        Points d = Points::Zero(n, 3);
        for (int k = 0; k < n; ++k) {
            const Eigen::RowVector3d g = 2 * share[k] * factor[k] * Lu.row(k);
            d.row(k) -= g;
            for (const int m : neighbours[k]) d.row(m) += g / static_cast<double>(neighbours[k].size());
        }
        return one(sum, std::move(d));
    };
    return quantity;
}

}  // namespace strake::evidence
