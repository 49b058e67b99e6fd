// What a step of `method: model` costs: model_table [VARIABLES EVALUATIONS BATCH CONSTRAINTS]   (default 60 200 8 2)
// A bowl with noise and curved limits, whose values cost nothing: seconds of CPU between the answers of one batch and
// the next batch, mean and longest, and the memory of all at its peak.
#include "optimize/nlp/minimizer.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

using namespace strake;

namespace {

double cpu() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

NonlinearProgram limited_bowl(int variables, int constraints) {
    NonlinearProgram p;
    p.start = Eigen::VectorXd::Zero(variables);
    p.lower = Eigen::VectorXd::Constant(variables, -3);
    p.upper = Eigen::VectorXd::Constant(variables, 3);
    p.metric = Eigen::MatrixXd::Identity(variables, variables);
    p.num_inequalities = constraints;
    p.evaluate = [=](const Eigen::VectorXd& x) {
        Evaluation at;
        at.objective = 1e-3 * std::sin(1e5 * x.sum());
        for (int j = 0; j < variables; ++j)
            at.objective += std::pow(100, double(j) / variables) * std::pow(x[j] - 1 / std::sqrt(variables), 2);
        at.constraints = Eigen::VectorXd::Constant(constraints, -0.25);
        for (int j = 0; j < variables && constraints > 0; ++j) at.constraints[j % constraints] += x[j] * x[j];
        return at;
    };
    return p;
}

}  // namespace

int main(int argc, char** argv) {
    const auto number = [&](int at, int fallback) { return argc > at ? std::max(1, std::atoi(argv[at])) : fallback; };
    const int variables = number(1, 60), evaluations = number(2, 200), batch = number(3, 8), constraints = number(4, 2);
    NonlinearProgram p = limited_bowl(variables, constraints);
    std::vector<double> before;  // seconds of CPU before each evaluation, since the last one
    p.evaluate = [&, inner = p.evaluate, last = cpu()](const Eigen::VectorXd& x) mutable {
        before.push_back(cpu() - last);
        Evaluation at = inner(x);
        last = cpu();
        return at;
    };
    MinimizeOptions how;
    how.method = Method::model;
    how.batch = batch;
    how.max_evaluations = evaluations;
    how.objective_tolerance = 1e-12;
    const MinimizeResult found = minimize(p, how);
    double longest = 0, sum = 0;
    for (const double seconds : before) longest = std::max(longest, seconds), sum += seconds;
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    std::printf(
        "%d variables, %d constraints, %d evaluations in batches of %d: a step %.2f s of CPU in the mean, %.2f s "
        "the longest; %.0f MB at most; objective %.4g, %s\n",
        variables, constraints, found.evaluations, batch, sum * batch / std::max(1, found.evaluations), longest,
        used.ru_maxrss / 1024.0, found.best.objective, found.reason.c_str());
}
