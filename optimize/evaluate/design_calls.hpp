#pragma once
#include "objectives/quantity/quantity.hpp"

#include <atomic>
#include <future>
#include <memory>

/// What the quantities say of one design, where several programs run at the same time. Internal.
namespace strake {

class DesignCalls {
public:
    struct Facts {
        TriMesh surface;
        std::string hash;  ///< of the surface; empty: not known
        int number = 0, level = 0;
        std::vector<std::pair<std::string, double>> variables, parameters;
        std::function<bool()> stop_wanted;
    };
    using Maker = std::function<QuantityResult(const Quantity&, const QuantityRequest&)>;

    /// Nothing is called yet. @param gradients per quantity: its sensitivities are wanted, those of the values that
    /// `wanted` marks.
    /// @param make a call; of a program in a thread of its own.
    DesignCalls(const std::vector<Quantity>& quantities, std::shared_ptr<const Facts> facts,
                std::vector<char> gradients, std::vector<std::vector<char>> wanted, Maker make);
    ~DesignCalls();  ///< stops and cancels what runs
    DesignCalls(const DesignCalls&) = delete;
    DesignCalls& operator=(const DesignCalls&) = delete;

    /// Evaluates built-in quantities, starts programs and takes their answers, in the order of the quantities; what
    /// follows a failure is not called any more. @param free concurrent calls left per quantity, reduced by what is
    /// started.
    void advance(std::vector<int>& free);
    bool is_ready() const;    ///< all answers up to the first failure are there
    bool is_running() const;  ///< a program
    bool is_awaited() const;  ///< an answer comes from outside
    int occupied(std::size_t quantity) const;

    /// Ends what runs and waits for that. @param cancelled as QuantityRequest::is_cancelled.
    void stop(bool cancelled);
    /// Adds the jobs that go on after `stop`, and the calls that are awaited.
    void add_pending(std::vector<std::string>& jobs) const;
    void add_awaited(std::vector<AwaitedCall>& calls) const;

    /// The answer of a quantity; where it was not called, it is now, in this thread. @throws what the call has thrown.
    QuantityResult take(std::size_t quantity);
    const std::shared_ptr<const Facts>& facts() const { return facts_; }

private:
    struct Stop {
        std::atomic<bool> wanted{false}, cancelled{false};
    };
    enum class State { none, running, done, awaited };
    struct Call {
        State state = State::none;
        std::future<QuantityResult> future;
        QuantityResult result;
        std::exception_ptr thrown;
        bool has_failed() const { return thrown || result.failure; }
    };
    QuantityRequest request(std::size_t quantity) const;
    void run(std::size_t quantity, Call& call);
    static void collect(Call& call);
    void end(std::size_t first, bool cancelled);

    const std::vector<Quantity>& quantities_;
    std::shared_ptr<const Facts> facts_;
    std::vector<char> gradients_;
    std::vector<std::vector<char>> wanted_;
    Maker make_;
    std::shared_ptr<Stop> stop_ = std::make_shared<Stop>();
    std::vector<Call> calls_;
};

}  // namespace strake
