#pragma once
#include <chrono>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

/// A run folder as the page sees it, also of a run that was started elsewhere. Looked at only when a page asks, and
/// never so often that looking takes more than a fiftieth of the time.
namespace strake {

class RunWatch {
public:
    explicit RunWatch(std::filesystem::path folder) : folder_(std::move(folder)) {}
    const std::filesystem::path& folder() const { return folder_; }

    /// {folder, status, reason, level, evaluations, max_evaluations, seconds, objective, max_violation,
    /// best_evaluation, has_report, has_convergence, holder, from, rows: [[evaluation, level, status, objective,
    /// max_violation, seconds, is_best, reason], …] from number `from` on (at most 2000)}.
    /// @throws InputError: no run there.
    nlohmann::ordered_json look(int from);
    /// Quantities of its case whose programs write how they converge, and into which file of their folder.
    std::map<std::string, std::filesystem::path> convergence_of();

private:
    using Clock = std::chrono::steady_clock;
    std::filesystem::path folder_;
    std::mutex busy_;
    Clock::time_point next_{};
    nlohmann::ordered_json facts_, rows_ = nlohmann::ordered_json::array();
    std::optional<std::map<std::string, std::filesystem::path>> convergence_;
    void refresh();
    void read_convergence_keys();
};

}  // namespace strake
