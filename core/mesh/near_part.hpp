#pragma once
#include "core/mesh/local_gradient.hpp"

#include <Eigen/SparseCore>
#include <utility>
#include <vector>

/// The part of a `SurfaceMap` that follows the closest triangle. Internal.
namespace strake {

/// The map of point p, with closest point q, corners k, their shares b_k, displacements u_k, rotations w_k and
/// gradients G_k:
///   near(p) = sum_k b_k (u_k + G_k (q - v_k) / 2 + w_k x (p - q)).
/// Half of each corner's first-order term makes interpolation of a smooth displacement second-order accurate: sum b_k
/// u_k is too large by half of sum b_k (v_k - q)^T H (v_k - q), and sum b_k (u_k + G_k (q - v_k)) is too small by the
/// same amount. At a corner it is u_k.
class NearPart {
public:
    NearPart(Eigen::Index points, int vertices);
    /// Each row once, in order; `corners`: vertices and weights (barycentric share times the weight of the near part),
    /// ascending.
    void add(Eigen::Index p, const Points& vertices, const std::vector<std::pair<int, double>>& corners,
             const Eigen::Vector3d& closest, const Eigen::Vector3d& offset);
    void finish() { weights_.finalize(); }

    Points apply(const Points& u, const Points& w, const Gradients& gradients) const;
    /// Sensitivities by u, w and G of sum g . apply(u, w, G).
    struct Sensitivities {
        Points u, w;
        Gradients gradients;
    };
    Sensitivities transpose(const Points& g) const;

private:
    Eigen::SparseMatrix<double, Eigen::RowMajor> weights_;
    std::vector<Eigen::Vector3d> arms_;  ///< (q - v_k) / 2 of each entry of weights_
    Points offset_;                      ///< P x 3: p - q
};

/// a x b, row by row.
Points cross_rows(const Points& a, const Points& b);

}  // namespace strake
