#include "optimize/space/refinement.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/space/shape_map.hpp"

#include <Eigen/QR>
#include <map>
#include <numeric>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double at_bound_share = 1e-6;  ///< of the range
/// Of the whole expected decrease, that fields are taken for: one more costs next to nothing, a patch an equilibrium.
constexpr double marked_fields = 0.99;

/// Parts of patches: the front that they are parts of, and of which of its patches each is one.
struct Parts {
    const DesignSpace& child;
    const Front& above;
    std::vector<int> owner;  ///< by the child's patches

    Parts(const DesignSpace& parts, const Front& front) : child(parts), above(front) {
        for (const Patch& patch : child.patches().patches)
            owner.push_back(above.patches.label[patch.triangles.front()]);
    }
};

/// Patches that have to be split together because variables tie their children, or themselves.
/// @param parent whose front the patches are; null: no space has them
std::vector<int> split_groups(const DesignSpace* parent, const Parts& parts) {
    std::vector<int> root(parts.above.depth.size());
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](int p) {
        while (root[p] != p) p = root[p];
        return p;
    };
    const auto tie = [&](const DesignSpace& space, const auto& owner) {
        for (const Variable& variable : space.variables)
            for (const DegreeOfFreedom& move : variable.moves) {
                if (variable.patch < 0) continue;
                const int a = find(owner(variable.patch)), b = find(owner(move.index / patch_dof::count));
                root[std::max(a, b)] = std::min(a, b);
            }
    };
    if (parent) tie(*parent, [](int patch) { return patch; });
    tie(parts.child, [&](int patch) { return parts.owner[patch]; });
    for (std::size_t p = 0; p < root.size(); ++p) root[p] = find(static_cast<int>(p));
    return root;
}

/// Shape variables by the group of the patch that they act on; `owner(variable)` is a patch of the parent.
template <class Owner>
std::vector<std::vector<int>> by_group(const DesignSpace& space, const std::vector<int>& group, const Owner& owner) {
    std::vector<std::vector<int>> members(group.size());
    for (int j = 0; j < space.num_shape(); ++j)
        if (space.variables[j].patch >= 0) members[group[owner(space.variables[j])]].push_back(j);
    return members;
}

/// A split each for the fields that the child has and the parent has not.
void offer_fields(const DesignSpace& parent, const DesignSpace& child, std::vector<SplitDecrease>& splits) {
    const std::vector<int>& there = parent.fields.numbers;
    for (int j = 0; j < child.num_shape(); ++j) {
        const Variable& v = child.variables[j];
        const int field = v.kind == VariableKind::field ? child.rest->parameters.user_variables[v.component].field : -1;
        if (field < 0 || std::ranges::binary_search(there, field)) continue;
        SplitDecrease more;
        more.names = v.name;
        more.field = field;
        more.variables = {j};
        more.new_variables = 1;
        splits.push_back(std::move(more));
    }
}

/// How many variables a split adds to a patch that no space has: it would have as many as the first of its parts.
int added_by_parts(const Parts& parts, const std::vector<int>& variables) {
    std::map<int, int> first;  // part, by owner
    return static_cast<int>(std::ranges::count_if(variables, [&](int j) {
        const int part = parts.child.variables[j].patch;
        return first.try_emplace(parts.owner[part], part).first->second != part;
    }));
}

/// Splits of the patches of the last front that is passed, in the order of their first patch; fields come last.
std::vector<SplitDecrease> possible_splits(const DesignSpace& parent, const DesignSpace& child,
                                           const std::vector<Front>& passed) {
    const Parts parts(child, passed.back());
    const std::vector<int> number = parts_of(*parent.rest->tree, parts.above);
    const bool is_next = passed.size() == 1;
    const std::vector<int> group = split_groups(is_next ? &parent : nullptr, parts);
    const auto new_ones = by_group(child, group, [&](const Variable& v) { return parts.owner[v.patch]; });
    std::vector<std::vector<int>> old_ones;
    if (is_next) old_ones = by_group(parent, group, [](const Variable& v) { return v.patch; });
    std::vector<SplitDecrease> splits;
    for (std::size_t g = 0; g < group.size(); ++g) {
        SplitDecrease split;
        bool has_parts = false;
        for (const Patch& patch : parts.above.patches.patches)
            if (group[patch.id] == static_cast<int>(g)) {
                split.patches.push_back(patch.id);
                split.names += (split.names.empty() ? "" : "+") + patch.name;
                has_parts |= number[patch.id] > 1;
            }
        split.variables = new_ones[g];
        split.new_variables = is_next ? static_cast<int>(new_ones[g].size()) - static_cast<int>(old_ones[g].size())
                                      : added_by_parts(parts, new_ones[g]);
        has_parts |= is_next && !parent.has_patches;
        if (has_parts && split.new_variables > 0) splits.push_back(std::move(split));
    }
    offer_fields(parent, child, splits);
    return splits;
}

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

/// The space's patches with the chosen ones of the last front split, and those of the fronts before it of which these
/// are parts; and its fields with these.
LevelSet refined(const DesignSpace& space, const std::vector<Front>& passed, std::vector<char> chosen,
                 const std::vector<int>& fields) {
    LevelSet next{*space.front, space.fields, space.has_patches};
    next.has_patches |= std::ranges::count(chosen, 1) > 0;
    std::vector<std::vector<char>> is_split{std::move(chosen)};  // from the last front to the first
    for (std::size_t k = passed.size() - 1; k > 0; --k) {
        std::vector<char> above(passed[k - 1].depth.size(), 0);
        for (const Patch& patch : passed[k].patches.patches)
            if (is_split.back()[patch.id]) above[patch.parent] = 1;
        is_split.push_back(std::move(above));
    }
    for (std::size_t k = 0; k < passed.size(); ++k, is_split.pop_back()) {
        std::vector<char> here;  // a patch that was left whole has no part that is split
        for (const Patch& patch : next.front.patches.patches)
            here.push_back(is_split.back()[passed[k].patches.label[patch.triangles.front()]]);
        next.front = split_front(*space.rest->tree, next.front, here);
    }
    for (Patch& patch : next.front.patches.patches) patch.parent = space.patches().label[patch.triangles.front()];
    next.fields.reach = offered_fields(space.rest->parameters, space.fields).reach;
    next.fields.numbers.insert(next.fields.numbers.end(), fields.begin(), fields.end());
    std::ranges::sort(next.fields.numbers);
    return next;
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
          passed_(below.passed),
          splits_(below.splits),
          known_(reachable(facts, below)),
          open_(open_gradient(facts, below, known_)) {
        all_ = open_.squaredNorm() / (2 * facts.curvature);
        const bool by_gradient = facts.space.rest->parameters.split == SplitRule::gradient;
        if (by_gradient) {
            by_integral();
            return;
        }
        const MatrixXd whitener = below.metric.matrixU();
        for (const SplitDecrease& split : splits_) {
            const MatrixXd columns = whitener(Eigen::all, split.variables);
            lengths_.push_back(columns.colwise().norm().maxCoeff());
            columns_.push_back(columns - known_ * (known_.transpose() * columns));
        }
    }

    /// What the next level is made of.
    LevelSet operator()(RefinementPlan& plan) {
        if (splits_.empty()) return with_more_fields(plan);
        std::vector<char> chosen(passed_.back().depth.size(), 0);
        std::vector<int> fields;
        std::vector<std::size_t> order;
        const Parameters& parameters = facts_.space.rest->parameters;
        const double all_patches = parameters.marking_fraction * all_;
        const double all_fields =
            parameters.offers_fields_by_steps ? all_patches : std::max(all_patches, marked_fields * all_);
        double held = 0;
        while ((held < all_fields || held == 0) && static_cast<int>(order.size()) < max_splits_) {
            const bool is_first = plan.chosen == 0 && held == 0;
            const std::optional<std::size_t> best =
                is_first ? next(1e300, 0, false)
                         : next(max_variables_ - plan.variables_after, min_per_variable_, held >= all_patches);
            if (!best) break;
            SplitDecrease& split = splits_[*best];
            split.chosen = true;
            held += split.decrease;
            plan.variables_after += split.new_variables;
            for (const int p : split.patches) chosen[p] = 1;
            if (split.field >= 0) fields.push_back(split.field);
            order.push_back(*best);
            if (!columns_.empty()) forget(orthonormal(columns_[*best], round_off * lengths_[*best]));
            if (split.decrease <= 0) break;
        }
        for (std::size_t s = 0; s < splits_.size(); ++s)
            if (!splits_[s].chosen) order.push_back(s);
        std::vector<SplitDecrease> sorted;
        for (const std::size_t s : order) sorted.push_back(std::move(splits_[s]));
        splits_ = std::move(sorted);
        plan.expected += all_;
        plan.chosen += held;
        return refined(facts_.space, passed_, std::move(chosen), fields);
    }

    double all() const { return all_; }
    std::vector<SplitDecrease> splits() const { return splits_; }

private:
    static constexpr double round_off = 1e-5;  ///< the metric's own, squared
    static constexpr double tie = 1e-6;

    /// No patch has finer parts: the next step of fields.
    LevelSet with_more_fields(RefinementPlan& plan) const {
        const DesignSpace& space = facts_.space;
        LevelSet next = refined(space, {*space.front}, std::vector<char>(space.front->depth.size(), 0), {});
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
            if (split.chosen || (fields_alone && split.field < 0)) continue;
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
    const std::vector<Front>& passed_;
    std::vector<SplitDecrease> splits_;
    MatrixXd known_;                 ///< orthonormal: what is reached without splits
    VectorXd open_;                  ///< what no chosen split can do yet
    std::vector<MatrixXd> columns_;  ///< per split: its variables, whitened, beyond what is chosen
    std::vector<double> lengths_;
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
    if (!space.has_patches) return true;
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

std::optional<Prospect> prospect(const DesignSpace& space, const VectorXd& x, int depth) {
    const PatchHierarchy& tree = *space.rest->tree;
    if (!has_finer(space)) return {};
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
    below.metric.compute(below.children.space.metric);
    below.inherited = below.metric.matrixU() * below.children.prolongation;
    below.known = span_of(below.inherited);
    return below;
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
    while (parameters.split == SplitRule::sensitivity && plan.variables_after < max_variables) {
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

std::string RefinementPlan::words() const {
    if (fields_at_once > 0)
        return text("no patch has finer parts, takes the next ", fields_at_once, " fields; ", variables_before, " -> ",
                    variables_after, " variables");
    int of_patches = 0, all_of_patches = 0, of_fields = 0, all_of_fields = 0;
    std::string names;
    for (const SplitDecrease& split : splits) {
        const bool is_field = split.field >= 0;
        ++(is_field ? all_of_fields : all_of_patches);
        if (!split.chosen) continue;
        const int count = of_patches + of_fields;
        ++(is_field ? of_fields : of_patches);
        if (count < 4) names += text(names.empty() ? "" : ", ", split.names, " ", percent(split.decrease / expected));
        if (count == 4) names += ", ...";
    }
    std::string what =
        depth > 1 ? text("parts of patches promise too little, their own parts more (depth ", depth, "): ") : "";
    if (all_of_fields > 0) what += text("takes ", of_fields, " of ", all_of_fields, " fields");
    if (all_of_patches > 0 || all_of_fields == 0)
        what += text(all_of_fields == 0 ? "" : " and ", "splits ", of_patches, " of ", all_of_patches);
    return text(what, " (", names, "), which hold ", expected > 0 ? std::round(1000 * chosen / expected) / 10 : 100.0,
                " % of the expected decrease of ", expected, "; ", variables_before, " -> ", variables_after,
                " variables");
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
