#include "objectives/external/external.hpp"

#include "core/error.hpp"
#include "core/mesh/file.hpp"
#include "core/mesh/io.hpp"
#include "objectives/external/attempt.hpp"
#include "objectives/external/by_hand.hpp"
#include "objectives/external/handed_over.hpp"
#include "objectives/external/job.hpp"
#include "objectives/external/process.hpp"
#include "objectives/external/refused.hpp"
#include "objectives/finite.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <set>
#include <thread>

namespace strake {
namespace {

/// The words between braces in one argument.
std::vector<std::string> words_in_braces(const std::string& argument) {
    std::vector<std::string> words;
    for (std::size_t open = argument.find('{'); open != std::string::npos; open = argument.find('{', open + 1)) {
        const std::size_t close = argument.find_first_not_of("abcdefghijklmnopqrstuvwxyz_", open + 1);
        if (close != std::string::npos && argument[close] == '}')
            words.push_back(argument.substr(open + 1, close - open - 1));
    }
    return words;
}

/// Braces mean something to other programs too, so only what looks like a misspelt word of ours is refused.
void check_replaced_words(const ExternalCommand& command) {
    for (const std::string& argument : command.command)
        for (const std::string& word : words_in_braces(argument))
            for (const std::string known : replaced_words)
                if (std::find(replaced_words.begin(), replaced_words.end(), word) == replaced_words.end() &&
                    similar(known, word))
                    throw InvalidInput(text(command.name, ": unknown word {", word, "} in '", argument,
                                            "'; did you mean {", known, "}?"));
}

void validate(const ExternalCommand& command) {
    const auto refuse = [&](const auto&... parts) { throw InvalidInput(text(command.name, ": ", parts...)); };
    if (command.name.empty()) throw InvalidInput("an external quantity needs a name");
    if (command.own_folder &&
        (command.name == "." || command.name == ".." || command.name.find('/') != std::string::npos))
        refuse("the name cannot be that of a folder");
    if (command.command.empty() || command.command.front().empty()) refuse("command is empty, must name a program");
    for (const std::string& argument : command.command)
        if (argument.find('\0') != std::string::npos) refuse("an argument of the command holds a NUL byte");
    if (!(command.timeout_s > 0) || !std::isfinite(command.timeout_s))
        refuse("timeout = ", command.timeout_s, " s must be > 0");
    if (!(command.grace_s >= 0) || !std::isfinite(command.grace_s))
        refuse("grace = ", command.grace_s, " s must be >= 0");
    if (!(command.diagonal > 0) || !std::isfinite(command.diagonal))
        refuse("diagonal = ", command.diagonal, " must be > 0");
    if (command.retries < 0) refuse("retries = ", command.retries, " must be >= 0");
    if (!(command.pause_s >= 0) || !std::isfinite(command.pause_s))
        refuse("pause = ", command.pause_s, " s must be >= 0");
    if (command.value_after_failure && !std::isfinite(*command.value_after_failure))
        refuse("on_failure.value = ", *command.value_after_failure, " must be finite");
    if (command.value_after_failure && command.has_gradients)
        refuse("on_failure.value has no gradient, so that it goes only with a program that gives none");
    std::set<std::string> seen;
    for (const std::string& name : command.gives)
        if (name.empty() || !seen.insert(name).second) refuse("gives names '", name, "' twice or without letters");
    format_named(command.format);
    if (command.parallel < 1) refuse("parallel = ", command.parallel, " must be >= 1");
    if (!(command.queue_s > 0)) refuse("queue = ", command.queue_s, " s must be > 0");
    check_replaced_words(command);
}

/// A process of our own.
QuantityResult attempt(const ExternalCommand& command, const QuantityRequest& request, int number) {
    const bool want_gradients = request.want_sensitivities && command.has_gradients;
    const Call call = fresh_call(command, request.evaluation, number);
    hand_over(command, request, call, want_gradients);
    ProcessCommand process;
    process.arguments = arguments_of(command, call);
    process.folder = call.folder;
    process.timeout_s = command.timeout_s;
    process.grace_s = command.grace_s;
    process.stop_wanted = request.stop_wanted;
    const ProcessEnd end = run_process(process);
    if (end.failure && end.failure->kind == "interrupted") throw Interrupted{};
    try {
        if (end.failure) throw Refused{*end.failure};
        return read_results(command, request, call, want_gradients);
    } catch (const Refused& refused) {
        return failed(command, request, call, refused.failure, end.last_lines);
    }
}

void pause_before(const ExternalCommand& command, const QuantityRequest& request, int attempt) {
    const double seconds = std::min(10.0, std::ldexp(command.pause_s, std::min(attempt - 2, 20)));
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    do {
        if (request.stop_wanted && request.stop_wanted()) throw Interrupted{};
        std::this_thread::sleep_for(std::chrono::duration<double>(std::min(seconds, 0.02)));
    } while (std::chrono::steady_clock::now() < until);
}

/// The first line of a failure's message; the others name its folder and its log.
std::string headline(const Failure& failure) {
    return text(failure.kind, ": ", failure.message.substr(0, failure.message.find('\n')));
}

QuantityResult evaluate(const ExternalCommand& command, SlurmQueue* queue, const QuantityRequest& request) {
    if (auto failure = vertices_finite(command.name, request.surface)) return {{}, {}, failure};
    std::vector<std::string> remarks;
    QuantityResult result;
    const int attempts = 1 + command.retries;
    for (int k = 1; k <= attempts; ++k) {
        if (k > 1 && !command.by_hand) pause_before(command, request, k);
        result = command.by_hand ? attempt_by_hand(command, request, k)
                 : queue         ? attempt_as_job(command, *queue, request, k)
                                 : attempt(command, request, k);
        if (!result.failure || result.failure->kind == "spawn") break;
        if (k < attempts)
            remarks.push_back(text(headline(*result.failure), "; attempt ", k + 1, " of ", attempts, " follows"));
    }
    if (result.failure && command.retries > 0 && result.failure->kind != "spawn")
        result.failure->message += text("\n  ", attempts, " attempts failed");
    if (result.failure && command.value_after_failure) {
        remarks.push_back(text(headline(*result.failure), "; ", *command.value_after_failure, " stands for it"));
        result = {};
        result.values.assign(value_keys(command).size(), *command.value_after_failure);
        result.stands_for_failure = true;
    }
    result.remarks = std::move(remarks);
    return result;
}

/// Its arguments as they are written in the case.
std::string identity(const ExternalCommand& command) {
    std::string words = command.format;
    for (const std::string& argument : command.command) words.append(1, '\0').append(argument);
    return words;
}

/// The same with all that decides what it answers: names, and what the program and the named files hold now.
std::string cache_key(const ExternalCommand& command) {
    std::string key = identity(command) + '\0' + command.units;
    for (const std::string& name : command.gives) key += '\0' + name;
    if (command.depends_on)
        for (const std::string& name : *command.depends_on) key += '\0' + ("by " + name);
    std::vector<std::filesystem::path> files = command.files;
    const std::string program = arguments_of(command, Call{}).front();
    std::error_code ignored;
    if (program.find('/') != std::string::npos && std::filesystem::is_regular_file(program, ignored))
        files.push_back(program);
    for (const std::filesystem::path& file : files) {
        const std::string bytes = read_bytes(file);
        key += text('\0', bytes.size(), '\0') + bytes;
    }
    return key;
}

}  // namespace

std::optional<Failure> check_program(const ExternalCommand& command) {
    validate(command);
    if (command.by_hand) return {};
    const std::string written = command.command.front(), found = arguments_of(command, Call{}).front();
    if (written.find('{') != std::string::npos && written.find("{case_dir}") == std::string::npos &&
        !words_in_braces(written).empty())
        return {};  // a program in the evaluation's folder: there is none yet
    try {
        find_program(found);
        if (command.slurm)
            for (const char* client : {"sbatch", "squeue", "scancel"}) find_program(client);
    } catch (const Refused& refused) {
        return Failure{refused.failure.kind, text(command.name, ": ", refused.failure.message)};
    }
    return {};
}

Quantity external(const ExternalCommand& command) {
    validate(command);
    Quantity quantity;
    if (command.gives.empty())
        quantity.names = {command.name};
    else
        for (const std::string& value : command.gives) quantity.names.push_back(command.name + "." + value);
    std::shared_ptr<SlurmQueue> queue;
    if (command.slurm) queue = std::make_shared<SlurmQueue>();
    quantity.evaluate = [command, queue](const QuantityRequest& request) {
        return evaluate(command, queue.get(), request);
    };
    quantity.parallel = command.parallel;
    quantity.has_sensitivities = command.has_gradients;
    quantity.program = identity(command);
    quantity.cache = command.cache;
    if (!command.cache.empty()) quantity.cache_key = cache_key(command);
    return quantity;
}

}  // namespace strake
