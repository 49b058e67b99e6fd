#pragma once
#include "optimize/space/design_space.hpp"

/// One evaluation at the start design, and what was understood of each quantity's answer.
namespace strake {

struct StartAnswer {
    struct Value {
        std::string name;
        double value = std::numeric_limits<double>::quiet_NaN();
        bool has_gradient = false, is_gradient_needed = true;
        double gradient_norm = 0;     ///< of dJ/dv, Euclidean
        double largest_gradient = 0;  ///< of one vertex
        int largest_vertex = -1;
        std::vector<std::pair<std::string, double>> by_variable;  ///< of the parameters; NaN: not known
    };
    struct Quantity {
        std::vector<Value> values;
        bool is_program = false, was_asked_for_gradients = false;
        double seconds = 0, gradient_seconds = 0;  ///< the second of a gradient command
        std::optional<Failure> failure;
    };
    struct Row {
        std::string quantity;
        double value = 0, limit = 0, scale = 1;  ///< of the quantity
        double scaled = 0;                       ///< as the optimizer sees it: <= 0, or = 0
        bool is_equality = false;
    };
    std::string status, reason;  ///< "ok", or as EvaluationStatus
    int level = 0, variables = 0;
    std::vector<Quantity> quantities;
    std::vector<Row> constraints;  ///< empty unless ok
    std::vector<std::string> remarks;
};

/// Evaluates `problem` once at the start of its first level, with gradients where the method takes them and the
/// quantities have them. Failing is a result. @throws InvalidInput: no variable moves anything.
StartAnswer check_start(const Problem& problem);
/// The same in a space that is there already. @throws InvalidInput: it has no variables.
StartAnswer check_start(const Problem& problem, std::shared_ptr<const RestFacts> rest, const DesignSpace& space);

/// The problem with those quantities and constraints only whose values need no program: what can be known of the start
/// for nothing.
Problem without_programs(const Problem& problem);

}  // namespace strake
