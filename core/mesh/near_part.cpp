#include "core/mesh/near_part.hpp"

#include <Eigen/Geometry>

namespace strake {

using Eigen::RowVector3d;
using Eigen::Vector3d;
using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Entry = Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator;

Points cross_rows(const Points& a, const Points& b) {
    Points out(a.rows(), 3);
    for (Eigen::Index i = 0; i < a.rows(); ++i) out.row(i) = RowVector3d(a.row(i)).cross(RowVector3d(b.row(i)));
    return out;
}

NearPart::NearPart(Eigen::Index points, int vertices) : weights_(points, vertices), offset_(Points::Zero(points, 3)) {
    weights_.reserve(3 * points);
    arms_.reserve(static_cast<std::size_t>(3 * points));
}

void NearPart::add(Eigen::Index p, const Points& vertices, const std::vector<std::pair<int, double>>& corners,
                   const Vector3d& closest, const Vector3d& offset) {
    weights_.startVec(p);
    for (const auto& [v, weight] : corners) {
        weights_.insertBack(p, v) = weight;
        arms_.emplace_back(corners.size() == 1 ? Vector3d::Zero()
                                               : Vector3d(0.5 * (closest - vertices.row(v).transpose())));
    }
    if (!corners.empty()) offset_.row(p) = offset;
}

Points NearPart::apply(const Points& u, const Points& w, const Gradients& gradients) const {
    Points out = weights_ * u + cross_rows(weights_ * w, offset_);
    std::size_t entry = 0;
    for (Eigen::Index p = 0; p < weights_.outerSize(); ++p)
        for (Entry k(weights_, p); k; ++k, ++entry)
            out.row(p) +=
                k.value() * (Eigen::Map<const Matrix>(gradients.row(k.col()).data()) * arms_[entry]).transpose();
    return out;
}

NearPart::Sensitivities NearPart::transpose(const Points& g) const {
    Sensitivities s{weights_.transpose() * g, weights_.transpose() * cross_rows(offset_, g),
                    Gradients::Zero(weights_.cols(), 9)};
    std::size_t entry = 0;
    for (Eigen::Index p = 0; p < weights_.outerSize(); ++p)
        for (Entry k(weights_, p); k; ++k, ++entry)
            Eigen::Map<Matrix>(s.gradients.row(k.col()).data()) +=
                k.value() * g.row(p).transpose() * arms_[entry].transpose();
    return s;
}

}  // namespace strake
