#include "studio/run_watch.hpp"

#include "casefile/load_case.hpp"
#include "core/error.hpp"
#include "report/json_number.hpp"
#include "report/run_status.hpp"

#include <ctime>

namespace strake {
namespace {

/// Of the processor, not of the clock: beside a run that takes all of it, looking lasts longer but costs no more.
std::chrono::nanoseconds time_spent() {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

}  // namespace

/// A run's case does not change but for its budget.
void RunWatch::read_convergence_keys() {
    std::error_code missing;
    if (convergence_ || !std::filesystem::exists(folder_ / "case.yaml", missing)) return;
    convergence_.emplace();
    try {
        for (const QuantityEntry& entry : load_case(folder_ / "case.yaml").quantities)
            if (const auto* program = std::get_if<ExternalEntry>(&entry.what); program && !program->convergence.empty())
                convergence_->emplace(entry.name, program->convergence);
    } catch (const std::exception&) {
        convergence_->clear();  // the run itself says what is wrong with its case
    }
}

std::map<std::string, std::filesystem::path> RunWatch::convergence_of() {
    const std::lock_guard lock(busy_);
    read_convergence_keys();
    return convergence_.value_or(std::map<std::string, std::filesystem::path>());
}

void RunWatch::refresh() {
    read_convergence_keys();
    const RunStatus status = run_status(folder_);
    facts_ = {{"folder", folder_.string()},
              {"status", status.status},
              {"reason", status.reason},
              {"level", status.level},
              {"evaluations", status.evaluations},
              {"max_evaluations", status.max_evaluations},
              {"seconds", status.seconds},
              {"objective", json_number(status.objective)},
              {"max_violation", json_number(status.max_violation)},
              {"best_evaluation", status.best_evaluation},
              {"has_report", std::filesystem::exists(folder_ / "report.html")},
              {"has_convergence", convergence_ && !convergence_->empty()},
              {"holder", nullptr}};
    if (status.holder) facts_["holder"] = status.holder->words();
    rows_ = nlohmann::ordered_json::array();
    std::error_code missing;
    if (!std::filesystem::exists(folder_ / "journal.sqlite", missing)) return;
    const auto journal = Journal::look(folder_ / "journal.sqlite");
    for (const JournalEvaluation& e : journal->evaluations())
        rows_.push_back({e.number, e.level, e.status, json_number(e.objective), json_number(e.max_violation), e.seconds,
                         e.accepted, e.reason.substr(0, 500)});
}

nlohmann::ordered_json RunWatch::look(int from) {
    const std::lock_guard lock(busy_);
    if (Clock::now() >= next_) {
        const std::chrono::nanoseconds before = time_spent();
        refresh();
        const std::chrono::nanoseconds cost = time_spent() - before;
        next_ = Clock::now() + std::max<Clock::duration>(std::chrono::milliseconds(100), 50 * cost);
    }
    nlohmann::ordered_json answer = facts_, rows = nlohmann::ordered_json::array();
    constexpr std::size_t max_rows = 2000;
    for (std::size_t k = static_cast<std::size_t>(std::max(0, from)); k < rows_.size() && rows.size() < max_rows; ++k)
        rows.push_back(rows_[k]);
    answer["from"] = from;
    answer["rows"] = std::move(rows);
    return answer;
}

}  // namespace strake
