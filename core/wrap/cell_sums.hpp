#pragma once
#include "core/wrap/cell_polynomials.hpp"

#include <functional>
#include <vector>

/// Sums over a few hundred centres x_c at millions of points that stay where they are (`radial_sums.hpp`), quickly.
///
/// Points are put into boxes, halved until few centres are near. What the centres far from a box make in it is a
/// polynomial: the interpolant at its Chebyshev points, of a degree for which the distance of the nearest of them asks.
/// A box takes its parent's polynomial and adds centres that were too near for the parent; those near the smallest
/// boxes are summed one by one. Each sum is a fixed linear map of the weights to some 1e-10 of the largest displacement
/// (points and centres in a box of diagonal one), and `transpose` is its exact transpose.
namespace strake {

class CellSums {
public:
    CellSums() = default;
    /// @param cells false: centre by centre, with the bits of `radial_sums.hpp`; also where boxes would not pay off
    CellSums(Points at, const Points& center, bool cells);

    /// sum_c weights_c |x - x_c|^3 of each point (n x 3). @param weights a row per centre
    Points values(const RadialWeights& weights) const;
    /// Its transpose: per centre the sum over the points. @param values a row per point; a multiple of 3 columns
    Eigen::MatrixXd transpose(const Eigen::MatrixXd& values) const;
    /// Of values that are zero but at one point for every three columns, with the same bits: only boxes on the way to
    /// these are looked at. @param values three each (m x 3) @return centres x 3m
    Eigen::MatrixXd transpose_at(const std::vector<int>& points, const Points& values) const;
    /// Derivative of the values: sum_c 3 |x - x_c| weights_c (x - x_c)^T, to 1e-9 of the sum of the weights.
    std::vector<Eigen::Matrix3d> slopes(const RadialWeights& weights) const;
    /// The same, handed on point by point, from several threads: 72 bytes each are much of millions of points.
    void each_slope(const RadialWeights& weights,
                    const std::function<void(Eigen::Index point, const Eigen::Matrix3d& slope)>& consume) const;

    const Points& points() const { return at_; }  ///< in the order of the boxes, where there are any
    /// Terms and coefficients that `values` adds, all together; without boxes points times centres.
    double cost() const;
    double num_terms() const { return static_cast<double>(center_.rows()) * static_cast<double>(at_.rows()); }

private:
    struct Cell {
        int first = 0, count = 0;     ///< points, in the order of the boxes
        int parent = -1, child = -1;  ///< the first of two; none: one of the smallest
        Eigen::Vector3d middle, half;
        Degree degree{-1, -1, -1};   ///< of the polynomial; none: -1
        std::vector<int> far, near;  ///< centres that it adds; those that nobody above or here has added
        bool has_polynomial() const { return degree[0] >= 0; }
    };
    using Tensor = CellTensor;

    void divide();
    void choose(Cell& cell, const std::vector<int>& candidates) const;
    void classify(Cell& cell, const std::vector<int>& candidates, const std::vector<Degree>& needed, int most) const;
    double cost_of(const Cell& cell) const;
    Points nodes(const Cell& cell) const;
    std::vector<Tensor> polynomials(const RadialWeights& weights) const;
    Tensor from_parent(const Cell& cell, const Tensor& parent, bool transposed) const;
    template <class Work>
    void over_tiles(const RadialWeights& weights, const Work& work) const;
    Tensor moments(const Cell& cell, const Eigen::MatrixXd& values) const;
    Eigen::MatrixXd at_leaf(const Cell& cell, const Eigen::MatrixXd& mine, Tensor& moment) const;
    Eigen::MatrixXd pull_back_all(std::vector<Tensor>& moment, const std::vector<Eigen::MatrixXd>& of_near,
                                  const std::vector<char>& is_met, Eigen::Index columns) const;
    Eigen::MatrixXd pull_back(const Cell& cell, std::vector<Tensor>& moment, Tensor& mine, Eigen::Index columns) const;

    Points at_, center_;      ///< the points in the order of the boxes
    std::vector<int> order_;  ///< their numbers; empty: as given
    std::vector<Cell> cells_;
    std::vector<int> level_;   ///< first cell of each level, and the number of cells
    std::vector<int> leaves_;  ///< boxes that have no others
};

}  // namespace strake
