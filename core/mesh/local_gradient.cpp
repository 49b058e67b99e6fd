#include "core/mesh/local_gradient.hpp"

namespace strake {
namespace {

using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Eigen::RowVector3d;
using Eigen::Vector3d;

}  // namespace

Gradients LocalGradient::apply(const Points& displacement) const {
    Gradients out = Gradients::Zero(arms_.area.size(), 9);
    for (Eigen::Index t = 0; t < arms_.triangles.rows(); ++t) {
        const RowVector3d n = arms_.normals.row(t);
        Matrix G = Matrix::Zero();
        for (int k = 0; k < 3; ++k) {
            const Vector3d u = displacement.row(arms_.triangles(t, k)), arm = arms_.arms.row(3 * t + k);
            G += u * arm.transpose() - arm * (n.dot(u) * n);
        }
        for (int k = 0; k < 3; ++k) out.row(arms_.triangles(t, k)) += Eigen::Map<const Gradients>(G.data(), 1, 9);
    }
    for (Eigen::Index v = 0; v < out.rows(); ++v) out.row(v) /= arms_.area[v] > 0 ? arms_.area[v] : 1.0;
    return out;
}

Points LocalGradient::transpose(const Gradients& g) const {
    Points back = Points::Zero(arms_.area.size(), 3);
    for (Eigen::Index t = 0; t < arms_.triangles.rows(); ++t) {
        const Vector3d n = arms_.normals.row(t);
        Matrix sum = Matrix::Zero();
        for (int k = 0; k < 3; ++k)
            if (const int v = arms_.triangles(t, k); arms_.area[v] > 0)
                sum += Eigen::Map<const Matrix>(g.row(v).data()) / arms_.area[v];
        for (int k = 0; k < 3; ++k) {
            const Vector3d arm = arms_.arms.row(3 * t + k), along = sum * arm;
            back.row(arms_.triangles(t, k)) += (along - arm.dot(sum * n) * n).transpose();
        }
    }
    return back;
}

}  // namespace strake
