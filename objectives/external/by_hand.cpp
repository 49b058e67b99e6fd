#include "objectives/external/by_hand.hpp"

#include "core/error.hpp"
#include "core/mesh/file.hpp"
#include "core/mesh/io.hpp"
#include "objectives/external/attempt.hpp"
#include "objectives/external/handed_over.hpp"
#include "objectives/external/log.hpp"
#include "objectives/external/refused.hpp"

#include <sys/stat.h>

namespace strake {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t words_limit = 1 << 20;

/// Runs the command as `run` would; a failure becomes the file `failed`.
std::string script_of(const ExternalCommand& command, const Call& call) {
    return "#!/bin/sh\n# Runs the command of this evaluation and reports its failure.\ncd " +
           shell_words(call.folder.string()) + " || exit 1\n: > running\n" + shell_words(arguments_of(command, call)) +
           " > stdout.log 2> stderr.log < /dev/null\nstatus=$?\n" +
           "[ $status = 0 ] || { { echo \"exit status $status\"; tail -n 10 stderr.log; } > failed.new;" +
           " mv failed.new failed; }\nrm -f running\nexit $status\n";
}

void hand_out(const ExternalCommand& command, const QuantityRequest& request, const Call& call) {
    hand_over(command, request, call, request.want_sensitivities && command.has_gradients);
    write_atomically(call.folder / "command.sh", script_of(command, call));
    ::chmod((call.folder / "command.sh").c_str(), 0755);
    sign(request, call);
    write_atomically(call.folder / "awaited", "");  // the last: now it is complete
}

/// The folder of the attempt, counting only those that were handed out for this request: a run may have left others.
Call handed_out(const ExternalCommand& command, const QuantityRequest& request, int number) {
    const fs::path first = first_folder(command, request.evaluation);
    std::error_code ignored;
    for (int k = 1;; ++k) {
        const Call call = call_in(command, attempt_folder(first, k));
        if (make_call_folder(call.folder)) {
            hand_out(command, request, call);
            return call;
        }
        const bool gradients = request.want_sensitivities && command.has_gradients;
        if (fs::exists(call.folder / "awaited", ignored) && is_of(command, request, call, gradients) && --number == 0)
            return call;
    }
}

}  // namespace

QuantityResult attempt_by_hand(const ExternalCommand& command, const QuantityRequest& request, int number) {
    const Call call = handed_out(command, request, number);
    std::error_code ignored;
    const auto is_there = [&](const char* name) {
        return fs::symlink_status(call.folder / name, ignored).type() != fs::file_type::not_found;
    };
    if (is_there("running") || !(is_there("failed") || is_there("result.json")))
        throw Awaited{{{command.name, request.evaluation, call.folder.string(), arguments_of(command, call)}}};
    try {
        if (is_there("failed")) {
            const std::string words = read_handed_over(call.folder, "failed", words_limit);
            throw Refused{{"reported", text("the file 'failed' is there:\n", printable_tail(words, 10))}};
        }
        return read_results(command, request, call, request.want_sensitivities && command.has_gradients);
    } catch (const Refused& refused) {
        return failed(command, request, call, refused.failure, "");
    }
}

}  // namespace strake
