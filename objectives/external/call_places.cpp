#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/text/file.hpp"
#include "objectives/external/attempt.hpp"
#include "objectives/external/hand_over.hpp"
#include "objectives/external/refused.hpp"

#include <cstdio>

/// Places of attempts.
namespace strake {
namespace {

namespace fs = std::filesystem;

fs::path first_folder(const ExternalCommand& command, int evaluation) {
    if (evaluation < 0) throw InvalidInput(text(command.name, ": evaluation = ", evaluation, " must be >= 0"));
    char number[16];
    std::snprintf(number, sizeof number, "%06d", evaluation);
    fs::path first = fs::absolute(command.evaluations_dir).lexically_normal() / number;
    if (command.own_folder) first /= command.name;
    return first;
}

bool is_there(const fs::path& file) {
    std::error_code ignored;
    return fs::symlink_status(file, ignored).type() != fs::file_type::not_found;
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

/// Whether the command has ended there with values, however it was run.
bool has_values(const Task& task, const Call& call) {
    for (const char* name : {"running", "failed", "job.sh.ended"})
        if (is_there(call.file(name))) return false;
    if (is_there(call.file("job.sh")) && !is_there(call.file("exit"))) return false;
    try {
        read_results(task, call);
        return true;
    } catch (const Refused&) {
        return false;
    }
}

}  // namespace

Call place(const Task& task, int number) {
    const bool is_gradient = task.wanted == Wanted::gradients;
    const std::string suffix = number > 1 ? text("-", number) : "";
    Call call;
    call.wanted = task.wanted;
    call.folder = is_gradient ? task.folder_of_values : first_folder(task.command, task.request.evaluation);
    if (!is_gradient) call.folder += suffix;
    if (is_gradient) call.prefix = "gradient" + suffix + "-";
    call.surface = call.folder / handed_over_name(task.command.format);
    call.request = call.folder / (is_gradient ? "gradient" + suffix + "_request.json" : "request.json");
    call.result = call.folder / (is_gradient ? "gradient" + suffix + ".json" : "result.json");
    return call;
}

bool is_taken(const Task& task, const Call& call) {
    if (task.wanted != Wanted::gradients) return is_there(call.folder);
    return is_there(call.request) || is_there(call.result) || is_there(call.file("stdout.log"));
}

bool take_place(const Task& task, const Call& call) {
    if (task.wanted == Wanted::gradients) return !is_taken(task, call);
    const fs::path& folder = call.folder;
    std::error_code error;
    fs::create_directories(folder.parent_path(), error);
    if (error) throw OutputError(text(folder.parent_path().string(), ": cannot be created: ", error.message()));
    const bool made = fs::create_directory(folder, error);
    if (error) throw OutputError(text(folder.string(), ": cannot be created: ", error.message()));
    return made;
}

Call fresh_place(const Task& task, int number) {
    for (;; ++number) {
        const Call call = place(task, number);
        if (take_place(task, call)) return call;
        if (task.wanted != Wanted::gradients && !task.command.may_follow_others)
            throw OutputError(
                text(call.folder.string(), ": exists already; the folder of an evaluation must be fresh"));
    }
}

fs::path find_folder_of_values(const ExternalCommand& command, const QuantityRequest& request) {
    const Task task{command, request, Wanted::values};
    const std::string surface = handed_over_bytes(request.surface, command.format, command.points.get());
    fs::path found;
    for (int k = 1;; ++k) {
        const Call call = place(task, k);
        if (!is_taken(task, call)) return found;
        if (holds(call.request, request_text(task, call)) && holds(call.surface, surface) && has_values(task, call))
            found = call.folder;
    }
}

}  // namespace strake
