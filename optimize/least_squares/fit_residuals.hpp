#pragma once
#include "optimize/least_squares/least_squares.hpp"
#include "optimize/problem/problem.hpp"

/// The residuals of all fitted quantities of a problem, one below the other, under its loss. Internal to `fit`.
namespace strake {

/// A trial shape on which a fitted quantity is undefined, which the quantity calls a step too far.
struct ResidualsUndefined : std::runtime_error {
    using runtime_error::runtime_error;
};

class FitResiduals {
public:
    /// @throws InvalidInput: nothing to fit, an unknown name, a quantity without residuals, a wrong option.
    explicit FitResiduals(const Problem& problem);

    struct Rows {
        Eigen::VectorXd r;                                                ///< N
        std::vector<Eigen::SparseMatrix<double, Eigen::RowMajor>> dr_dv;  ///< one a quantity, together N x 3n
    };
    /// Matches are looked for on `matched`. @throws ResidualsUndefined where a quantity with `failing_shortens_step`
    /// refuses the shape, SolverError for residuals of wrong size or not finite, and what the quantities throw.
    Rows at(const TriMesh& surface, const TriMesh& matched) const;

    /// Column j of dr/dx from dv/dx_j (n x 3).
    static void set_column(const Rows& rows, int j, const Points& dv, RowMajorMatrix& dr_dx);

private:
    std::vector<const Quantity*> fitted_;
    Loss loss_;
    double scale_;  ///< length
};

}  // namespace strake
