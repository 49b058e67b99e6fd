#pragma once
#include "optimize/evaluate/combinations.hpp"
#include "optimize/evaluate/design_calls.hpp"
#include "optimize/evaluate/shape_evaluation.hpp"
#include "optimize/space/design_space.hpp"

/// Which quantities are asked for what, and how a call reaches the journal and the cache. Internal to the evaluator.
namespace strake {

class Journal;

/// What `measure` gives; an exception that a quantity may throw is its failure.
QuantityResult or_failure(const std::function<QuantityResult()>& measure);

class QuantityCalls {
public:
    /// @param differentiated names of the values whose gradients are wanted. @throws InvalidInput on unknown or
    /// repeated names.
    QuantityCalls(const Problem& problem, std::shared_ptr<const RestFacts> rest,
                  const std::vector<std::string>& differentiated);
    /// Answers of programs are kept there, and taken from there. @param stop_wanted handed on to them; may be empty.
    void keep_calls(Journal* journal, std::function<bool()> stop_wanted) {
        journal_ = journal;
        stop_wanted_ = std::move(stop_wanted);
    }

    const std::vector<std::string>& names() const { return names_; }  ///< of all values
    int index_of(const std::string& name) const;                      ///< @throws InvalidInput with the known names
    const std::vector<int>& differentiated() const { return differentiated_; }  ///< numbers of values
    const std::vector<int>& needed() const { return needed_; }  ///< differentiated ones and what they are made of
    const Combinations& combinations() const { return combinations_; }
    /// This quantity differentiates in a call of its own.
    bool are_gradients_apart(std::size_t quantity) const;

    /// What the calls for a design need to know.
    std::shared_ptr<const DesignCalls::Facts> facts_of(const DesignSpace& space, const Eigen::VectorXd& x, int number,
                                                       const Points& vertices) const;
    /// Values, with gradients where these come along. Nothing is called yet.
    std::unique_ptr<DesignCalls> value_calls(std::shared_ptr<const DesignCalls::Facts> facts) const;
    /// Gradients of the quantities that differentiate apart.
    std::unique_ptr<DesignCalls> gradient_calls(std::shared_ptr<const DesignCalls::Facts> facts) const;
    /// The answer of a quantity: values, or gradients alone. What it throws is a failure, too. Remarks and failures go
    /// to `result`.
    QuantityResult take(DesignCalls& calls, std::size_t quantity, bool wants_values, ShapeEvaluation& result) const;
    /// Per differentiated value its derivative along `direction` at these vertices; none where a program gives one.
    std::optional<Eigen::VectorXd> slopes_along(const Points& vertices, const Points& direction, int level) const;

private:
    QuantityResult call(const Quantity& quantity, const QuantityRequest& request) const;
    std::unique_ptr<DesignCalls> calls_of(const std::vector<Quantity>& quantities,
                                          std::shared_ptr<const DesignCalls::Facts> facts) const;
    bool wants_gradients_of(std::size_t quantity) const;
    std::vector<char> wanted_of(std::size_t quantity) const;  ///< which of its values need sensitivities
    void set_gradient_calls();

    const Problem& problem_;
    std::shared_ptr<const RestFacts> rest_;
    std::vector<std::string> names_;
    std::vector<int> differentiated_;  ///< indices into names_
    Combinations combinations_;
    std::vector<int> needed_;
    /// As the problem's quantities: what those are asked that differentiate separately; the others nothing.
    std::vector<Quantity> gradient_calls_;
    Journal* journal_ = nullptr;
    std::function<bool()> stop_wanted_;
};

}  // namespace strake
