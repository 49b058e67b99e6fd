#pragma once
#include "optimize/nlp/surrogate/allowed_designs.hpp"
#include "optimize/nlp/surrogate/model_minimum.hpp"

/// Where models expect least, within what is known exactly. Internal to the search by models.
namespace strake {

class AllowedMinimum {
public:
    /// @param merit of values, the objective first: what decides between two minima.
    AllowedMinimum(Guard& guard, const SampledPoints& points, AllowedDesigns& allowed, ProposalRegion& region,
                   std::function<double(const Eigen::VectorXd& values)> merit)
        : guard_(guard), points_(points), allowed_(allowed), region_(region), merit_(std::move(merit)) {}

    /// The design where m - `deviations` s is least in the region (`model_minimum`, from z `from`). With `deviations` 0
    /// what is known exactly holds there exactly, and conditions of the limit of motion to first order: then the models
    /// serve for the slopes of exact constraints, or for what slopes at the centre leave open, whichever leads to less.
    /// What looks around (> 0) is for learning: within all limits it would see less of what lies beyond.
    Eigen::VectorXd of(const LocalModels& models, double deviations, const Eigen::VectorXd& from);
    /// What is expected there: of limits that are known exactly, what they are.
    Eigen::VectorXd expected(const LocalModels& models, const Eigen::VectorXd& x) const;

private:
    const NonlinearProgram& program() const { return guard_.program; }
    const KnownConstraints& known() const { return allowed_.known(); }
    void align(const LocalModels& models);
    Eigen::VectorXd corrected(const LocalModels& models, double deviations, const Eigen::VectorXd& from);
    bool has_corrected(const LocalModels& models, const Eigen::VectorXd& z);
    bool limit_step_to(const Eigen::VectorXd& z);
    Eigen::VectorXd projected(const Eigen::VectorXd& asked);
    double promise(const LocalModels& models, const Eigen::VectorXd& x) const;

    Guard& guard_;
    const SampledPoints& points_;
    AllowedDesigns& allowed_;
    ProposalRegion& region_;
    std::function<double(const Eigen::VectorXd& values)> merit_;
};

}  // namespace strake
