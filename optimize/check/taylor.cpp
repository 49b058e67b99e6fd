#include "core/error.hpp"
#include "optimize/check/gradient_check.hpp"

#include <algorithm>

namespace strake {
namespace {

constexpr double min_order = 1.7;
constexpr double slope_agreement = 1e-5;  ///< of slopes, relative
constexpr double straight = 1e-6;         ///< a remainder below this times h and the slope is that of a straight line
constexpr double round_off = 1e-12;       ///< of values, relative

void measure(TaylorTest& test, const std::vector<double>& h, const std::vector<double>& values) {
    for (std::size_t i = 0; i < h.size(); ++i) {
        TaylorStep step;
        step.h = h[i];
        step.value = values[i];
        step.remainder = std::abs(values[i] - test.value - h[i] * test.slope);
        if (i > 0 && step.remainder > 0 && test.steps[i - 1].remainder > 0)
            step.order = std::log(test.steps[i - 1].remainder / step.remainder) / std::log(h[i - 1] / h[i]);
        test.steps.push_back(step);
    }
    for (std::size_t i = 1; i + 1 < test.steps.size(); ++i) {
        const double both = std::min(test.steps[i].order, test.steps[i + 1].order);
        if (std::isfinite(both)) test.order = std::max(test.order, both);
    }
}

/// Richardson's extrapolation of the one-sided differences over each two steps; the one that differs least from the one
/// before is the best, and that difference its uncertainty.
void extrapolate(TaylorTest& test) {
    std::vector<double> slopes;
    for (std::size_t i = 0; i + 1 < test.steps.size(); ++i) {
        const TaylorStep &a = test.steps[i], &b = test.steps[i + 1];
        const double of_a = (a.value - test.value) / a.h, of_b = (b.value - test.value) / b.h;
        const double slope = (of_b * a.h - of_a * b.h) / (a.h - b.h);
        if (std::isfinite(slope)) slopes.push_back(slope);
    }
    test.uncertainty = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < slopes.size(); ++i) {
        const double change = std::abs(slopes[i] - slopes[i - 1]);
        if (change >= test.uncertainty) continue;
        test.uncertainty = change;
        test.differences_slope = slopes[i];
    }
}

std::string digits(double value, int count) {
    std::ostringstream s;
    s.imbue(std::locale::classic());
    s.precision(count);
    s << value;
    return s.str();
}

std::string failure_words(const TaylorTest& test, double difference, double tolerance) {
    const std::string slopes = text("the gradient gives the slope ", test.slope, ", differences of the values give ",
                                    test.differences_slope, " +- ", digits(test.uncertainty, 3));
    if (difference <= tolerance)
        return text("the values are too noisy to confirm the gradient: the remainder falls with order ",
                    digits(test.order, 3), " at most; ", slopes);
    const double larger = std::max(std::abs(test.slope), std::abs(test.differences_slope));
    if (test.uncertainty > 0.3 * larger) return text("the values are too noisy to tell a slope from them: ", slopes);
    if (test.differences_slope == 0 || std::abs(test.slope / test.differences_slope) > 1e6)
        return text("the gradient is wrong: ", slopes, ", which is none beside it");
    return text("the gradient is wrong: ", slopes, "; the gradient's is ",
                digits(test.slope / test.differences_slope, 6), " times that of the differences");
}

void check_arguments(const std::string& name, double value, double slope, double size, const std::vector<double>& h,
                     std::size_t values, double accept) {
    if (h.size() < 3 || h.size() != values)
        throw InvalidInput(text("Taylor test: ", h.size(), " steps and ", values, " values, expected as many, >= 3"));
    for (std::size_t i = 0; i < h.size(); ++i)
        if (!(h[i] > 0) || (i > 0 && !(h[i] < h[i - 1])))
            throw InvalidInput(text("Taylor test: step ", i, " = ", h[i], " must be > 0 and below the one before"));
    if (!std::isfinite(value) || !std::isfinite(slope) || !(size >= 0) || !(accept >= 0 && accept < 1))
        throw InvalidInput(
            text("Taylor test of ", name, ": value ", value, ", slope ", slope, ", size ", size, ", accept ", accept));
}

/// What all steps together show.
struct Remainders {
    int measured = 0;                                            ///< steps with a value
    double max_change = 0;                                       ///< of the value and of what the gradient predicts
    double min_slope = std::numeric_limits<double>::infinity();  ///< smallest remainder over its step
};

Remainders remainders(const TaylorTest& test) {
    Remainders all;
    for (const TaylorStep& step : test.steps) {
        if (!std::isfinite(step.value)) continue;
        ++all.measured;
        all.max_change = std::max(all.max_change, std::abs(step.value - test.value) + std::abs(step.h * test.slope));
        all.min_slope = std::min(all.min_slope, step.remainder / step.h);
    }
    return all;
}

/// Passed or not, and why. `size` and `accept` as in taylor_test.
void judge(TaylorTest& test, const Remainders& all, double size, double accept) {
    const double difference = std::abs(test.slope - test.differences_slope);
    const double larger = std::max(std::abs(test.slope), std::abs(test.differences_slope));
    const double tolerance = std::max({slope_agreement * larger, 5 * test.uncertainty, 1e-6 * size});
    const bool constant = all.max_change == 0 ||
                          (all.max_change <= round_off * std::abs(test.value) && std::abs(test.slope) <= 1e-6 * size);
    const bool is_straight = all.min_slope <= straight * std::max(larger, size);
    test.passed = constant || (difference <= tolerance && (test.order >= min_order || is_straight));
    // A slope that noise hides within its own uncertainty is not confirmed by it.
    if (test.passed && test.order < min_order && !constant && test.uncertainty > 1e-3 * larger &&
        test.uncertainty > 1e-6 * size)
        test.passed = false;
    // By the size of the gradient: a direction that happens to lie across it has a slope of nearly nothing.
    const double scale = std::max(larger, size);
    const bool acceptable = difference <= accept * scale && test.uncertainty <= 0.5 * accept * scale;
    if (!test.passed && acceptable && accept > 0) {
        test.passed = true;
        test.verdict = text("slopes differ by ", digits(difference / scale, 3), " of the slope to be expected, ",
                            digits(scale, 3), ", where ", digits(accept, 3), " is accepted; differences give ",
                            test.differences_slope, " +- ", digits(test.uncertainty, 3));
    } else if (!test.passed)
        test.verdict = failure_words(test, difference, tolerance);
    else if (constant)
        test.verdict = "the value does not change, as the gradient says";
    else if (test.order >= min_order)
        test.verdict = text("the remainder falls with order ", digits(test.order, 3), "; slopes agree to ",
                            digits(larger > 0 ? difference / larger : 0, 3));
    else
        test.verdict = text("linear to round-off; slopes agree to ", digits(larger > 0 ? difference / larger : 0, 3));
}

}  // namespace

TaylorTest taylor_test(const std::string& name, double value, double slope, double size, const std::vector<double>& h,
                       const std::vector<double>& values, double accept) {
    check_arguments(name, value, slope, size, h, values.size(), accept);
    TaylorTest test;
    test.name = name;
    test.value = value;
    test.slope = slope;
    measure(test, h, values);
    extrapolate(test);
    const Remainders all = remainders(test);
    if (all.measured < 3)
        test.verdict = text("only ", all.measured, " of ", h.size(), " steps could be evaluated; three are needed");
    else
        judge(test, all, size, accept);
    return test;
}

}  // namespace strake
