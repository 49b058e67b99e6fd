#include "core/error.hpp"
#include "core/mesh/file.hpp"
#include "core/mesh/io.hpp"
#include "objectives/external/attempt.hpp"
#include "objectives/external/hand_over.hpp"
#include "objectives/external/process.hpp"
#include "objectives/external/refused.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

namespace strake {
namespace {

namespace fs = std::filesystem;

void pause_before(const ExternalCommand& command, const QuantityRequest& request, int attempt) {
    const double seconds = std::min(10.0, std::ldexp(command.pause_s, std::min(attempt - 2, 20)));
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    do {
        if (request.stop_wanted && request.stop_wanted()) throw Interrupted{};
        std::this_thread::sleep_for(std::chrono::duration<double>(std::min(seconds, 0.02)));
    } while (std::chrono::steady_clock::now() < until);
}

ProcessEnd run(const ExternalCommand& command, const QuantityRequest& request, const Call& call,
               std::vector<std::string> arguments, double timeout_s, const std::string& log_prefix) {
    ProcessCommand process;
    process.arguments = std::move(arguments);
    process.folder = call.folder;
    process.timeout_s = timeout_s;
    process.grace_s = command.grace_s;
    process.stop_wanted = request.stop_wanted;
    process.log_prefix = log_prefix;
    ProcessEnd end = run_process(process);
    if (end.failure && end.failure->kind == "interrupted") throw Interrupted{};
    return end;
}

bool holds(const fs::path& file, const std::string& bytes) {
    std::error_code ignored;
    if (fs::file_size(file, ignored) != bytes.size() || ignored) return false;
    try {
        return read_bytes(file) == bytes;
    } catch (const InputError&) {
        return false;
    }
}

/// The folder in which the command has given the values of this shape: the last that was handed the same surface.
std::optional<fs::path> folder_of_values(const ExternalCommand& command, const QuantityRequest& request) {
    const std::string bytes = handed_over_bytes(request.surface, command.format, command.points.get());
    const fs::path first = first_folder(command, request.evaluation);
    std::optional<fs::path> found;
    std::error_code ignored;
    for (int k = 1;; ++k) {
        const fs::path folder = attempt_folder(first, k);
        if (!fs::is_directory(folder, ignored)) return found;
        const Call call = call_in(command, folder);
        if (fs::is_regular_file(call.result, ignored) && holds(call.surface, bytes)) found = folder;
    }
}

/// What an earlier attempt at the gradient still writes must not be taken for the result of this one.
Call fresh_gradient_call(const ExternalCommand& command, const fs::path& folder, std::string& prefix) {
    Call call = call_in(command, folder);
    std::error_code ignored;
    for (int k = 1;; ++k) {
        const std::string stem = k == 1 ? "gradient" : text("gradient-", k);
        call.request = folder / (stem + "_request.json");
        call.result = folder / (stem + ".json");
        prefix = stem + "-";
        const auto is_there = [&](const fs::path& file) {
            return fs::symlink_status(file, ignored).type() != fs::file_type::not_found;
        };
        if (!is_there(call.request) && !is_there(call.result) && !is_there(folder / (prefix + "stdout.log")))
            return call;
    }
}

QuantityResult gradient_attempt(const ExternalCommand& command, const QuantityRequest& request,
                                const fs::path& folder) {
    std::string prefix;
    const Call call = fresh_gradient_call(command, folder, prefix);
    write_request(command, request, call, true);
    const ProcessEnd end = run(command, request, call, gradient_arguments_of(command, call),
                               command.gradient_timeout_s.value_or(command.timeout_s), prefix);
    try {
        if (end.failure) throw Refused{*end.failure};
        return read_results(command, request, call, true, false);
    } catch (const Refused& refused) {
        return failed(command, request, call, {refused.failure.kind, "gradient: " + refused.failure.message},
                      end.last_lines);
    }
}

}  // namespace

std::string headline(const Failure& failure) {
    return text(failure.kind, ": ", failure.message.substr(0, failure.message.find('\n')));
}

QuantityResult with_retries(const ExternalCommand& command, const QuantityRequest& request,
                            const std::function<QuantityResult(int)>& attempt) {
    std::vector<std::string> remarks;
    QuantityResult result;
    const int attempts = 1 + command.retries;
    for (int k = 1; k <= attempts; ++k) {
        if (k > 1) pause_before(command, request, k);
        result = attempt(k);
        if (!result.failure || result.failure->kind == "spawn") break;
        if (k < attempts)
            remarks.push_back(text(headline(*result.failure), "; attempt ", k + 1, " of ", attempts, " follows"));
    }
    if (result.failure && command.retries > 0 && result.failure->kind != "spawn")
        result.failure->message += text("\n  ", attempts, " attempts failed");
    result.remarks = std::move(remarks);
    return result;
}

QuantityResult attempt_as_process(const ExternalCommand& command, const QuantityRequest& request, int number,
                                  bool want_gradients) {
    const Call call = fresh_call(command, request.evaluation, number);
    hand_over(command, request, call, want_gradients);
    const ProcessEnd end = run(command, request, call, arguments_of(command, call), command.timeout_s, "");
    try {
        if (end.failure) throw Refused{*end.failure};
        return read_results(command, request, call, want_gradients);
    } catch (const Refused& refused) {
        return failed(command, request, call, refused.failure, end.last_lines);
    }
}

QuantityResult gradients_of(const ExternalCommand& command, const QuantityRequest& request) {
    std::optional<fs::path> folder = folder_of_values(command, request);
    std::vector<std::string> remarks;
    if (!folder) {
        remarks.push_back(
            text(command.name, ": the folder of evaluation ", request.evaluation, " is gone: the command runs again"));
        QuantityResult again =
            with_retries(command, request, [&](int k) { return attempt_as_process(command, request, k, false); });
        remarks.insert(remarks.end(), again.remarks.begin(), again.remarks.end());
        again.remarks = remarks;
        again.values.clear();
        if (again.failure) return again;
        folder = folder_of_values(command, request);
        if (!folder) throw OutputError(text(command.evaluations_dir.string(), ": a folder has vanished"));
    }
    QuantityResult result =
        with_retries(command, request, [&](int) { return gradient_attempt(command, request, *folder); });
    result.remarks.insert(result.remarks.begin(), remarks.begin(), remarks.end());
    return result;
}

}  // namespace strake
