#pragma once
#include "optimize/space/design_space.hpp"

#include <atomic>
#include <memory>
#include <mutex>
#include <thread>

/// What each variable of a level does to the surface, to first order: the mode shapes of `strake check`.
namespace strake {

/// Computed at rest by a thread of its own, one variable after another; what is there already can be asked for.
class LinearPreview {
public:
    explicit LinearPreview(DesignSpace space);
    ~LinearPreview();  ///< gives up what is not computed yet
    LinearPreview(const LinearPreview&) = delete;
    LinearPreview& operator=(const LinearPreview&) = delete;

    /// How far any shape within the limits lies from the start, along the start's normals, to first order.
    struct Envelope {
        Eigen::VectorXf outward, inward;  ///< per vertex, >= 0
    };

    int num_ready() const { return ready_; }  ///< variables that are done, the first ones
    bool is_done() const { return done_; }
    std::string trouble() const;  ///< why it ended early; empty: it did not
    /// Displacement at x_j = 1, n x 3 row by row; null: not there (yet), or it moves nothing, or there is no room for
    /// so many (`max_bytes` in all).
    std::shared_ptr<const std::vector<float>> mode(int j) const;
    /// Null: not there yet.
    std::shared_ptr<const Envelope> envelope() const;

    static constexpr std::size_t max_bytes = 400u << 20;

private:
    void compute();
    void keep(int j, const Points& moved);
    void finish();

    DesignSpace space_;
    Points normal_;  ///< per vertex, unit
    Eigen::VectorXd outward_, inward_;
    mutable std::mutex busy_;  ///< of the next three
    std::vector<std::shared_ptr<const std::vector<float>>> modes_;
    std::shared_ptr<const Envelope> envelope_;
    std::string trouble_;
    std::size_t bytes_ = 0;
    std::atomic<int> ready_ = 0;
    std::atomic<bool> done_ = false, ends_ = false;
    std::thread thread_;  ///< last: it uses all others
};

}  // namespace strake
