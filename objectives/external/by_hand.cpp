#include "objectives/external/by_hand.hpp"

#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/text/file.hpp"
#include "core/text/shell_word.hpp"
#include "objectives/external/attempt.hpp"
#include "objectives/external/handed_over.hpp"
#include "objectives/external/log.hpp"
#include "objectives/external/refused.hpp"

#include <sys/stat.h>

namespace strake {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t words_limit = 1 << 20;

/// Runs the command like `strake run`; a failure becomes the file `failed`.
std::string script_of(const Task& task, const Call& call) {
    const std::string running = call.prefix + "running", failed = call.prefix + "failed";
    return text("#!/bin/sh\n# Runs the ", task.wanted == Wanted::gradients ? "gradient_command" : "command",
                " of this evaluation and reports its failure.\ncd ", shell_word(call.folder.string()),
                " || exit 1\n: > ", running, "\n", shell_line(task.command, call),
                "\nstatus=$?\n[ $status = 0 ] || { { echo \"exit status $status\"; tail -n 10 ", call.prefix,
                "stderr.log; } > ", failed, ".new; mv ", failed, ".new ", failed, "; }\nrm -f ", running,
                "\nexit $status\n");
}

void hand_out(const Task& task, const Call& call) {
    hand_over(task, call);
    // The same name for gradients: a loop that runs it needs only one name.
    write_atomically(call.folder / "command.sh", script_of(task, call));
    ::chmod((call.folder / "command.sh").c_str(), 0755);
    sign(task, call);
    write_atomically(call.file("awaited"), "");  // last: marks the place as complete
}

/// The place of the attempt among those prepared for this task: a run may have left others.
Call handed_out(const Task& task, int number) {
    std::error_code ignored;
    for (int k = 1;; ++k) {
        const Call call = place(task, k);
        if (take_place(task, call)) {
            hand_out(task, call);
            return call;
        }
        if (fs::exists(call.file("awaited"), ignored) && is_of(task, call) && --number == 0) return call;
    }
}

}  // namespace

QuantityResult attempt_by_hand(const Task& task, int number) {
    const Call call = handed_out(task, number);
    std::error_code ignored;
    const auto is_there = [&](const fs::path& file) {
        return fs::symlink_status(file, ignored).type() != fs::file_type::not_found;
    };
    const bool has_failed = is_there(call.file("failed"));
    if (is_there(call.file("running")) || !(has_failed || is_there(call.result)))
        throw Awaited{{{task.command.name, task.request.evaluation, call.folder.string(), call.request.string(),
                        arguments_of(task.command, call)}}};
    try {
        if (has_failed) {
            const std::string name = call.prefix + "failed", words = read_handed_over(call.folder, name, words_limit);
            throw Refused{{"reported", text("the file '", name, "' is there:\n", printable_tail(words, 10))}};
        }
        return read_results(task, call);
    } catch (const Refused& refused) {
        return failed(task, call, refused.failure, "");
    }
}

}  // namespace strake
