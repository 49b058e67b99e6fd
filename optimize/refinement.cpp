#include "optimize/refinement.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <Eigen/Cholesky>
#include <numeric>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Patches that have to be split together because variables tie their children.
std::vector<int> split_groups(const DesignSpace& parent, const DesignSpace& child) {
    std::vector<int> root(parent.patches().patches.size());
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](int p) {
        while (root[p] != p) p = root[p];
        return p;
    };
    for (const auto* space : {&parent, &child})
        for (const Variable& variable : space->variables)
            for (const Freedom& move : variable.moves) {
                if (variable.patch < 0) continue;
                const auto owner = [&](int patch) {
                    return space == &parent ? patch : child.patches().patches[patch].parent;
                };
                const int a = find(owner(variable.patch)), b = find(owner(move.index / slot::count));
                root[std::max(a, b)] = std::min(a, b);
            }
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

/// g.M^-1.g
double dual_square(const MatrixXd& M, const VectorXd& g) { return g.size() == 0 ? 0.0 : g.dot(M.ldlt().solve(g)); }

double detail_decrease(const VectorXd& g, const MatrixXd& M, const MatrixXd& P) {
    const double whole = dual_square(M, g);
    const double inherited = P.cols() == 0 ? 0.0 : dual_square(P.transpose() * M * P, P.transpose() * g);
    return std::max(0.0, whole - inherited);
}

/// Integral of |dJ/dv| over each patch: a vertex gives each of its triangles its share of the area.
VectorXd integrated_sensitivity(const DesignSpace& space, const Points& dJ_dv) {
    const RestFacts& rest = *space.rest;
    VectorXd sum = VectorXd::Zero(static_cast<Eigen::Index>(space.patches().patches.size()));
    for (int t = 0; t < rest.surface.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            const int v = rest.surface.triangles(t, k);
            if (rest.vertex_area[v] > 0)
                sum[space.patches().label[t]] += dJ_dv.row(v).norm() * rest.area[t] / 3 / rest.vertex_area[v];
        }
    return sum;
}

std::string percent(double share) { return text(std::isfinite(share) ? std::round(1000 * share) / 10 : 0.0, " %"); }

/// Expected decrease by all variables of the space.
double expected_decrease(const DesignFacts& facts) {
    return dual_square(facts.space.metric, design_gradient(facts.space, facts.x, facts.lagrangian)) /
           (2 * facts.curvature);
}

/// One round of splits within the growth that is allowed; adds to the plan.
std::vector<char> choose(std::vector<SplitPromise>& promises, const DesignFacts& facts, double most,
                         RefinementPlan& plan) {
    std::vector<char> chosen(facts.space.front->depth.size(), 0);
    double all = 0, held = 0;
    for (const SplitPromise& split : promises) all += split.promise;
    for (SplitPromise& split : promises) {
        if (held >= facts.space.rest->parameters.split_share * all && held > 0) break;
        const bool is_first = plan.chosen == 0 && held == 0;
        if (!is_first && plan.variables_after + split.new_variables > most) continue;
        split.chosen = true;
        held += split.promise;
        plan.variables_after += split.new_variables;
        for (const int p : split.patches) chosen[p] = 1;
    }
    plan.promised += all;
    plan.chosen += held;
    return chosen;
}

}  // namespace

std::optional<Prospect> prospect(const DesignSpace& space, const VectorXd& x) {
    const PatchHierarchy& tree = *space.rest->tree;
    std::vector<int> parts = parts_of(tree, *space.front);
    if (*std::max_element(parts.begin(), parts.end()) <= 1) return {};
    const std::vector<char> everything(parts.size(), 1);
    return Prospect{refine(space, x, split_front(tree, *space.front, everything)), std::move(parts)};
}

std::vector<SplitPromise> split_promises(const DesignFacts& facts, const Prospect& below) {
    const DesignSpace &parent = facts.space, &child = below.children.space;
    const std::vector<int> group = split_groups(parent, child);
    const auto old_ones = by_group(parent, group, [](const Variable& v) { return v.patch; });
    const auto new_ones =
        by_group(child, group, [&](const Variable& v) { return child.patches().patches[v.patch].parent; });
    const bool by_gradient = parent.rest->parameters.split == SplitRule::gradient;
    const VectorXd gradient = design_gradient(child, below.children.x, facts.lagrangian);
    const VectorXd integral = by_gradient ? integrated_sensitivity(parent, facts.dJ_dv) : VectorXd();
    std::vector<SplitPromise> promises;
    for (std::size_t g = 0; g < group.size(); ++g) {
        SplitPromise split;
        bool has_parts = false;
        for (const Patch& patch : parent.patches().patches)
            if (group[patch.id] == static_cast<int>(g)) {
                split.patches.push_back(patch.id);
                split.names += (split.names.empty() ? "" : "+") + patch.name;
                has_parts |= below.parts[patch.id] > 1;
                if (by_gradient) split.promise += integral[patch.id];
            }
        split.new_variables = static_cast<int>(new_ones[g].size()) - static_cast<int>(old_ones[g].size());
        if (!has_parts || split.new_variables <= 0) continue;
        if (!by_gradient)
            split.promise = detail_decrease(gradient(new_ones[g]), child.metric(new_ones[g], new_ones[g]),
                                            below.children.prolongation(new_ones[g], old_ones[g])) /
                            (2 * facts.curvature);
        promises.push_back(std::move(split));
    }
    std::stable_sort(promises.begin(), promises.end(),
                     [](const SplitPromise& a, const SplitPromise& b) { return a.promise > b.promise; });
    return promises;
}

RefinementPlan plan_refinement(const DesignFacts& facts) {
    const Parameters& parameters = facts.space.rest->parameters;
    const PatchHierarchy& tree = *facts.space.rest->tree;
    RefinementPlan plan;
    plan.front = *facts.space.front;
    plan.variables_before = plan.variables_after = facts.space.size();
    const double most = parameters.growth * std::max(1, plan.variables_before);
    std::optional<Prospect> below = prospect(facts.space, facts.x);
    if (!below) return plan;
    plan.promises = split_promises(facts, *below);
    InheritedSpace present{facts.space, facts.x, {}};
    plan.front = split_front(tree, plan.front, choose(plan.promises, facts, most, plan));
    while (parameters.split == SplitRule::sensitivity && plan.variables_after < most) {
        present = refine(present.space, present.x, plan.front);
        const DesignFacts next{present.space, present.x, facts.lagrangian, facts.curvature, facts.dJ_dv};
        below = prospect(present.space, present.x);
        if (!below) break;
        std::vector<SplitPromise> deeper = split_promises(next, *below);
        double promised = 0;
        for (const SplitPromise& split : deeper) promised += split.promise;
        if (promised <= 0.5 * expected_decrease(next)) break;
        const int variables = plan.variables_after;
        const std::vector<char> chosen = choose(deeper, next, most, plan);
        if (plan.variables_after == variables) break;
        // One front for the caller: its parents are those of the space that the caller knows.
        Front finer = split_front(tree, plan.front, chosen);
        for (Patch& patch : finer.patches.patches) patch.parent = facts.space.patches().label[patch.triangles.front()];
        plan.front = std::move(finer);
        ++plan.rounds;
    }
    return plan;
}

std::string RefinementPlan::words() const {
    int splits = 0;
    std::string names;
    for (const SplitPromise& split : promises)
        if (split.chosen && ++splits <= 4)
            names += text(names.empty() ? "" : ", ", split.names, " ", percent(split.promise / promised));
    if (promises.empty()) return "no patch has finer parts";
    return text("splits ", splits, " of ", promises.size(), " (", names, splits > 4 ? ", ..." : "", "), which hold ",
                promised > 0 ? std::round(1000 * chosen / promised) / 10 : 100.0, " % of the expected decrease of ",
                promised, "; ", variables_before, " -> ", variables_after, " variables");
}

ShellSensitivities weighted_sum(const std::vector<ShellSensitivities>& all, const VectorXd& weight) {
    ShellSensitivities sum = all[0];
    sum.force *= weight[0];
    sum.prism_height *= weight[0];
    sum.wrench *= weight[0];
    for (Eigen::Index i = 1; i < weight.size(); ++i) {
        sum.force += weight[i] * all[i].force;
        sum.prism_height += weight[i] * all[i].prism_height;
        sum.wrench += weight[i] * all[i].wrench;
    }
    return sum;
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
    return metric.llt().solve(hessian).trace() / static_cast<double>(metric.rows());
}

}  // namespace strake
