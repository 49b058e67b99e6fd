#include "optimize/space/motion_images.hpp"

#include "optimize/space/mirror.hpp"
#include "optimize/space/motion_limit.hpp"
#include "optimize/space/response_metric.hpp"
#include "optimize/space/rest_facts.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int num_neighbours = 6;
constexpr double same_side = 0.5;        ///< least cosine of normals
constexpr double regularization = 1e-3;  ///< of weights, of the mean squared distance
constexpr double same_place = 1e-6;      ///< diagonals

struct Weights {
    std::vector<int> samples;
    VectorXd values;
};

class Samples {
public:
    explicit Samples(const RestFacts& rest) : diagonal_(rest.diagonal) {
        const Points normal = vertex_normals(rest.surface);
        double area = 0;
        for (const int v : sampled_vertices(rest)) area += rest.vertex_area[v];
        for (const int v : sampled_vertices(rest)) {
            place_.push_back(rest.surface.vertices.row(v));
            normal_.push_back(normal.row(v));
            root_share_.push_back(std::sqrt(rest.vertex_area[v] / area));
        }
    }
    std::size_t size() const { return place_.size(); }
    const Vector3d& place(std::size_t s) const { return place_[s]; }
    const Vector3d& normal(std::size_t s) const { return normal_[s]; }
    double root_share(std::size_t s) const { return root_share_[s]; }  ///< of the area

    /// Of the samples that stand for what is at `there`.
    Weights weights(const Vector3d& there, const Vector3d& normal) const {
        std::vector<std::pair<double, int>> near;
        for (std::size_t s = 0; s < size(); ++s)
            if (root_share_[s] > 0 && normal_[s].dot(normal) > same_side)
                near.emplace_back((place_[s] - there).squaredNorm(), static_cast<int>(s));
        const auto count = std::min(near.size(), static_cast<std::size_t>(num_neighbours));
        std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
        near.resize(count);
        if (count > 0 && std::sqrt(near[0].first) < same_place * diagonal_) near.resize(1);
        Weights found;
        if (near.empty()) return found;
        MatrixXd offset(3, static_cast<Eigen::Index>(near.size()));
        for (const auto& [distance, s] : near) {
            offset.col(static_cast<Eigen::Index>(found.samples.size())) = place_[static_cast<std::size_t>(s)] - there;
            found.samples.push_back(s);
        }
        MatrixXd gram = offset.transpose() * offset;
        gram.diagonal().array() +=
            regularization * gram.diagonal().mean() + same_place * same_place * diagonal_ * diagonal_;
        found.values = gram.ldlt().solve(VectorXd::Ones(gram.rows()));
        found.values /= found.values.sum();
        return found;
    }

private:
    double diagonal_;
    std::vector<Vector3d> place_, normal_;
    std::vector<double> root_share_;
};

MatrixXd mirrored_samples(const RestFacts& rest, const MatrixXd& samples, const SymmetryPlane& plane) {
    const Samples at(rest);
    const Eigen::Matrix3d reflects = reflection(plane);
    MatrixXd mirrored = MatrixXd::Zero(samples.rows(), samples.cols());
    for (std::size_t s = 0; s < at.size(); ++s) {
        if (!(at.root_share(s) > 0)) continue;
        const Vector3d there = at.place(s) - 2 * (plane.normal.dot(at.place(s)) - plane.offset) * plane.normal;
        const Weights weights = at.weights(there, reflects * at.normal(s));
        auto rows = mirrored.middleRows<3>(static_cast<Eigen::Index>(3 * s));
        for (std::size_t k = 0; k < weights.samples.size(); ++k) {
            const auto from = static_cast<std::size_t>(weights.samples[k]);
            rows += at.root_share(s) / at.root_share(from) * weights.values[static_cast<Eigen::Index>(k)] * reflects *
                    samples.middleRows<3>(static_cast<Eigen::Index>(3 * from));
        }
    }
    return mirrored;
}

}  // namespace

MotionImages motion_images(const DesignSpace& space, const SymmetryPlane& plane) {
    const MatrixXd samples = responses_at_rest(space).samples;
    const MatrixXd product = samples.transpose() * mirrored_samples(*space.rest, samples, plane);
    MotionImages images{samples.transpose() * samples, 0.5 * (product + product.transpose())};
    for (int j = space.num_shape(); j < space.size(); ++j)
        images.motion(j, j) = images.image(j, j) = space.metric(j, j);
    return images;
}

}  // namespace strake
