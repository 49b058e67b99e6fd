#include "optimize/nlp/sqp/border_cut.hpp"

#include "optimize/nlp/sqp/trust_region.hpp"

#include <cmath>
#include <vector>

namespace strake {

using Eigen::VectorXd;

namespace {

std::vector<double> z_scores_for(Eigen::Index variables) {
    if (variables > trust_region.max_z_score_variables) return {trust_region.only_z_score};
    return {std::begin(trust_region.z_scores), std::end(trust_region.z_scores)};
}

}  // namespace

void BorderCut::update() {
    std::optional<FailureCut>& cut = steps_.cut;
    cut.reset();
    expected_decrease_ = 0;
    const VectorXd& x = now_.x;
    const std::optional<FailureClassifier> classifier = now_.guard.border.classifier(x, now_.program.metric);
    if (!classifier) return;
    VectorXd d = steps_.step(now_.at.constraints);
    if (d.size() == 0) d = VectorXd::Zero(x.size());
    std::optional<FailureCut> best;
    for (const double z_score : z_scores_for(x.size())) {
        VectorXd linearized_at = d;
        for (int round = 0; round < trust_region.max_cut_rounds; ++round) {
            cut = classifier->cut(x + linearized_at, z_score);
            const VectorXd next = solve_model(steps_.last_model());
            if (next.size() == 0) break;
            d = next;
            if (std::abs(classifier->z_score(x + d) - z_score) < trust_region.cut_accuracy) break;
            linearized_at += 0.5 * (d - linearized_at);
        }
        const double probability = 0.5 * std::erfc(-classifier->z_score(x + d) / M_SQRT2);
        const double expected = merit_.expected_decrease(hessian_.matrix(), d) * probability;
        if (!best || expected > expected_decrease_) best = cut, expected_decrease_ = expected;
    }
    cut = best;
}

}  // namespace strake
