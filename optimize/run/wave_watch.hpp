#pragma once
#include "optimize/run/level_program.hpp"

/// What a run does where its objective has many minima. Internal.
///
/// Waves on a smooth objective have a minimum each. Many fine variables follow the nearest one, few smooth ones the
/// valley that all lie in: these see the mean of waves that are shorter than what they move.
///
/// By gradients a run takes finer fields as soon as its gradient promises more by them, and that of waves promises
/// much. So it watches its steps (`parabola_misfit`): where they lead across waves while it has fields alone, it goes
/// back to the first of them, at its start, and searches them patiently: until they gain no more, whatever others
/// promise. What came before is lost but for its best design, and is a few evaluations.
///
/// By values, in long runs by models, waves shorten the steps. Where they were shortened more than once on the first
/// fields, a few points between the start and the best design tell whether that is the reason: along a parabola, as
/// smooth objectives nearly are, or across waves.
///
/// Waves on the first fields leave it open which of them the search has ended in: it begins there once more, at random
/// changes of these fields, and the better end goes on. On all of it the seed decides, so that a resumed run does the
/// same.
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

    /// After the search of a first level: where that has waves, it is searched from another start, or from more than
    /// one, for about as many evaluations as `first` has cost; by gradients each search that its share has cut goes on
    /// to its end. Returns the best result, with the counts of all; where there are no waves, no other start has a
    /// valid shape, or too few evaluations are left, `first`. A quantity that fails for good ends the result, too.
    /// @param how of the first search
    MinimizeResult look_elsewhere(const NonlinearProgram& program, const MinimizeOptions& how,
                                  const MinimizeResult& first);

private:
    double as_stated(double objective) const;
    /// So many times the evaluations, and the time, that the run has cost are left.
    bool has_left(double times) const;
    /// The search by values that has ended so may have been kept by waves, and the run can afford to look.
    bool may_look_along(const MinimizeOptions& how, const MinimizeResult& first) const;
    /// Evaluates points between the level's start and the best one, and counts them there. False, too, where one has
    /// no values.
    bool is_wavy_towards(const NonlinearProgram& program, MinimizeResult& best);
    /// Random changes of the fields, symmetric where values are, and halved until the shape is valid. Nothing: none is.
    std::optional<Eigen::VectorXd> another_start(const NonlinearProgram& program, unsigned seed, int number) const;
    MinimizeResult search(const NonlinearProgram& program, MinimizeOptions how);
    MinimizeResult finished(const NonlinearProgram& program, MinimizeOptions how, MinimizeResult result);
    MinimizeResult from_another_start(const NonlinearProgram& program, const MinimizeOptions& how,
                                      const MinimizeResult& first);

    RunState& state_;
    LevelProgram& program_;
    const bool is_on_, is_on_by_values_;
    bool is_patient_ = false, sees_waves_ = false;  ///< on the present level
    bool goes_back_ = false;
    bool is_back_ = false;  ///< the first fields are or were searched patiently: once is enough
    std::string failure_;   ///< why the last search, or look, ended
};

}  // namespace strake
