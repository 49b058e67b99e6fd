#include "optimize/run/sample_effects.hpp"

#include "core/error.hpp"
#include "optimize/nlp/surrogate/main_effects.hpp"
#include "optimize/run/design_table.hpp"

#include <cmath>
#include <numeric>
#include <random>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Rows = std::vector<Eigen::Index>;

constexpr int fewest_for_effects = 10;
/// A model costs some 100 times 2 n^3 + n^2 d flops, and n^2 d numbers in memory.
constexpr double max_for_effects = 500, max_squares = 60 * max_for_effects * max_for_effects;
constexpr double no_effect = 1e-3;  ///< total effect below which a variable has none
constexpr double good_enough =
    0.995;                        ///< predicted share of a model that may say so: what it misses could be an effect
constexpr std::size_t named = 5;  ///< of names in a message

/// Indices from 0 to `count` - 1 in an order of their own, the same on every machine.
Rows shuffled(Eigen::Index count) {
    Rows order(static_cast<std::size_t>(count));
    std::iota(order.begin(), order.end(), 0);
    std::mt19937_64 random(1);
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
    return order;
}

/// The first of two names or of many, with how many follow.
std::string few(const std::vector<std::string>& names) {
    std::string words;
    for (std::size_t k = 0; k < std::min(named, names.size()); ++k) words += (k > 0 ? ", " : "") + names[k];
    return names.size() > named ? text(words, " and ", names.size() - named, " more") : words;
}

class Learning {
public:
    Learning(const Problem& problem, const DesignSpace& space, SampleSummary& samples)
        : problem_(problem), space_(space), samples_(samples), table_(*samples.table) {
        for (int i = 0; i < table_.rows(); ++i)
            if (table_.status[static_cast<std::size_t>(i)] == "ok") ok_.push_back(i);
    }

    void run() {
        remark_equal_designs();
        remark_constant_values();
        set_ranges();
        if (!can_learn()) return;
        choose_rows();
        set_effects();
        remark_idle_variables();
    }

private:
    const std::string& variable(Eigen::Index j) const { return table_.variables[static_cast<std::size_t>(j)]; }
    const char* row_word() const { return problem_.table ? "rows " : "designs "; }

    /// Only the first pair: the remedy is the same for all.
    void remark_equal_designs() {
        Rows order = ok_;
        const auto less = [&](Eigen::Index a, Eigen::Index b) {
            for (Eigen::Index j = 0; j < table_.designs.cols(); ++j)
                if (table_.designs(a, j) != table_.designs(b, j)) return table_.designs(a, j) < table_.designs(b, j);
            return false;
        };
        std::ranges::stable_sort(order, less);
        for (std::size_t k = 1; k < order.size(); ++k) {
            const Eigen::Index a = order[k - 1], b = order[k];
            if (less(a, b)) continue;
            std::string words = text(row_word(), a + 1, " and ", b + 1, " are the same design");
            for (Eigen::Index v = 0; v < table_.given.cols(); ++v)
                if (table_.given(a, v) != table_.given(b, v)) {
                    samples_.remarks.push_back(text(words, ", with ", table_.values[static_cast<std::size_t>(v)], " = ",
                                                    table_.given(a, v), " and ", table_.given(b, v),
                                                    ": the models take the difference for noise; if it is none, "
                                                    "remove one of them"));
                    return;
                }
            samples_.remarks.push_back(text(words, ": the second says nothing new; remove it"));
            return;
        }
    }

    void remark_constant_values() {
        for (Eigen::Index v = 0; v < table_.given.cols() && ok_.size() > 1; ++v) {
            const VectorXd values = table_.given.col(v)(ok_);
            if ((values.array() != values[0]).any()) continue;
            const std::string& name = table_.values[static_cast<std::size_t>(v)];
            samples_.remarks.push_back(text(name, " is ", values[0], " in all ", ok_.size(),
                                            " designs: nothing can be learned about it, and no search can change it; ",
                                            problem_.table ? "check its column"
                                                           : "check that it depends on the surface "
                                                             "or the variables that are sampled"));
        }
    }

    /// Parameters: their bounds. Others: as a uniform distribution of the same deviation.
    void set_ranges() {
        const MatrixXd points = table_.designs(ok_, Eigen::all);
        for (Eigen::Index j = 0; j < points.cols(); ++j) {
            const Variable& variable = space_.variables[static_cast<std::size_t>(j)];
            const double centre = points.col(j).mean();
            const double reach = std::sqrt(3 * (points.col(j).array() - centre).square().mean());
            const bool is_parameter = j >= space_.num_shape() && !problem_.table;
            const double low = variable.offset + space_.lower[j] * variable.unit,
                         high = variable.offset + space_.upper[j] * variable.unit;
            samples_.lower.push_back(is_parameter ? low : centre - reach);
            samples_.upper.push_back(is_parameter ? high : centre + reach);
        }
    }

    bool can_learn() {
        if (static_cast<int>(ok_.size()) < fewest_for_effects) {
            samples_.without_effects = text("main effects need at least ", fewest_for_effects, " designs with values, ",
                                            ok_.size(), " have them; sample more");
            return false;
        }
        std::vector<std::string> same;
        for (std::size_t j = 0; j < samples_.lower.size(); ++j)
            if (!(samples_.lower[j] < samples_.upper[j])) same.push_back(table_.variables[j]);
        if (same.empty()) return true;
        samples_.without_effects = text("main effects need designs that differ in every variable; all have the same ",
                                        few(same), "; add others, or fix what does not vary in the case");
        return false;
    }

    void choose_rows() {
        const auto d = static_cast<double>(table_.designs.cols());
        const auto most = static_cast<std::size_t>(std::min(max_for_effects, std::sqrt(max_squares / d)));
        chosen_ = ok_;
        if (ok_.size() <= most) return;
        chosen_.clear();
        for (const Eigen::Index k : shuffled(static_cast<Eigen::Index>(ok_.size())))
            if (chosen_.size() < most) chosen_.push_back(ok_[static_cast<std::size_t>(k)]);
        std::ranges::sort(chosen_);
        samples_.remarks.push_back(
            text("effects are those of ", most, " of the ", ok_.size(), " designs: a model of more is too expensive"));
    }

    void set_effects() {
        const Eigen::Index d = table_.designs.cols();
        const VectorXd lower = VectorXd::Map(samples_.lower.data(), d);
        const VectorXd range = VectorXd::Map(samples_.upper.data(), d) - lower;
        const MatrixXd points = table_.designs(chosen_, Eigen::all);
        const MatrixXd scaled = (points.rowwise() - lower.transpose()) * range.cwiseInverse().asDiagonal();
        for (std::size_t k = 0; k < table_.values.size(); ++k) {
            const VectorXd values = table_.given.col(static_cast<Eigen::Index>(k))(chosen_);
            const GaussianProcess model(scaled, values);
            const MainEffects effects = main_effects(model, VectorXd::Zero(d), VectorXd::Ones(d));
            samples_.values.push_back({table_.values[k],
                                       effects.deviation,
                                       model.predicted_share(),
                                       {effects.share.begin(), effects.share.end()},
                                       {effects.error.begin(), effects.error.end()},
                                       {effects.total.begin(), effects.total.end()}});
        }
    }

    /// Without effect on any value; said only where models of all values are good.
    void remark_idle_variables() {
        std::vector<std::string> idle;
        for (std::size_t j = 0; j < table_.variables.size(); ++j) {
            bool varies = false, is_idle = true;
            for (const SampledValue& value : samples_.values) {
                if (!(value.deviation > 0)) continue;
                varies = true;
                is_idle &= value.predicted_share >= good_enough && value.total[j] < no_effect;
            }
            if (varies && is_idle) idle.push_back(table_.variables[j]);
        }
        if (idle.empty()) return;
        samples_.remarks.push_back(text(few(idle), idle.size() > 1 ? " have" : " has",
                                        " no effect on any value (total effect below ", 100 * no_effect,
                                        " %): check that the values depend on ", idle.size() > 1 ? "them" : "it",
                                        ", or leave ", idle.size() > 1 ? "them" : "it", " out of the case"));
    }

    const Problem& problem_;
    const DesignSpace& space_;
    SampleSummary& samples_;
    const DesignTable& table_;
    Rows ok_, chosen_;  ///< rows with values; those that models learn from
};

}  // namespace

void learn(const Problem& problem, const DesignSpace& space, SampleSummary& samples) {
    Learning(problem, space, samples).run();
}

}  // namespace strake
