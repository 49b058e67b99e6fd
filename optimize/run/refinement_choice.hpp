#pragma once
#include "optimize/run/level_program.hpp"
#include "optimize/run/run_state.hpp"
#include "optimize/space/refinement.hpp"

/// Whether a run by gradients refines, and what. Which patches and fields: optimize/space/refinement.hpp; what they
/// are expected to gain is weighed here, by what the run has gained so far.
namespace strake {

constexpr double max_correction = 100;  ///< for expected decreases that turned out too small

/// A plan, weighed.
struct RefinementChoice {
    RefinementPlan plan;
    std::optional<double> probed;  ///< how much softer the details are than the metric says; none: not known
    double times = 1;              ///< of the plan's expected decreases, what is expected
    bool is_idle = false;          ///< too little for what the plan costs
    int looked = 1;                ///< to this depth, in vain
    bool single_patches = false;   ///< these were looked at, by themselves
    std::string words() const;     ///< one line
};

/// What a level has found of the scale of expected decreases.
class RefinementScale {
public:
    /// @param last_times what the last refinement gained over what it was expected to
    /// @param knows_curvature of the level: decreases can be told. @param is_in_noise the level can do no more for
    /// noise
    RefinementScale(RunState& state, LevelProgram& program, double last_times, bool knows_curvature, bool is_in_noise)
        : state_(state),
          program_(program),
          last_times_(last_times),
          knows_curvature_(knows_curvature),
          is_in_noise_(is_in_noise) {}

    /// Single patches: with fields, then by themselves. Else by the parts of patches and fields; where these promise
    /// too little by parts of parts, and so on to the finest that a level could have all of
    /// (`Parameters::max_variable_ratio`). None: there is nothing finer.
    std::optional<RefinementChoice> choose(const DesignFacts& facts) const;

private:
    std::optional<RefinementChoice> weigh(const DesignFacts& facts, int depth) const;
    std::optional<double> probe(const DesignFacts& facts, const Forecast& forecast) const;
    int max_depth(const DesignSpace& space) const;
    double price(const RefinementPlan& plan) const;
    bool by_sensitivity() const { return state_.rest->parameters.split == SplitRule::sensitivity && knows_curvature_; }

    RunState& state_;
    LevelProgram& program_;
    double last_times_;
    bool knows_curvature_, is_in_noise_;
};

}  // namespace strake
