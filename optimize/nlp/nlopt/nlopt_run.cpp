#include "optimize/nlp/nlopt/nlopt_run.hpp"

#include "optimize/nlp/program/first_order.hpp"

#include <Eigen/Cholesky>

namespace strake {

using Eigen::VectorXd;

namespace {

nlopt::algorithm algorithm_of(Method method) {
    switch (method) {
        case Method::sqp:  // not methods of NLopt
        case Method::model:
        case Method::nlopt_slsqp:
            return nlopt::LD_SLSQP;
        case Method::mma:
            return nlopt::LD_MMA;
        case Method::ccsaq:
            return nlopt::LD_CCSAQ;
        case Method::lbfgs:
            return nlopt::LD_LBFGS;
        case Method::tnewton:
            return nlopt::LD_TNEWTON_PRECOND_RESTART;
        case Method::var2:
            return nlopt::LD_VAR2;
        case Method::cobyla:
            return nlopt::LN_COBYLA;
        case Method::bobyqa:
            return nlopt::LN_BOBYQA;
        case Method::neldermead:
            return nlopt::LN_NELDERMEAD;
        case Method::sbplx:
            return nlopt::LN_SBPLX;
        case Method::praxis:
            return nlopt::LN_PRAXIS;
        case Method::crs2:
            return nlopt::GN_CRS2_LM;
        case Method::isres:
            return nlopt::GN_ISRES;
        case Method::mlsl:
            return nlopt::G_MLSL_LDS;
        case Method::direct:
            return nlopt::GN_DIRECT_L;
        case Method::esch:
            return nlopt::GN_ESCH;
    }
    return nlopt::LD_SLSQP;
}

constexpr double first_simplex = 0.25;  ///< of gradient-free local methods, in the variables

}  // namespace

double Lagrangian::value(const NonlinearProgram& p, const Evaluation& s) const {
    double sum = 0;
    for (Eigen::Index i = 0; i < s.constraints.size(); ++i) {
        const double c = s.constraints[i], m = multipliers[i];
        if (i >= p.num_inequalities)
            sum += equalities ? c * (m + 0.5 * penalty * c) : 0;
        else if (inequalities)
            sum += (std::pow(std::max(0.0, m + penalty * c), 2) - m * m) / (2 * penalty);
    }
    return sum;
}

VectorXd Lagrangian::updated(const NonlinearProgram& p, const Evaluation& s) const {
    VectorXd next = VectorXd::Zero(s.constraints.size());
    for (Eigen::Index i = 0; i < next.size(); ++i) {
        const double m = multipliers[i] + penalty * s.constraints[i];
        if (i >= p.num_inequalities)
            next[i] = equalities ? m : 0;
        else if (inequalities)
            next[i] = std::max(0.0, m);
    }
    return next;
}

SearchBox box_around(const NonlinearProgram& p, const VectorXd& centre, double radius) {
    return {p.lower.cwiseMax((centre.array() - radius).matrix()), p.upper.cwiseMin((centre.array() + radius).matrix())};
}

bool lies_on_artificial_side(const NonlinearProgram& p, const SearchBox& box, const VectorXd& x) {
    for (Eigen::Index j = 0; j < x.size(); ++j)
        if ((x[j] <= box.lower[j] && box.lower[j] > p.lower[j]) || (x[j] >= box.upper[j] && box.upper[j] < p.upper[j]))
            return true;
    return false;
}

/// Null: no value. Stops the search, unless it ranks failures and this is one.
const Evaluation* NloptRun::evaluation(const double* z, bool gradient) {
    const auto n = static_cast<Eigen::Index>(guard_.free.size());
    if (failed_z_.size() == n && failed_z_ == Eigen::Map<const VectorXd>(z, n)) return nullptr;
    try {
        return whitener_.size() > 0 ? &guard_.requested(point(z), gradient) : &guard_.at(z, gradient);
    } catch (const nlopt::forced_stop&) {
    }
    if (guard_.cause == StopCause::failure && method_.ranks_failures) {
        guard_.cause = StopCause::none;
        failed_z_ = Eigen::Map<const VectorXd>(z, n);
    } else
        opt_->force_stop();
    return nullptr;
}

double NloptRun::value_of(const Evaluation& s) const {
    return (s.objective - guard_.offset()) / guard_.scale + (lagrangian_ ? lagrangian_->value(guard_.program, s) : 0.0);
}

VectorXd NloptRun::gradient_of(const Evaluation& s) const {
    VectorXd g = s.gradient / guard_.scale;
    if (lagrangian_) g += s.jacobian.transpose() * lagrangian_->updated(guard_.program, s);
    return g;
}

/// The worst value seen replaces a missing one. A line search gets a parabola from its last good point up to it.
double NloptRun::failed_value(const double* z, double* gradient) const {
    const double height = std::max(worst_ - good_value_, 1e-3 * std::max(1.0, std::abs(good_value_)));
    if (!gradient) return worst_;
    const VectorXd away = point(z) - good_x_;
    const double length = std::max(away.squaredNorm(), 1e-30);
    for (std::size_t i = 0; i < guard_.free.size(); ++i) gradient[i] = 2 * height * away[guard_.free[i]] / length;
    return good_value_ + height;
}

void NloptRun::keep(const double* z, const Evaluation& s, double value) {
    const NonlinearProgram& p = guard_.program;
    double violation = 0;  // of the constraints that NLopt gets
    for (Eigen::Index i = 0; i < s.constraints.size(); ++i)
        if (passes(i < p.num_inequalities))
            violation = std::max(violation, i < p.num_inequalities ? s.constraints[i] : std::abs(s.constraints[i]));
    worst_violation_ = std::max(worst_violation_, violation);
    if (violation <= guard_.options.constraint_tolerance) violation = 0;
    worst_ = has_lowest_ ? std::max(worst_, value) : value;
    good_x_ = point(z);
    good_value_ = value;
    if (has_lowest_ && !(violation < lowest_violation_ || (violation == lowest_violation_ && value < lowest_value_)))
        return;
    has_lowest_ = true;
    lowest_violation_ = violation;
    lowest_value_ = value;
    lowest_x = good_x_;
    lowest = s;
}

double NloptRun::objective(unsigned, const double* z, double* gradient, void* self) {
    auto& run = *static_cast<NloptRun*>(self);
    const std::vector<int>& free = run.guard_.free;
    const Evaluation* s = run.evaluation(z, gradient != nullptr);
    if (!s) return run.failed_value(z, gradient);
    const double value = run.value_of(*s);
    if (!std::isfinite(value)) return run.failed_value(z, gradient);
    if (gradient) {
        const VectorXd g = run.gradient_of(*s);
        for (std::size_t i = 0; i < free.size(); ++i) gradient[i] = g[free[i]];
    }
    run.keep(z, *s, value);
    return value;
}

void NloptRun::constraints(int first, unsigned count, double* value, const double* z, double* gradient) {
    const std::vector<int>& free = guard_.free;
    const Evaluation* s = evaluation(z, gradient != nullptr);
    for (unsigned i = 0; i < count; ++i) {
        value[i] = s ? s->constraints[first + i] : worst_violation_;
        for (std::size_t j = 0; gradient && j < free.size(); ++j)
            gradient[i * free.size() + j] = s ? s->jacobian(first + i, free[j]) : 0;
    }
}

void NloptRun::inequalities(unsigned count, double* value, unsigned, const double* z, double* gradient, void* self) {
    static_cast<NloptRun*>(self)->constraints(0, count, value, z, gradient);
}

void NloptRun::equalities(unsigned count, double* value, unsigned, const double* z, double* gradient, void* self) {
    auto& run = *static_cast<NloptRun*>(self);
    run.constraints(run.guard_.program.num_inequalities, count, value, z, gradient);
}

/// Methods without gradients learn how variables scale and couple at one evaluation each, or never: they search in
/// variables in which the metric is the identity. Bounds are no box there; points beyond are moved onto them.
void NloptRun::set_whitener(const VectorXd& start, const SearchBox& box) {
    whitener_.resize(0, 0);
    if (method_.is_global || method_.needs_gradients || guard_.program.metric.size() == 0) return;
    const auto n = static_cast<Eigen::Index>(guard_.free.size());
    const Eigen::LLT<Eigen::MatrixXd> metric(guard_.program.metric(guard_.free, guard_.free));
    if (metric.info() != Eigen::Success) return;
    whitener_ = metric.matrixU().solve(Eigen::MatrixXd::Identity(n, n));
    origin_ = start;
    box_ = box;
}

VectorXd NloptRun::point(const double* z) const {
    if (whitener_.size() == 0) return guard_.all_variables(z);
    VectorXd x = origin_;
    x(guard_.free) += whitener_ * Eigen::Map<const VectorXd>(z, whitener_.cols());
    return x.cwiseMax(box_.lower).cwiseMin(box_.upper);
}

/// Not longer than the box allows, because BOBYQA refuses that. Whitened, all together are as long as a first step.
void NloptRun::set_steps(nlopt::opt& opt, const SearchBox& box) const {
    if (whitener_.size() > 0) {
        const double all = guard_.options.first_step / std::sqrt(static_cast<double>(whitener_.cols()));
        opt.set_initial_step(method_.method == Method::bobyqa ? 4 * all : all);
        return;
    }
    std::vector<double> steps;
    for (const int j : guard_.free) steps.push_back(std::min(first_simplex, 0.4 * (box.upper[j] - box.lower[j])));
    opt.set_initial_step(steps);
}

/// A population that spends the whole budget in its first generation finds nothing.
void NloptRun::set_population(nlopt::opt& opt) const {
    const auto n = static_cast<int>(guard_.free.size());
    const int left = std::max(1, guard_.limit - guard_.evaluations);
    if (method_.method == Method::crs2) opt.set_population(std::max(n + 2, std::min(10 * (n + 1), left / 4)));
    if (method_.method == Method::isres) opt.set_population(std::max(10, std::min(20 * (n + 1), left / 10)));
    if (method_.method == Method::esch) opt.set_population(std::max(10, std::min(40, left / 10)));
}

void NloptRun::configure(nlopt::opt& opt, const SearchBox& box, double objective_tolerance, double step_tolerance) {
    const MinimizeOptions& o = guard_.options;
    const NonlinearProgram& p = guard_.program;
    std::vector<double> lower, upper;
    for (const int j : guard_.free) lower.push_back(box.lower[j]), upper.push_back(box.upper[j]);
    if (whitener_.size() == 0) {
        opt.set_lower_bounds(lower);
        opt.set_upper_bounds(upper);
    }
    opt.set_min_objective(objective, this);
    const auto tolerances = [&](int count) { return std::vector<double>(count, o.constraint_tolerance); };
    if (p.num_inequalities > 0 && passes(true))
        opt.add_inequality_mconstraint(inequalities, this, tolerances(p.num_inequalities));
    if (p.num_equalities > 0 && passes(false))
        opt.add_equality_mconstraint(equalities, this, tolerances(p.num_equalities));
    // The guard's limit counts distinct points; this one only stops NLopt from repeating known ones without end.
    opt.set_maxeval(20 * o.max_evaluations + 100);
    if (method_.method == Method::mma || method_.method == Method::ccsaq) {
        // By default the approximations and the search on each are nearly unlimited: hours, in a box that has shrunk.
        opt.set_param("inner_maxeval", 30);
        opt.set_param("dual_maxeval", 2000);
    }
    if (o.max_seconds > 0) opt.set_maxtime(2 * o.max_seconds);
    const auto local = [&](nlopt::opt& it) {
        it.set_ftol_rel(objective_tolerance);
        it.set_ftol_abs(1e-3 * objective_tolerance * std::abs(guard_.best.objective) / guard_.scale);
        it.set_xtol_abs(step_tolerance);
    };
    if (!method_.is_global || method_.method == Method::crs2) local(opt);
    if (!method_.is_global && !method_.needs_gradients) set_steps(opt, box);
    if (method_.method == Method::mlsl) {
        nlopt::opt search(nlopt::LD_LBFGS, opt.get_dimension());
        local(search);
        opt.set_local_optimizer(search);
    }
    if (method_.is_global) set_population(opt);
}

nlopt::result NloptRun::run(const VectorXd& start, const SearchBox& box, double objective_tolerance,
                            double step_tolerance) {
    nlopt::opt opt(algorithm_of(method_.method), static_cast<unsigned>(guard_.free.size()));
    opt_ = &opt;
    has_lowest_ = false;
    failed_z_.resize(0);
    good_x_ = lowest_x = end_x = start;
    nlopt::srand(guard_.options.seed);
    std::vector<double> z;
    set_whitener(start, box);
    for (const int j : guard_.free) z.push_back(whitener_.size() > 0 ? 0 : start[j]);
    double value = 0;
    nlopt::result code = nlopt::FAILURE;
    try {
        configure(opt, box, objective_tolerance, step_tolerance);
        code = opt.optimize(z, value);
    } catch (const nlopt::roundoff_limited&) {
        code = nlopt::ROUNDOFF_LIMITED;
    } catch (const nlopt::forced_stop&) {
        code = nlopt::FORCED_STOP;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        message = e.what();
    }
    if (Eigen::Map<const VectorXd>(z.data(), static_cast<Eigen::Index>(z.size())).allFinite())
        end_x = point(z.data()).cwiseMax(guard_.program.lower).cwiseMin(guard_.program.upper);
    return code;
}

}  // namespace strake
