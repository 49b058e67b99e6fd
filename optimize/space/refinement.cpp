#include "optimize/space/refinement.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/space/possible_splits.hpp"
#include "optimize/space/shape_map.hpp"
#include "optimize/space/single_patches.hpp"

#include <Eigen/QR>
#include <numeric>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double at_bound_share = 1e-6;  ///< of the range
/// Of the whole expected decrease, that fields are taken for: one more costs next to nothing, a patch an equilibrium.
constexpr double marked_fields = 0.99;

/// Orthonormal basis of the columns; what is shorter than `round_off` does not count.
MatrixXd orthonormal(const MatrixXd& columns, double round_off) {
    if (columns.cols() == 0) return columns;
    Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
    Eigen::Index rank = 0;
    while (rank < std::min(columns.rows(), columns.cols()) && std::abs(qr.matrixR()(rank, rank)) > round_off) ++rank;
    return qr.householderQ() * MatrixXd::Identity(columns.rows(), rank);
}

MatrixXd span_of(const MatrixXd& whitened) { return orthonormal(whitened, 1e-9 * std::max(1e-300, whitened.norm())); }

/// What the space itself can do: variables at a bound beyond which it would get better can do nothing. Those of patches
/// without parts count as if they could: no split does it for them.
MatrixXd reachable(const DesignFacts& facts, const Prospect& below) {
    const DesignSpace& space = facts.space;
    const VectorXd g = design_gradient(space, facts.x, facts.lagrangian);
    std::vector<int> free;
    for (int j = 0; j < space.size(); ++j) {
        const double room = g[j] > 0 ? facts.x[j] - space.lower[j] : space.upper[j] - facts.x[j];
        const int patch = space.variables[j].patch;
        const bool may_split = patch >= 0 && below.parts[patch] > 1;
        if (!may_split || g[j] == 0 || room > at_bound_share * (space.upper[j] - space.lower[j])) free.push_back(j);
    }
    if (static_cast<int>(free.size()) == space.size()) return below.known;
    return span_of(below.inherited(Eigen::all, free));
}

/// The gradient of all children, whitened, without what can be done about it already.
VectorXd open_gradient(const DesignFacts& facts, const Prospect& below, const MatrixXd& known) {
    const VectorXd w =
        below.metric.matrixL().solve(design_gradient(below.children.space, below.children.x, facts.lagrangian));
    return w - known * (known.transpose() * w);
}

/// Integral of |dJ/dv| over each patch: a vertex gives each of its triangles its share of the area.
VectorXd integrated_sensitivity(const DesignSpace& space, const Points& dJ_dv) {
    const RestFacts& rest = *space.rest;
    VectorXd sum = VectorXd::Zero(static_cast<Eigen::Index>(space.patches().patches.size()));
    const TriMesh& elastic = rest.elastic();
    const Eigen::VectorXd& vertex_area = rest.elastic_vertex_area();
    const Points by_shell = pulled_to_shell(rest, dJ_dv);
    for (int t = 0; t < elastic.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            const int v = elastic.triangles(t, k);
            if (vertex_area[v] > 0)
                sum[space.patches().label[t]] += by_shell.row(v).norm() * rest.area[t] / 3 / vertex_area[v];
        }
    return sum;
}

/// Without those of fields, which move the whole surface: no integral over a patch is theirs.
std::vector<SplitDecrease> of_patches_only(const std::vector<SplitDecrease>& splits) {
    std::vector<SplitDecrease> left;
    std::ranges::copy_if(splits, std::back_inserter(left), [](const SplitDecrease& split) { return split.field < 0; });
    return left;
}

std::string percent(double share) { return text(std::isfinite(share) ? std::round(1000 * share) / 10 : 0.0, " %"); }

/// One round of splits within the growth that is allowed, the largest gain first; adds to the plan.
class Choice {
public:
    Choice(const DesignFacts& facts, const Prospect& below, double max_variables, double min_per_variable,
           int max_splits = std::numeric_limits<int>::max())
        : facts_(facts),
          max_variables_(max_variables),
          min_per_variable_(min_per_variable),
          max_splits_(max_splits),
          below_(below),
          splits_(below.splits),
          known_(reachable(facts, below)),
          open_(open_gradient(facts, below, known_)) {
        all_ = open_.squaredNorm() / (2 * facts.curvature);
        is_covered_.assign(below.children.space.front->depth.size(), 0);
        const bool by_gradient = facts.space.rest->parameters.split == SplitRule::gradient;
        if (by_gradient) {
            by_integral();
            return;
        }
        const MatrixXd whitener = below.metric.matrixU();
        for (const SplitDecrease& split : splits_) {
            const MatrixXd columns = split.directions.size() > 0 ? MatrixXd(whitener * split.directions)
                                                                 : MatrixXd(whitener(Eigen::all, split.variables));
            lengths_.push_back(columns.colwise().norm().maxCoeff());
            columns_.push_back(columns - known_ * (known_.transpose() * columns));
        }
    }

    /// What the next level is made of.
    LevelSet operator()(RefinementPlan& plan) {
        if (splits_.empty()) return with_more_fields(plan);
        std::vector<int> fields;
        std::vector<std::size_t> order;
        const double all_patches = facts_.space.rest->parameters.marking_fraction * all_;
        // One by one, patches are for what fields cannot do: a load that stands for more of it is large, and buckles.
        bool fields_alone = below_.takes_single_patches && expected_of_fields() >= all_patches;
        double held = 0, wanted = fields_alone ? wanted_of_fields(held) : std::max(all_patches, wanted_of_all());
        while ((held < wanted || held == 0) && static_cast<int>(order.size()) < max_splits_) {
            const bool is_first = plan.chosen == 0 && held == 0;
            if (!fields_alone && held >= all_patches)
                fields_alone = true, wanted = std::max(all_patches, wanted_of_fields(held));
            const std::optional<std::size_t> best =
                is_first ? next(1e300, 0, fields_alone)
                         : next(max_variables_ - plan.variables_after, min_per_variable_, fields_alone);
            if (!best) break;
            SplitDecrease& split = splits_[*best];
            held += split.decrease;
            plan.variables_after += split.new_variables;
            if (split.field >= 0) fields.push_back(split.field);
            order.push_back(*best);
            take(*best);
            if (split.decrease <= 0) break;
        }
        for (std::size_t s = 0; s < splits_.size(); ++s)
            if (!splits_[s].chosen) order.push_back(s);
        std::vector<SplitDecrease> sorted;
        for (const std::size_t s : order) sorted.push_back(std::move(splits_[s]));
        splits_ = std::move(sorted);
        plan.expected += all_;
        plan.chosen += held;
        return with_chosen(fields);
    }

    double all() const { return all_; }
    std::vector<SplitDecrease> splits() const { return splits_; }

private:
    static constexpr double round_off = 1e-5;  ///< the metric's own, squared
    static constexpr double tie = 1e-6;

    LevelSet with_chosen(const std::vector<int>& fields) const {
        std::vector<const SplitDecrease*> chosen;
        for (const SplitDecrease& split : splits_)
            if (split.chosen) chosen.push_back(&split);
        if (below_.takes_single_patches) return with_single_patches(facts_.space, chosen, fields);
        std::vector<char> is_split(below_.passed.back().depth.size(), 0);
        for (const SplitDecrease* split : chosen)
            for (const int p : split->patches) is_split[p] = 1;
        return refined(facts_.space, below_.passed, std::move(is_split), fields);
    }

    void take(std::size_t s) {
        splits_[s].chosen = true;
        for (const int p : splits_[s].covered) is_covered_[p] = 1;
        if (!columns_.empty()) forget(orthonormal(columns_[s], round_off * lengths_[s]));
    }
    /// By all fields that are offered and not chosen, beyond what is chosen.
    double expected_of_fields() const {
        std::vector<std::size_t> of_fields;
        for (std::size_t s = 0; s < columns_.size(); ++s)
            if (splits_[s].field >= 0 && !splits_[s].chosen) of_fields.push_back(s);
        MatrixXd columns(open_.size(), static_cast<Eigen::Index>(of_fields.size()));
        for (std::size_t k = 0; k < of_fields.size(); ++k)
            columns.col(static_cast<Eigen::Index>(k)) = columns_[of_fields[k]] / lengths_[of_fields[k]];
        return (orthonormal(columns, round_off).transpose() * open_).squaredNorm() / (2 * facts_.curvature);
    }
    double wanted_of_all() const {
        const Parameters& p = facts_.space.rest->parameters;
        return (p.offers_fields_by_steps ? p.marking_fraction : marked_fields) * all_;
    }
    /// What fields are taken for where so much is held: beside patches that come one by one, of what fields can do.
    double wanted_of_fields(double held) const {
        if (!below_.takes_single_patches) return wanted_of_all();
        return std::min(wanted_of_all(), marked_fields * (held + expected_of_fields()));
    }

    /// No patch has finer parts: the next step of fields.
    LevelSet with_more_fields(RefinementPlan& plan) const {
        const DesignSpace& space = facts_.space;
        LevelSet next = level_set_of(space);
        next.fields = more_fields(space.rest->parameters, space.fields);
        const auto more = next.fields.numbers.size() - space.fields.numbers.size();
        plan.fields_at_once = static_cast<int>(more);
        plan.variables_after += plan.fields_at_once;
        return next;
    }
    void by_integral() {
        splits_ = of_patches_only(splits_);
        const VectorXd integral = integrated_sensitivity(facts_.space, facts_.dJ_dv);
        all_ = 0;
        for (SplitDecrease& split : splits_) {
            for (const int p : split.patches) split.decrease += integral[p];
            all_ += split.decrease;
        }
    }
    /// The split, or the field, that gives most with no more than so many new variables, of those that give at least
    /// so much for each; renews the expected decreases of those not chosen.
    std::optional<std::size_t> next(double variables, double min_per_variable, bool fields_alone) {
        std::optional<std::size_t> best;
        for (std::size_t s = 0; s < splits_.size(); ++s) {
            SplitDecrease& split = splits_[s];
            if (split.chosen || (fields_alone && split.field < 0) || is_taken(split)) continue;
            if (!columns_.empty())
                split.decrease = (orthonormal(columns_[s], round_off * lengths_[s]).transpose() * open_).squaredNorm() /
                                 (2 * facts_.curvature);
            if (split.decrease < min_per_variable * split.new_variables) continue;
            // Where expected decreases agree (mirror images) the first counts, not the rounding.
            if (split.new_variables <= variables && (!best || worth(split) > (1 + tie) * worth(splits_[*best])))
                best = s;
        }
        return best;
    }
    /// Patches of which it is made have variables already, of this patch or others.
    bool is_taken(const SplitDecrease& split) const {
        return std::ranges::any_of(split.covered, [&](int p) { return is_covered_[p] != 0; });
    }
    /// Patches have about as many parts each; beside fields, which come one by one, the number counts.
    double worth(const SplitDecrease& split) const {
        return facts_.space.rest->parameters.fields ? split.decrease / split.new_variables : split.decrease;
    }
    void forget(const MatrixXd& done) {
        open_ -= done * (done.transpose() * open_);
        for (MatrixXd& columns : columns_) columns -= done * (done.transpose() * columns);
    }

    const DesignFacts& facts_;
    double max_variables_, min_per_variable_, all_ = 0;
    int max_splits_;
    const Prospect& below_;
    std::vector<SplitDecrease> splits_;
    MatrixXd known_;                 ///< orthonormal: what is reached without splits
    VectorXd open_;                  ///< what no chosen split can do yet
    std::vector<MatrixXd> columns_;  ///< per split: its variables, whitened, beyond what is chosen
    std::vector<double> lengths_;
    std::vector<char> is_covered_;  ///< per patch of the children: it is part of a chosen split
};

/// Expected decrease by all variables of the space.
double expected_decrease(const DesignFacts& facts) {
    const VectorXd g = design_gradient(facts.space, facts.x, facts.lagrangian);
    return g.dot(facts.space.metric.ldlt().solve(g)) / (2 * facts.curvature);
}

}  // namespace

bool has_finer(const DesignSpace& space) {
    const Parameters& p = space.rest->parameters;
    if (more_fields(p, space.fields).numbers.size() > space.fields.numbers.size()) return true;
    if (p.kinds.empty()) return false;  // finer patches without variables
    if (!space.has_patches || std::ranges::count(space.resting, 1) > 0) return true;
    const std::vector<int> parts = parts_of(*space.rest->tree, *space.front);
    return *std::max_element(parts.begin(), parts.end()) > 1;
}

Front split_everywhere(const PatchHierarchy& tree, const Front& front) {
    return split_front(tree, front, std::vector<char>(front.depth.size(), 1));
}

LevelSet refined_everywhere(const DesignSpace& space) {
    LevelSet next = refined(space, {*space.front}, std::vector<char>(space.front->depth.size(), 1), {});
    next.fields = more_fields(space.rest->parameters, space.fields);
    return next;
}

namespace {

/// With what the space itself can do.
Prospect analyzed(Prospect below) {
    below.metric.compute(below.children.space.metric);
    below.inherited = below.metric.matrixU() * below.children.prolongation;
    below.known = span_of(below.inherited);
    return below;
}

}  // namespace

std::optional<Prospect> prospect(const DesignSpace& space, const VectorXd& x, int depth) {
    const PatchHierarchy& tree = *space.rest->tree;
    if (!has_finer(space)) return {};
    if (space.rest->takes_single_patches) {
        if (depth > 2) return {};
        return analyzed(prospect_of_single_patches(space, x, depth == 1));
    }
    Prospect below;
    below.passed = {*space.front};
    for (int k = 1; k < depth; ++k) {
        const std::vector<int> parts = parts_of(tree, below.passed.back());
        if (space.rest->parameters.kinds.empty() || std::ranges::max(parts) == 1) return {};
        below.passed.push_back(split_everywhere(tree, below.passed.back()));
    }
    if (depth > 1 && std::ranges::max(parts_of(tree, below.passed.back())) == 1) return {};
    LevelSet all = refined(space, below.passed, std::vector<char>(below.passed.back().depth.size(), 1), {});
    if (depth == 1) all.fields = offered_fields(space.rest->parameters, space.fields);
    below.children = refine(space, x, all);
    below.splits = possible_splits(space, below.children.space, below.passed);
    below.parts = parts_of(tree, *space.front);
    return analyzed(std::move(below));
}

double expected_decrease_of(const DesignFacts& facts, const Prospect& below) {
    return open_gradient(facts, below, reachable(facts, below)).squaredNorm() / (2 * facts.curvature);
}

std::optional<Forecast> make_forecast(const DesignFacts& facts, int depth) {
    std::optional<Prospect> below = prospect(facts.space, facts.x, depth);
    if (!below || below->splits.empty()) return {};
    const VectorXd open = open_gradient(facts, *below, reachable(facts, *below));
    Forecast forecast;
    forecast.step = -below->metric.matrixU().solve(open) / facts.curvature;
    forecast.decrease = open.squaredNorm() / (2 * facts.curvature);
    forecast.below = std::move(*below);
    return forecast;
}

namespace {

/// By the splits of the prospect alone. Parts of parts bring those beside them, too: how many is known once they are
/// there, and where they are too many fewer are split.
RefinementPlan first_round(const DesignFacts& facts, const Prospect& below, double max_variables,
                           double min_per_variable) {
    for (int max_splits = std::numeric_limits<int>::max();;) {
        RefinementPlan plan;
        plan.variables_before = plan.variables_after = facts.space.size();
        plan.depth = static_cast<int>(below.passed.size());
        Choice choice(facts, below, max_variables, min_per_variable, max_splits);
        plan.next = choice(plan);
        plan.splits = choice.splits();
        if (plan.depth == 1) return plan;
        plan.variables_after = refine(facts.space, facts.x, plan.next).space.size();
        const auto chosen = std::ranges::count_if(plan.splits, [](const auto& split) { return split.chosen; });
        if (chosen <= 1 || plan.variables_after <= max_variables) return plan;
        const double share = (max_variables - plan.variables_before) / (plan.variables_after - plan.variables_before);
        max_splits = std::clamp(static_cast<int>(share * static_cast<double>(chosen)), 1, static_cast<int>(chosen) - 1);
    }
}

}  // namespace

RefinementPlan plan_refinement(const DesignFacts& facts, const Forecast& forecast, double min_per_variable) {
    const Parameters& parameters = facts.space.rest->parameters;
    const double max_variables = parameters.max_variable_ratio * std::max(1, facts.space.size());
    RefinementPlan plan = first_round(facts, forecast.below, max_variables, min_per_variable);
    InheritedSpace present{facts.space, facts.x, {}};
    const bool may_go_on = parameters.split == SplitRule::sensitivity && !forecast.below.takes_single_patches;
    while (may_go_on && plan.variables_after < max_variables) {
        present = refine(present.space, present.x, plan.next);
        const DesignFacts next{present.space, present.x, facts.lagrangian, facts.curvature, facts.dJ_dv};
        const std::optional<Prospect> below = prospect(present.space, present.x);
        if (!below || below->splits.empty()) break;
        Choice deeper(next, *below, max_variables, min_per_variable);
        if (deeper.all() <= 0.5 * expected_decrease(next)) break;
        const int variables = plan.variables_after;
        LevelSet finer = deeper(plan);
        if (plan.variables_after == variables) break;
        // One front for the caller: its parents are those of the space that the caller knows.
        for (Patch& patch : finer.front.patches.patches)
            patch.parent = facts.space.patches().label[patch.triangles.front()];
        plan.next = std::move(finer);
        ++plan.rounds;
    }
    return plan;
}

namespace {

/// How many of what there is are chosen.
std::string counted(const std::vector<SplitDecrease>& splits) {
    struct Count {
        int chosen = 0, all = 0;
    } fields, whole, single;
    for (const SplitDecrease& split : splits) {
        Count& count = split.field >= 0 ? fields : split.patches.empty() ? single : whole;
        ++count.all;
        count.chosen += split.chosen;
    }
    std::vector<std::string> parts;
    if (fields.all > 0) parts.push_back(text("takes ", fields.chosen, " of ", fields.all, " fields"));
    if (whole.all > 0 || splits.empty()) parts.push_back(text("splits ", whole.chosen, " of ", whole.all));
    if (single.chosen > 0)
        parts.push_back(text("gives variables to ", single.chosen, single.chosen == 1 ? " patch" : " patches", " of ",
                             single.all, " on all levels"));
    if (parts.empty()) parts.push_back("gives variables to no patch");
    std::string words = parts[0];
    for (std::size_t k = 1; k < parts.size(); ++k) words += (k + 1 == parts.size() ? " and " : ", ") + parts[k];
    return words;
}

}  // namespace

std::string RefinementPlan::words() const {
    if (fields_at_once > 0)
        return text("no patch has finer parts, takes the next ", fields_at_once, " fields; ", variables_before, " -> ",
                    variables_after, " variables");
    std::string names;
    int named = 0;
    for (const SplitDecrease& split : splits) {
        if (!split.chosen) continue;
        if (named < 4) names += text(names.empty() ? "" : ", ", split.names, " ", percent(split.decrease / expected));
        if (named++ == 4) names += ", ...";
    }
    const std::string what =
        depth > 1 ? text("parts of patches promise too little, their own parts more (depth ", depth, "): ") : "";
    return text(what, counted(splits), " (", names, "), which hold ",
                expected > 0 ? std::round(1000 * chosen / expected) / 10 : 100.0, " % of the expected decrease of ",
                expected, "; ", variables_before, " -> ", variables_after, " variables");
}

MatrixXd carried_hessian(const MatrixXd& parent_hessian, const MatrixXd& prolongation, const MatrixXd& child_metric,
                         double curvature) {
    const MatrixXd MP = child_metric * prolongation;
    const Eigen::LLT<MatrixXd> coarse(prolongation.transpose() * MP);
    const MatrixXd W = coarse.solve(MP.transpose()).transpose();
    MatrixXd H = curvature * (child_metric - W * MP.transpose()) + W * parent_hessian * W.transpose();
    return 0.5 * (H + H.transpose());
}

double mean_curvature(const MatrixXd& hessian, const MatrixXd& metric) {
    const auto log_of_determinant = [](const MatrixXd& m) {
        return 2 * Eigen::LLT<MatrixXd>(m).matrixLLT().diagonal().array().log().sum();
    };
    return std::exp((log_of_determinant(hessian) - log_of_determinant(metric)) / static_cast<double>(metric.rows()));
}

}  // namespace strake
