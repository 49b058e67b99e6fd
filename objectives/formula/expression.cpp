#include "objectives/formula/expression.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

namespace strake {
namespace {

constexpr std::size_t max_length = 10000;
constexpr int max_depth = 100;

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

/// Recursive descent: sum > product > sign > power > atom.
struct Expression::Parser {
    const std::string& text_;
    const std::vector<std::string>& known;
    std::vector<Step>& steps;
    std::vector<std::string>& names;
    std::size_t at = 0;
    int depth = 0;

    struct Function {
        const char* name;
        Op op;
        int least, most;  ///< arguments
    };
    static const std::vector<Function>& functions() {
        constexpr int many = 1000;
        static const std::vector<Function> all{{"sqrt", Op::square_root, 1, 1},
                                               {"exp", Op::exponential, 1, 1},
                                               {"log", Op::logarithm, 1, 1},
                                               {"log10", Op::logarithm10, 1, 1},
                                               {"sin", Op::sine, 1, 1},
                                               {"cos", Op::cosine, 1, 1},
                                               {"tan", Op::tangent, 1, 1},
                                               {"asin", Op::arc_sine, 1, 1},
                                               {"acos", Op::arc_cosine, 1, 1},
                                               {"atan", Op::arc_tangent, 1, 1},
                                               {"abs", Op::absolute, 1, 1},
                                               {"tanh", Op::hyperbolic_tangent, 1, 1},
                                               {"min", Op::minimum, 2, many},
                                               {"max", Op::maximum, 2, many},
                                               {"softmin", Op::soft_minimum, 3, many},
                                               {"softmax", Op::soft_maximum, 3, many}};
        return all;
    }

    [[noreturn]] void refuse(const std::string& what) const {
        throw InvalidInput(text("formula '", text_.size() > 200 ? text_.substr(0, 200) + "..." : text_, "', column ",
                                at + 1, ": ", what));
    }
    char next() {
        while (at < text_.size() && (text_[at] == ' ' || text_[at] == '\n' || text_[at] == '\t')) ++at;
        return at < text_.size() ? text_[at] : '\0';
    }
    bool take(char c) {
        if (next() != c) return false;
        ++at;
        return true;
    }
    std::string shown() { return next() == '\0' ? "the end" : text("'", next(), "'"); }

    void sum() {
        if (++depth > max_depth) refuse(text("nested deeper than ", max_depth));
        product();
        while (next() == '+' || next() == '-') {
            const Op op = take('+') ? Op::add : (++at, Op::subtract);
            product();
            steps.push_back({op});
        }
        --depth;
    }
    void product() {
        sign();
        while (next() == '*' || next() == '/') {
            const Op op = take('*') ? Op::multiply : (++at, Op::divide);
            sign();
            steps.push_back({op});
        }
    }
    void sign() {
        if (++depth > max_depth) refuse(text("nested deeper than ", max_depth));
        if (take('-')) {
            sign();
            steps.push_back({Op::negate});
        } else if (take('+'))
            sign();
        else
            power();
        --depth;
    }
    void power() {
        atom();
        if (!take('^')) return;
        sign();
        steps.push_back({Op::power});
    }
    void atom() {
        const char c = next();
        if (take('(')) {
            sum();
            if (!take(')')) refuse(text("')' expected, got ", shown()));
        } else if (is_digit(c) || c == '.')
            number();
        else if (is_letter(c))
            word();
        else
            refuse(text("a number, a name or '(' expected, got ", shown()));
    }
    void number() {
        double value = 0;
        const auto [end, error] = std::from_chars(text_.data() + at, text_.data() + text_.size(), value);
        if (error != std::errc() || !std::isfinite(value)) refuse("not a number");
        at = static_cast<std::size_t>(end - text_.data());
        if (at < text_.size() && (is_letter(text_[at]) || text_[at] == '.')) refuse("an operator expected");
        steps.push_back({Op::number, value});
    }
    void word();
    void call(const Function& function);
};

/// The longest known name that begins here; it may contain '-'.
void Expression::Parser::word() {
    std::size_t end = at, plain = at;
    while (end < text_.size() && (is_letter(text_[end]) || is_digit(text_[end]) || text_[end] == '.' ||
                                  text_[end] == '-' || text_[end] == '@'))
        ++end;
    while (plain < end && text_[plain] != '-') ++plain;
    for (std::size_t e = end; e >= plain; --e) {
        const std::string name = text_.substr(at, e - at);
        const bool is_cut_short =
            e != end && (is_letter(text_[e]) || is_digit(text_[e]) || text_[e] == '.' || text_[e] == '@');
        if (is_cut_short) continue;
        if (std::find(known.begin(), known.end(), name) == known.end()) continue;
        const auto place = std::find(names.begin(), names.end(), name);
        steps.push_back({Op::name, 0, static_cast<int>(place - names.begin())});
        if (place == names.end()) names.push_back(name);
        at = e;
        return;
    }
    const std::string name = text_.substr(at, plain - at);
    for (const Function& function : functions())
        if (name == function.name) {
            at = plain;
            return call(function);
        }
    if (name != "pi") {
        std::string list;
        for (const std::string& one : known) list += (list.empty() ? "" : ", ") + one;
        refuse(text("'", name, "' is not known; there are: ", list.empty() ? "none" : list));
    }
    at = plain;
    steps.push_back({Op::number, std::numbers::pi});
}

void Expression::Parser::call(const Function& function) {
    if (!take('(')) refuse(text("'(' expected after ", function.name, ", got ", shown()));
    int count = 0;
    do {
        sum();
        ++count;
    } while (take(','));
    if (!take(')')) refuse(text("',' or ')' expected, got ", shown()));
    if (count < function.least || count > function.most)
        refuse(text(function.name, " takes ", function.least == function.most ? "" : "at least ", function.least,
                    function.least == 1 ? " argument" : " arguments", ", got ", count));
    steps.push_back({function.op, 0, count});
}

Expression::Expression(const std::string& formula, const std::vector<std::string>& known) {
    if (formula.size() > max_length)
        throw InvalidInput(text("a formula of ", formula.size(), " characters is too long; the limit is ", max_length));
    Parser parser{formula, known, steps_, names_};
    parser.sum();
    if (parser.next() != '\0') parser.refuse(text("an operator expected, got ", parser.shown()));
}

/// Dual numbers: values with their derivatives by all names.
struct ExpressionStack {
    using Op = Expression::Op;
    struct Dual {
        double v;
        Eigen::VectorXd d;
    };
    std::vector<Dual> stack;
    Eigen::Index count;

    void push(double v, Eigen::VectorXd d) { stack.push_back({v, std::move(d)}); }
    Dual pop() {
        Dual top = std::move(stack.back());
        stack.pop_back();
        return top;
    }
    /// d is empty when no gradient is requested.
    void chain(double v, double slope, const Dual& a) { push(v, slope_times(slope, a.d)); }
    /// Constants keep derivative zero where the slope is not finite.
    static Eigen::VectorXd slope_times(double slope, const Eigen::VectorXd& d) {
        return d.unaryExpr([slope](double x) { return x == 0 ? 0.0 : slope * x; });
    }
    void binary(Op op);
    void power(const Dual& a, const Dual& b);
    void unary(Op op);
    void extreme(Op op, int arguments);
};

void ExpressionStack::binary(Op op) {
    const Dual b = pop(), a = pop();
    if (op == Op::add) push(a.v + b.v, a.d + b.d);
    if (op == Op::subtract) push(a.v - b.v, a.d - b.d);
    if (op == Op::multiply) push(a.v * b.v, slope_times(b.v, a.d) + slope_times(a.v, b.d));
    if (op == Op::divide) push(a.v / b.v, slope_times(1 / b.v, a.d) + slope_times(-a.v / (b.v * b.v), b.d));
    if (op == Op::power) power(a, b);
}

void ExpressionStack::power(const Dual& a, const Dual& b) {
    const double v = std::pow(a.v, b.v);
    push(v, slope_times(b.v == 0 ? 0 : b.v * std::pow(a.v, b.v - 1), a.d) +
                slope_times(v == 0 && b.v > 0 ? 0 : v * std::log(a.v), b.d));
}

void ExpressionStack::unary(Op op) {
    const Dual a = pop();
    const double x = a.v, s = std::sin(x), c = std::cos(x);
    if (op == Op::negate) chain(-x, -1, a);
    if (op == Op::square_root) chain(std::sqrt(x), 0.5 / std::sqrt(x), a);
    if (op == Op::exponential) chain(std::exp(x), std::exp(x), a);
    if (op == Op::logarithm) chain(std::log(x), 1 / x, a);
    if (op == Op::logarithm10) chain(std::log10(x), 1 / (x * std::numbers::ln10), a);
    if (op == Op::sine) chain(s, c, a);
    if (op == Op::cosine) chain(c, -s, a);
    if (op == Op::tangent) chain(s / c, 1 / (c * c), a);
    if (op == Op::arc_sine) chain(std::asin(x), 1 / std::sqrt(1 - x * x), a);
    if (op == Op::arc_cosine) chain(std::acos(x), -1 / std::sqrt(1 - x * x), a);
    if (op == Op::arc_tangent) chain(std::atan(x), 1 / (1 + x * x), a);
    if (op == Op::hyperbolic_tangent) chain(std::tanh(x), 1 - std::tanh(x) * std::tanh(x), a);
    if (op == Op::absolute) chain(std::abs(x), x > 0 ? 1 : x < 0 ? -1 : 0, a);
}

/// softmax(w, a, ...) = w log sum exp(a / w); softmin(w, a, ...) = - softmax(w, -a, ...).
void ExpressionStack::extreme(Op op, int arguments) {
    std::vector<Dual> all;
    for (int i = 0; i < arguments; ++i) all.insert(all.begin(), pop());
    const double sign = op == Op::minimum || op == Op::soft_minimum ? -1 : 1;
    const bool soft = op == Op::soft_minimum || op == Op::soft_maximum;
    std::size_t best = soft ? 1 : 0;
    for (std::size_t i = best; i < all.size(); ++i)
        if (sign * all[i].v > sign * all[best].v || std::isnan(all[i].v)) best = i;
    if (!soft) return push(all[best].v, all[best].d);
    const double w = all[0].v > 0 ? all[0].v : std::nan(""), top = sign * all[best].v;
    double sum = 0, mean = 0;
    for (std::size_t i = 1; i < all.size(); ++i) sum += std::exp((sign * all[i].v - top) / w);
    Eigen::VectorXd d = Eigen::VectorXd::Zero(count);
    for (std::size_t i = 1; i < all.size(); ++i) {
        const double share = std::exp((sign * all[i].v - top) / w) / sum;
        d += slope_times(share, all[i].d);
        mean += share * sign * all[i].v;
    }
    const double value = top + w * std::log(sum);
    d += slope_times(sign * (value - mean) / w, all[0].d);
    push(sign * value, d);
}

double Expression::value(const Eigen::VectorXd& values, Eigen::VectorXd* gradient) const {
    if (values.size() != static_cast<Eigen::Index>(names_.size()))
        throw InvalidInput(text(values.size(), " values for a formula of ", names_.size(), " names"));
    ExpressionStack run{{}, gradient ? values.size() : 0};
    for (const Step& step : steps_) {
        if (step.op == Op::number)
            run.push(step.number, Eigen::VectorXd::Zero(run.count));
        else if (step.op == Op::name)
            run.push(values[step.count],
                     gradient ? Eigen::VectorXd(Eigen::VectorXd::Unit(run.count, step.count)) : Eigen::VectorXd());
        else if (step.op <= Op::power)
            run.binary(step.op);
        else if (step.op < Op::minimum)
            run.unary(step.op);
        else
            run.extreme(step.op, step.count);
    }
    if (gradient) *gradient = run.stack.back().d;
    return run.stack.back().v;
}

}  // namespace strake
