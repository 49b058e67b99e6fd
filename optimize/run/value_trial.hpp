#pragma once
#include "optimize/run/level_program.hpp"

/// Without gradients: which variables the next level has, by what the values along a few directions show. Internal.
namespace strake {

/// What a level leaves behind.
struct LeftLevel {
    Eigen::VectorXd x;        ///< its best design
    Eigen::VectorXd weight;   ///< of its program
    Eigen::MatrixXd hessian;  ///< its model of the Lagrangian, in y
    Eigen::VectorXd last_y;   ///< the last point with gradients, near x
    Evaluation last;          ///< there
};

/// Displacement fields and patches are two groups. Each is offered its next step of fineness. A random direction of
/// length 1 in the metric, within what the group can do beyond the present level, has the mean square slope
/// |gradient|^2 / n of the n directions there are: what each of them is expected to gain, times twice the curvature,
/// which one value further along the slopes tells.
/// - The group that gains more for each of its variables joins; the other one, too, where it gains at least a third.
/// - No group joins whose differences the evaluations that are left do not pay `affordable_gradients` times.
/// - A group that is there stays where its own gradient, known by then, gains at least a tenth for each variable; else
///   it is frozen, and returns by the same trial.
struct TrialResult {
    LevelSet next;
    bool stays = false;    ///< nothing new joins: what is there gains more
    bool is_idle = false;  ///< nothing is expected to gain: `next` has everything, to its end
};

/// A level of its own that evaluates its start and for each group `trial_directions` designs and one. On return the
/// state is as if the level before had just ended, but for the number of its level.
/// @param least decrease that counts. @param curvature of the Lagrangian over the metric.
TrialResult next_by_values(RunState& state, LevelProgram& program, const LeftLevel& left, double curvature,
                           double least);

inline constexpr int trial_directions = 6;
inline constexpr double affordable_gradients = 2;

}  // namespace strake
