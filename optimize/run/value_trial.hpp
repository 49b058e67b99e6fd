#pragma once
#include "optimize/run/level_program.hpp"

/// Without gradients: which variables the next level has, by what the values along a few directions show. Internal.
namespace strake {

/// What a level leaves behind.
struct LeftLevel {
    Eigen::VectorXd x;       ///< its best design
    Eigen::VectorXd weight;  ///< of its program
    Eigen::VectorXd last_y;  ///< the last point with gradients, near x
    Evaluation last;         ///< there
    double radius = 1;       ///< of its trust region at the end, in the metric
};

/// Displacement fields and patches are two groups. Each is offered its next step of fineness, beside what is there of
/// it. A random direction of length 1 in the metric, within the n directions of such a part, has the mean square slope
/// |gradient|^2 / n. One value further along the slopes tells the curvature. What all n gain by a step no longer than
/// the trust region, over n, is what each variable is worth: it costs one evaluation a gradient.
/// - The group that gains more for each of its variables joins; the other one, too, where it gains at least 0.7 of
/// that.
/// - No group joins whose differences the evaluations that are left do not pay `affordable_gradients` times.
/// - What is there of a group stays where it gains at least a tenth for each variable; else it is frozen, and returns
///   by the same trial.
struct TrialResult {
    LevelSet next;
    bool stays = false;    ///< nothing new joins: what is there gains more
    bool is_idle = false;  ///< nothing is expected to gain: `next` has everything, to its end
};

/// A level of its own that evaluates its start and for each part `trial_directions` designs and one. On return the
/// state is as if the level before had just ended, but for the number of its level.
/// @param least decrease that counts. @param curvature of the Lagrangian over the metric.
TrialResult next_by_values(RunState& state, LevelProgram& program, const LeftLevel& left, double curvature,
                           double least);

inline constexpr int trial_directions = 6;
inline constexpr double affordable_gradients = 2;

}  // namespace strake
