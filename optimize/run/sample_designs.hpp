#pragma once
#include "optimize/evaluate/limited_motion.hpp"

/// The designs of `sample`, by number. Internal to it.
namespace strake {

/// Design 0 is the start. Parameters are spread evenly between their bounds. The shape goes from the start in
/// directions spread evenly in the coordinates that the response metric whitens, over a share of the way to size 2 in
/// the metric, or to the motion limit where that is nearer (without a limit: to size 1). The share is spread as in a
/// ball of at most three dimensions: in one of many, nearly all points are at the border. With `Spread::levels` the
/// place in the whitened cube says direction and share. A design depends on its number, not on which were asked for
/// before.
class SampleDesigns {
public:
    /// @param most number of designs, the start included: what a Latin hypercube and levels are made for
    /// @param stop_wanted asked after every iteration of a deformation; may be empty
    /// @throws InvalidInput where `most` holds no two levels of each variable; SolverError: the given loads alone have
    /// no equilibrium.
    SampleDesigns(const Problem& problem, const DesignSpace& space, const Eigen::VectorXd& start, int most,
                  std::function<bool()> stop_wanted);

    /// The design of this number, in x. @throws Interrupted.
    Eigen::VectorXd design(int number);
    /// Number of designs that there can be, the start included.
    int count() const { return count_; }
    int levels() const { return levels_; }  ///< of each variable; 0: not `Spread::levels`

private:
    void choose_levels();
    int combinations(int levels, std::vector<Eigen::VectorXd>* places) const;
    Eigen::VectorXd place_of(int number);
    Eigen::VectorXd place_of_start() const;
    Eigen::VectorXd shape_towards(const Eigen::VectorXd& about, const Eigen::VectorXd& z, double share) const;

    const Problem& problem_;
    const DesignSpace& space_;
    Eigen::VectorXd start_;
    std::function<bool()> stop_wanted_;
    Eigen::Index shape_, parameters_;
    Eigen::MatrixXd U_;  ///< of the metric of the shape variables
    MotionLimit limit_;
    std::optional<Poses> datum_;
    int max_designs_, count_ = 0, levels_ = 0;
    Eigen::MatrixXd points_;  ///< in the unit cube, from `first_point_` on
    int first_point_ = 0;
    std::vector<Eigen::VectorXd> places_;  ///< of levels, in the unit cube
};

}  // namespace strake
