#include "optimize/run/value_trial.hpp"

#include "core/error.hpp"
#include "optimize/nlp/program/first_order.hpp"
#include "optimize/space/refinement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <random>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double joins_too = 0.7;  ///< of the larger gain for each variable: else it is dearer with both than alone
constexpr double joined_before = 1.0 / 3;
constexpr double stays = 0.1;       ///< of it
constexpr double longest_step = 1;  ///< in the metric
constexpr double softest = 100;     ///< times softer or stiffer than the metric says
constexpr double round_off = 1e-5;  ///< of a whitened variable that the others can do

bool is_field(const DesignSpace& space, int j) {
    return space.variables[static_cast<std::size_t>(j)].kind == VariableKind::field;
}

std::vector<int> group_of(const DesignSpace& space, bool fields) {
    std::vector<int> members;
    for (int j = 0; j < space.num_shape(); ++j)
        if (is_field(space, j) == fields) members.push_back(j);
    return members;
}

double longest_of(const MatrixXd& columns) { return columns.cols() > 0 ? columns.colwise().norm().maxCoeff() : 0; }

/// Basis of the columns; what is shorter than `least` does not count.
MatrixXd orthonormal(const MatrixXd& columns, double least) {
    if (columns.cols() == 0) return columns;
    Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
    Eigen::Index rank = 0;
    while (rank < std::min(columns.rows(), columns.cols()) &&
           std::abs(qr.matrixR()(rank, rank)) > std::max(least, 1e-300))
        ++rank;
    return qr.householderQ() * MatrixXd::Identity(columns.rows(), rank);
}

/// Normal numbers by Box and Muller: the same on every machine.
class Normal {
public:
    explicit Normal(unsigned seed) : engine_(seed) {}
    double operator()() {
        const double u = uniform(), v = uniform();
        return std::sqrt(-2 * std::log(u)) * std::cos(6.283185307179586 * v);
    }

private:
    double uniform() { return (static_cast<double>(engine_()) + 0.5) / 4294967296.0; }
    std::mt19937 engine_;
};

/// Directions of a group, and what they are expected to gain.
struct Part {
    MatrixXd basis;   ///< orthonormal, whitened
    double gain = 0;  ///< of each direction
    Eigen::Index size() const { return basis.cols(); }
    double all() const { return gain * static_cast<double>(size()); }
};

/// One of the two groups in the space of the trial.
struct Group {
    const char* name = "";
    bool is_fields = false;
    std::vector<int> variables;  ///< in the space of the trial
    Part there;                  ///< its variables of the level before
    Part finer;                  ///< what it can do beyond that level
    bool is_there() const { return there.size() > 0; }
};

class Trial {
public:
    Trial(RunState& state, LevelProgram& program, const LeftLevel& left, double curvature)
        : state_(state), program_(program), left_(left), curvature_(curvature), before_(state.space) {
        if (left.last.gradient.size() == before_.size())
            lambda_ = multipliers(program.program(), left.last_y, left.last);
    }

    /// Evaluates; fills in the gains.
    void run(std::vector<Group>& groups) {
        const LevelSet all = offered();
        const VectorXd start = state_.next_level(left_.x, &all);
        state_.is_trying = true;
        const NonlinearProgram& p = program_.enter(start);
        const Eigen::LLT<MatrixXd> metric(p.metric);
        const MatrixXd inherited =
            program_.weight().asDiagonal() * state_.prolongation * left_.weight.cwiseInverse().asDiagonal();
        const MatrixXd present = metric.matrixU() * inherited;
        const MatrixXd known = orthonormal(present, round_off * longest_of(present));
        const MatrixXd whitener = metric.matrixU();
        for (Group& group : groups) {
            group.variables = group_of(state_.space, group.is_fields);
            const MatrixXd columns = whitener(Eigen::all, group.variables);
            // Of a group that is there to its end nothing is left but rounding, which is no direction.
            group.finer.basis =
                orthonormal(columns - known * (known.transpose() * columns), round_off * longest_of(columns));
            const MatrixXd own = present(Eigen::all, group_of(before_, group.is_fields));
            group.there.basis = orthonormal(own, round_off * longest_of(present));
        }
        measure(groups, p, metric);
        next_ = level_set_of(state_.space);
        state_.is_trying = false;
    }

    /// The level set with these groups, as fine as in the trial or as they were.
    LevelSet with(bool finer_fields, bool finer_patches, bool keep_fields, bool keep_patches) const {
        LevelSet set{as_it_is(), before_.fields, keep_patches && before_.has_patches};
        if (finer_patches) set.front = next_.front, set.has_patches = true;
        if (finer_fields)
            set.fields = next_.fields;
        else if (!keep_fields)
            set.fields.numbers.clear();
        return set;
    }

    void go_back() {
        const int level = state_.space.level;
        state_.space = before_;
        state_.space.level = level;  // the next one has the next number
    }

private:
    /// The front of the level before; split_front makes its patches their own parents.
    Front as_it_is() const {
        return split_front(*before_.rest->tree, *before_.front, std::vector<char>(before_.front->depth.size(), 0));
    }

    /// The next fields, and the coarsest patches below the present ones that have as many variables as the level:
    /// coarser ones hardly do what it has not done.
    LevelSet offered() const {
        LevelSet all = refined_everywhere(before_);
        const PatchHierarchy& tree = *before_.rest->tree;
        std::size_t each = 0;
        for (const VariableKind kind : before_.rest->parameters.kinds)
            each += kind == VariableKind::load ? 3 : kind == VariableKind::strain ? 6 : 1;
        while (each * all.front.patches.patches.size() < static_cast<std::size_t>(before_.size())) {
            const std::vector<int> parts = parts_of(tree, all.front);
            if (*std::ranges::max_element(parts) <= 1) break;
            all.front = split_front(tree, all.front, std::vector<char>(all.front.depth.size(), 1));
        }
        // The caller knows the parents of its own space.
        for (Patch& patch : all.front.patches.patches) patch.parent = before_.patches().label[patch.triangles.front()];
        return all;
    }

    /// Directions of a part and the slopes along them.
    struct Sample {
        Part* part;
        MatrixXd directions;  ///< in y, of length 1 in the metric
        VectorXd slopes;
    };

    double rise(const Evaluation& here, const Evaluation& there) const {
        double sum = there.objective - here.objective;
        if (lambda_.size() == here.constraints.size()) sum += lambda_.dot(there.constraints - here.constraints);
        return sum;
    }

    void measure(std::vector<Group>& groups, const NonlinearProgram& p, const Eigen::LLT<MatrixXd>& metric) {
        const double h = p.differences ? p.differences->step : state_.problem.optimize.difference_step;
        Normal normal(state_.problem.optimize.seed + 7919u * static_cast<unsigned>(state_.space.level));
        std::vector<VectorXd> points{p.start};
        std::vector<Sample> samples;
        std::vector<Part*> parts;
        for (Group& group : groups) parts.push_back(&group.finer);
        for (Group& group : groups) parts.push_back(&group.there);
        for (Part* part : parts) {
            const int count = std::min<int>(trial_directions, static_cast<int>(part->size()));
            samples.push_back({part, MatrixXd(p.start.size(), count), VectorXd::Zero(count)});
            for (int k = 0; k < count; ++k) {
                VectorXd coefficients(part->size());
                for (double& c : coefficients) c = normal();
                VectorXd d = metric.matrixU().solve(part->basis * coefficients.normalized());
                const VectorXd there = p.start + h * d;
                if (((there.array() < p.lower.array()) || (there.array() > p.upper.array())).any()) d = -d;
                samples.back().directions.col(k) = d;
                points.push_back((p.start + h * d).cwiseMax(p.lower).cwiseMin(p.upper));
            }
        }
        if (p.expect) p.expect(points);
        const Evaluation here = p.evaluate(points[0]);
        if (!here.failure.empty()) return;
        std::size_t next = 1;
        for (Sample& sample : samples)
            for (double& slope : sample.slopes) {
                const Evaluation there = p.evaluate(points[next++]);
                if (there.failure.empty()) slope = rise(here, there) / h;
            }
        for (const Sample& sample : samples) correct(sample, p, here);
    }

    /// The metric is stiffer on details than objectives are, by up to a hundred times: one value where the best step
    /// along the directions is expected to end says by how much.
    void correct(const Sample& sample, const NonlinearProgram& p, const Evaluation& here) {
        const double slope = sample.slopes.norm();
        if (!(slope > 0)) return;
        const double length = std::min(slope / curvature_, longest_step);
        const VectorXd step = -length * (sample.directions * sample.slopes.normalized());
        double curvature = curvature_;
        const VectorXd inside = (p.start + step).cwiseMax(p.lower).cwiseMin(p.upper);
        const VectorXd reached = p.within ? p.within(inside) : inside;
        if (reached == p.start + step) {
            const Evaluation there = p.evaluate(reached);
            if (there.failure.empty())
                curvature = std::clamp(2 * (rise(here, there) + slope * length) / (length * length),
                                       curvature_ / softest, curvature_ * softest);
        }
        // All directions together are steeper than those that were tried; their step is no longer than those of the
        // level.
        const auto count = static_cast<double>(sample.part->size());
        const double steepest = slope * std::sqrt(count / static_cast<double>(sample.slopes.size()));
        const double reached_by_all = std::min(steepest / curvature, std::max(left_.radius, length));
        sample.part->gain = reached_by_all * (steepest - 0.5 * curvature * reached_by_all) / count;
    }

    RunState& state_;
    LevelProgram& program_;
    const LeftLevel& left_;
    const double curvature_;
    const DesignSpace before_;
    VectorXd lambda_;
    LevelSet next_;
};

std::string words_of(const Group& group) {
    return text(group.name, " ", group.finer.gain, " for each of ", group.finer.size(),
                group.is_there() ? text(" (those there ", group.there.gain, ")") : "");
}

}  // namespace

TrialResult next_by_values(RunState& state, LevelProgram& program, const LeftLevel& left, double curvature,
                           double least) {
    Trial trial(state, program, left, curvature);
    std::vector<Group> groups(2);
    groups[0].name = "fields", groups[0].is_fields = true;
    groups[1].name = "patches";
    trial.run(groups);
    const Group &fields = groups[0], &patches = groups[1];
    double all = 0;
    for (const Group& g : groups) all += g.finer.all();
    TrialResult result;
    result.is_idle = !(all > least);
    const auto can_be_paid = [&](const Group& g) {
        return affordable_gradients * static_cast<double>(g.variables.size()) <= state.evaluations_left();
    };
    double best = 0;
    for (const Group& g : groups) best = std::max({best, can_be_paid(g) ? g.finer.gain : 0, g.there.gain});
    const auto joins = [&](const Group& g) {
        const double share = state.problem.optimize.learns_as_before ? joined_before : joins_too;
        return g.finer.size() > 0 && g.finer.gain > 0 && g.finer.gain >= share * best && can_be_paid(g);
    };
    const auto remains = [&](const Group& g) {
        return g.is_there() && (result.is_idle || g.there.gain >= stays * best);
    };
    const auto takes = [&](const Group& g) { return result.is_idle ? can_be_paid(g) : joins(g); };
    const bool more_fields = takes(fields), more_patches = takes(patches);
    result.stays = !more_fields && !more_patches;
    const bool keep_fields = more_fields || remains(fields), keep_patches = more_patches || remains(patches);
    result.next = trial.with(more_fields, more_patches, keep_fields, keep_patches);
    const auto fate = [](const Group& g, bool more, bool keep) {
        return text(g.name, more ? " become finer" : keep ? " stay" : g.is_there() ? " are frozen" : " wait");
    };
    const std::string why =
        result.is_idle ? "nothing is expected to gain; all go on together"
                       : text(fate(fields, more_fields, keep_fields), ", ", fate(patches, more_patches, keep_patches));
    state.note(text("choice by ", trial_directions, " directions each, expected decrease: ", words_of(fields), "; ",
                    words_of(patches), "; ", why));
    state.end_level("directions of finer fields and patches were tried");
    trial.go_back();
    return result;
}

}  // namespace strake
