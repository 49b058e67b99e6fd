#include "optimize/nlp/surrogate/main_effects.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int num_nodes = 40;
constexpr int num_groups = 10;

/// Gauss-Legendre nodes in [0, 1] and weights of sum 1, by Newton on the Legendre polynomial.
void legendre(VectorXd& node, VectorXd& weight) {
    node.resize(num_nodes);
    weight.resize(num_nodes);
    for (int i = 0; i < num_nodes; ++i) {
        double x = std::cos(M_PI * (i + 0.75) / (num_nodes + 0.5)), slope = 1;
        for (int newton = 0; newton < 20; ++newton) {
            double before = 1, p = x;
            for (int k = 2; k <= num_nodes; ++k) {
                const double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
                before = p, p = next;
            }
            slope = num_nodes * (x * p - before) / (x * x - 1);
            x -= p / slope;
        }
        node[i] = 0.5 * (1 - x);
        weight[i] = 1 / ((1 - x * x) * slope * slope);
    }
}

struct Shares {
    VectorXd share;
    double deviation = 0;
    MatrixXd others;  ///< terms x coordinates: the weighted means of all factors but that of the coordinate
};

/// Total effects: 1 - var(E[f | all but j]) / var(f). For each j the product over all other coordinates of the means of
/// pairs of factors is wanted: by halves, so that few of these products are in memory at a time.
class TotalEffects {
public:
    /// @param at per coordinate terms x nodes; `about` weights of the terms, around the mean of f
    TotalEffects(const std::vector<MatrixXd>& at, const VectorXd& weight, const VectorXd& about, double variance)
        : at_(at), weight_(weight), about_(about), variance_(variance) {}

    VectorXd all() {
        const auto d = static_cast<Eigen::Index>(at_.size());
        total_ = VectorXd::Zero(d);
        split(0, d, MatrixXd::Ones(about_.size(), about_.size()));
        return total_;
    }

private:
    MatrixXd square(Eigen::Index j) const {
        const MatrixXd& factor = at_[static_cast<std::size_t>(j)];
        return factor * weight_.asDiagonal() * factor.transpose();
    }

    void split(Eigen::Index begin, Eigen::Index end, const MatrixXd& outside) {
        if (end - begin == 1) {
            const VectorXd mean = about_.cwiseProduct(at_[static_cast<std::size_t>(begin)] * weight_);
            total_[begin] = std::clamp(1 - mean.dot(outside * mean) / variance_, 0.0, 1.0);
            return;
        }
        const Eigen::Index middle = (begin + end) / 2;
        MatrixXd more = outside;
        for (Eigen::Index j = middle; j < end; ++j) more = more.cwiseProduct(square(j)).eval();
        split(begin, middle, more);
        more = outside;
        for (Eigen::Index j = begin; j < middle; ++j) more = more.cwiseProduct(square(j)).eval();
        split(middle, end, more);
    }

    const std::vector<MatrixXd>& at_;
    const VectorXd &weight_, &about_;
    double variance_;
    VectorXd total_;
};

/// @param total filled where it is not null
Shares shares(const GaussianProcess& model, const VectorXd& lower, const VectorXd& upper, VectorXd* total = nullptr) {
    VectorXd node, weight;
    legendre(node, weight);
    const VectorXd c = model.weights();
    const Eigen::Index d = lower.size(), terms = c.size();
    std::vector<MatrixXd> at(static_cast<std::size_t>(d), MatrixXd(terms, num_nodes));
    MatrixXd mean(terms, d), square = MatrixXd::Ones(terms, terms);
    for (Eigen::Index j = 0; j < d; ++j) {
        MatrixXd& factor = at[static_cast<std::size_t>(j)];
        for (int q = 0; q < num_nodes; ++q)
            factor.col(q) = model.factors(static_cast<int>(j), lower[j] + node[q] * (upper[j] - lower[j]));
        mean.col(j) = factor * weight;
        square = square.cwiseProduct(factor * weight.asDiagonal() * factor.transpose()).eval();
    }
    Shares s{VectorXd::Zero(d), 0, c.replicate(1, d)};
    for (Eigen::Index j = 0; j < d; ++j)
        for (Eigen::Index k = 0; k < d; ++k)
            if (k != j) s.others.col(j) = s.others.col(j).cwiseProduct(mean.col(k)).eval();
    const double centre = s.others.col(0).dot(mean.col(0));
    // Around the mean of the values: the trend's constant must not drown the rest in round-off.
    VectorXd about = c;
    about[0] -= centre;
    const double variance = about.dot(square * about);
    const double floor = 1e-20 * centre * centre;
    if (!(variance > floor)) return s;
    s.deviation = std::sqrt(variance);
    for (Eigen::Index j = 0; j < d; ++j) {
        const VectorXd line = at[static_cast<std::size_t>(j)].transpose() * s.others.col(j);
        const double of_line = weight.dot((line.array() - centre).square().matrix());
        s.share[j] = std::clamp(of_line / variance, 0.0, 1.0);
    }
    if (total) *total = TotalEffects(at, weight, about, variance).all();
    return s;
}

/// The model without every tenth point, beginning with `group`.
GaussianProcess without_group(const GaussianProcess& model, int group) {
    const Eigen::Index n = model.points().rows();
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < n; ++i)
        if (i % num_groups != group) kept.push_back(i);
    return model.with_points(model.points()(kept, Eigen::all), model.values()(kept));
}

}  // namespace

MainEffects main_effects(const GaussianProcess& model, const VectorXd& lower, const VectorXd& upper, int places) {
    const Eigen::Index d = model.points().cols();
    if (lower.size() != d || upper.size() != d || !(lower.array() < upper.array()).all() || places < 2)
        throw InvalidInput(text("main effects: bounds of ", lower.size(), " and ", upper.size(), " coordinates for ", d,
                                "; lower must be < upper, and places >= 2"));
    VectorXd total = VectorXd::Zero(d);
    const Shares all = shares(model, lower, upper, &total);
    MainEffects effects{all.share, VectorXd::Zero(d), total, all.deviation, MatrixXd(places, d)};
    for (Eigen::Index j = 0; j < d; ++j)
        for (int q = 0; q < places; ++q)
            effects.curve(q, j) = all.others.col(j).dot(
                model.factors(static_cast<int>(j), lower[j] + q * (upper[j] - lower[j]) / (places - 1)));
    const Eigen::Index rest = model.points().rows() - (model.points().rows() + num_groups - 1) / num_groups;
    if (model.points().rows() < num_groups || rest <= model.num_terms()) {
        effects.error.setConstant(1);  // too few points to say
        return effects;
    }
    MatrixXd each(d, num_groups);
    for (int g = 0; g < num_groups; ++g) each.col(g) = shares(without_group(model, g), lower, upper).share;
    const VectorXd mean = each.rowwise().mean();
    const double factor = (num_groups - 1.0) / num_groups;
    effects.error = (factor * (each.colwise() - mean).rowwise().squaredNorm()).cwiseSqrt();
    return effects;
}

}  // namespace strake
