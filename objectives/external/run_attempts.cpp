#include "objectives/external/run_attempts.hpp"

#include "core/error.hpp"
#include "core/text/file.hpp"
#include "objectives/external/by_hand.hpp"
#include "objectives/external/hand_over.hpp"
#include "objectives/external/process.hpp"
#include "objectives/external/refused.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

namespace strake {
namespace {

void pause_before(const ExternalCommand& command, const QuantityRequest& request, int attempt) {
    const double seconds = std::min(10.0, std::ldexp(command.pause_s, std::min(attempt - 2, 20)));
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    do {
        if (request.stop_wanted && request.stop_wanted()) throw Interrupted{};
        std::this_thread::sleep_for(std::chrono::duration<double>(std::min(seconds, 0.02)));
    } while (std::chrono::steady_clock::now() < until);
}

/// Empty; written once the program's answer has been read.
constexpr const char* answered = "answered";

bool is_for(const Task& task, const Call& call) {
    try {
        return read_bytes(call.request) == request_text(task, call) &&
               (task.wanted == Wanted::gradients ||
                read_bytes(call.surface) ==
                    handed_over_bytes(task.request.surface, task.command.format, task.command.points.get()));
    } catch (const InputError&) {
        return false;
    }
}

/// What the program answered to the same question in an earlier start, whose journal had no time or no room for it.
std::optional<QuantityResult> earlier_answer(const Task& task) {
    for (int number = 1;; ++number) {
        const Call call = place(task, number);
        if (!is_taken(task, call)) return {};
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(call.file(answered), ignored) || !is_for(task, call)) continue;
        try {
            return read_results(task, call);
        } catch (const Refused&) {  // damaged since
        }
    }
}

QuantityResult attempt_as_process(const Task& task, int number) {
    if (number == 1 && task.command.may_follow_others)
        if (std::optional<QuantityResult> earlier = earlier_answer(task)) return *earlier;
    const Call call = fresh_place(task, number);
    hand_over(task, call);
    ProcessCommand process;
    process.arguments = arguments_of(task.command, call);
    process.folder = call.folder;
    process.timeout_s = timeout_of(task.command, call);
    process.grace_s = task.command.grace_s;
    process.stop_wanted = task.request.stop_wanted;
    process.log_prefix = call.prefix;
    const ProcessEnd end = run_process(process);
    if (end.failure && end.failure->kind == "interrupted") throw Interrupted{};
    try {
        if (end.failure) throw Refused{*end.failure};
        QuantityResult result = read_results(task, call);
        std::ofstream(call.file(answered));  // takes no room on a full disk; where it fails, the program runs again
        return result;
    } catch (const Refused& refused) {
        return failed(task, call, refused.failure, end.last_lines);
    }
}

}  // namespace

std::string headline(const Failure& failure) {
    return text(failure.kind, ": ", failure.message.substr(0, failure.message.find('\n')));
}

QuantityResult run_attempts(const Task& task, SlurmQueue* queue) {
    std::vector<std::string> remarks;
    QuantityResult result;
    const int attempts = 1 + task.command.retries;
    for (int k = 1; k <= attempts; ++k) {
        if (k > 1 && !task.command.by_hand) pause_before(task.command, task.request, k);
        result = task.command.by_hand ? attempt_by_hand(task, k)
                 : queue              ? attempt_as_job(task, *queue, k)
                                      : attempt_as_process(task, k);
        if (!result.failure || result.failure->kind == "spawn") break;
        if (k < attempts)
            remarks.push_back(text(headline(*result.failure), "; attempt ", k + 1, " of ", attempts, " follows"));
    }
    if (result.failure && attempts > 1 && result.failure->kind != "spawn")
        result.failure->message += text("\n  ", attempts, " attempts failed");
    result.remarks = std::move(remarks);
    return result;
}

QuantityResult gradients_of(const ExternalCommand& command, SlurmQueue* queue, const QuantityRequest& request) {
    Task task{command, request, Wanted::gradients, find_folder_of_values(command, request)};
    std::vector<std::string> remarks;
    if (task.folder_of_values.empty()) {
        remarks.push_back(
            text(command.name, ": the folder of evaluation ", request.evaluation, " is gone: the command runs again"));
        QuantityResult again = run_attempts({command, request, Wanted::values}, queue);
        remarks.insert(remarks.end(), again.remarks.begin(), again.remarks.end());
        again.remarks = remarks;
        again.values.clear();
        if (again.failure) return again;
        task.folder_of_values = find_folder_of_values(command, request);
        if (task.folder_of_values.empty())
            throw OutputError(text(command.evaluations_dir.string(), ": a folder has vanished"));
    }
    QuantityResult result = run_attempts(task, queue);
    result.remarks.insert(result.remarks.begin(), remarks.begin(), remarks.end());
    return result;
}

}  // namespace strake
