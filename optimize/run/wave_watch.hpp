#pragma once
#include "optimize/run/level_program.hpp"

/// What a run by gradients does where its objective has many minima. Internal.
///
/// Waves on a smooth objective have a minimum each. Many fine variables follow the nearest one, few smooth ones the
/// valley that all lie in: these see the mean of waves that are shorter than what they move. A run takes finer fields
/// as soon as its gradient promises more by them, and that of waves promises much. So it watches its steps
/// (`parabola_misfit`): where they lead across waves while it has fields alone, it goes back to the first of them, at
/// its start, and searches them patiently: until they gain no more, whatever others promise. Waves that are seen there
/// again leave it open which of them the search has ended in: it begins there once more, at random changes of the
/// first fields, and the better end goes on. What came before is lost but for its best design, and is a few
/// evaluations. On all of it the seed decides, so that a resumed run does the same.
namespace strake {

class WaveWatch {
public:
    WaveWatch(RunState& state, LevelProgram& program);

    /// A level begins, at the run's start or where it goes back to it, or below another one.
    void enter_level();
    /// No other variables join before the end of the present level.
    bool is_patient() const { return is_patient_; }
    /// What the present level's search asks after its steps (`MinimizeOptions::on_misfit`); empty: nothing.
    std::function<bool(double misfit)> on_misfit();
    /// The level was left by `on_misfit`. The next one has the first fields.
    void go_back();
    bool goes_back() const { return goes_back_; }

    /// After a patient search that has seen waves: searches the level from another start, for no more evaluations than
    /// `first` has cost, and returns the better result, with the counts of both. Else, or where no other start has a
    /// valid shape, `first`. @param how of the first search
    MinimizeResult look_elsewhere(const NonlinearProgram& program, MinimizeOptions how, const MinimizeResult& first);

private:
    bool may_go_back() const;
    /// Random changes of the fields, halved until the shape is valid. Nothing: none is.
    std::optional<Eigen::VectorXd> another_start(const NonlinearProgram& program, unsigned seed) const;

    RunState& state_;
    LevelProgram& program_;
    const bool is_on_;
    bool is_patient_ = false, sees_waves_ = false;  ///< on the present level
    bool goes_back_ = false, has_gone_back_ = false;
};

}  // namespace strake
