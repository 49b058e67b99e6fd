#pragma once
#include "objectives/quantity/quantity.hpp"

/// Tools of quantities with residuals.
namespace strake {

/// Collects the residuals and their derivatives.
class ResidualRows {
public:
    /// `points` of `width` rows each on a surface of `num_vertices`; weights equal until set.
    ResidualRows(int points, int width, int num_vertices);
    /// r of `row` and its derivative with respect to vertex `v` (added up).
    void set(int row, double r) { rows_.r[row] = r; }
    void add(int row, int v, const Eigen::Vector3d& dr_dv);
    void set_weight(int point, double weight) { rows_.weight[point] = weight; }
    /// @throws InvalidInput naming `what` and the first point that is not finite.
    Residuals finish(const std::string& what);

private:
    Residuals rows_;
    std::vector<Eigen::Triplet<double>> entries_;
};

/// The quantity J = sum of squares of the residuals, dJ/dv = 2 r^T dr/dv, for surfaces of these counts. InvalidInput
/// from the residuals becomes a failure of kind `undefined`.
Quantity sum_of_squares(const std::string& name, int num_vertices, int num_triangles,
                        const ResidualFunction& residuals);

/// `residuals` after a check of the counts and of finite vertices. @throws (when called) InvalidInput.
ResidualFunction checked(const std::string& name, int num_vertices, int num_triangles,
                         const ResidualFunction& residuals);

}  // namespace strake
