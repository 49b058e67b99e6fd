#include "objectives/external/external.hpp"

#include "core/error.hpp"
#include "core/text/file.hpp"
#include "objectives/external/hand_over.hpp"
#include "objectives/external/handed_over.hpp"
#include "objectives/external/process.hpp"
#include "objectives/external/refused.hpp"
#include "objectives/external/run_attempts.hpp"
#include "objectives/quantity/finite.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

namespace strake {
namespace {

/// Placeholders in one argument.
std::vector<std::string> words_in_braces(const std::string& argument) {
    std::vector<std::string> words;
    for (std::size_t open = argument.find('{'); open != std::string::npos; open = argument.find('{', open + 1)) {
        const std::size_t close = argument.find_first_not_of("abcdefghijklmnopqrstuvwxyz_", open + 1);
        if (close != std::string::npos && argument[close] == '}')
            words.push_back(argument.substr(open + 1, close - open - 1));
    }
    return words;
}

/// Other programs use braces too: refuses only likely misspellings of our placeholders.
void check_replaced_words(const ExternalCommand& command, const std::vector<std::string>& words) {
    for (const std::string& argument : words)
        for (const std::string& word : words_in_braces(argument))
            for (const std::string known : replaced_words)
                if (std::find(replaced_words.begin(), replaced_words.end(), word) == replaced_words.end() &&
                    similar(known, word))
                    throw InvalidInput(text(command.name, ": unknown word {", word, "} in '", argument,
                                            "'; did you mean {", known, "}?"));
}

/// Throws InvalidInput with the command's name before the message.
struct Refusal {
    const std::string& name;
    template <class... T>
    [[noreturn]] void operator()(const T&... parts) const {
        throw InvalidInput(text(name, ": ", parts...));
    }
    void unless_positive(const char* what, double value, const char* unit = "") const {
        if (!(value > 0) || !std::isfinite(value)) (*this)(what, " = ", value, unit, " must be > 0");
    }
    void unless_nonnegative(const char* what, double value, const char* unit = "") const {
        if (!(value >= 0) || !std::isfinite(value)) (*this)(what, " = ", value, unit, " must be >= 0");
    }
};

void validate_arguments(const ExternalCommand& command, const Refusal& refuse) {
    if (command.command.empty() || command.command.front().empty()) refuse("command is empty, must name a program");
    if (!command.gradient_command.empty() && command.gradient_command.front().empty())
        refuse("gradient_command must name a program");
    for (const auto* words : {&command.command, &command.gradient_command})
        for (const std::string& argument : *words)
            if (argument.find('\0') != std::string::npos) refuse("an argument of the command holds a NUL byte");
}

void validate_numbers(const ExternalCommand& command, const Refusal& refuse) {
    if (command.gradient_timeout_s) refuse.unless_positive("gradient_timeout", *command.gradient_timeout_s, " s");
    refuse.unless_positive("timeout", command.timeout_s, " s");
    refuse.unless_nonnegative("grace", command.grace_s, " s");
    refuse.unless_positive("diagonal", command.diagonal);
    if (command.retries < 0) refuse("retries = ", command.retries, " must be >= 0");
    refuse.unless_nonnegative("pause", command.pause_s, " s");
}

void validate_values(const ExternalCommand& command, const Refusal& refuse) {
    if (command.value_after_failure && !std::isfinite(*command.value_after_failure))
        refuse("on_failure.value = ", *command.value_after_failure, " must be finite");
    if (command.value_after_failure && command.has_gradients)
        refuse("on_failure.value has no gradient; use it only with a program that gives none");
    std::set<std::string> seen;
    for (const std::string& name : command.outputs)
        if (name.empty() || !seen.insert(name).second) refuse("outputs names '", name, "' twice or without letters");
}

void validate(const ExternalCommand& command) {
    const Refusal refuse{command.name};
    if (command.name.empty()) throw InvalidInput("an external quantity needs a name");
    if (command.own_folder &&
        (command.name == "." || command.name == ".." || command.name.find('/') != std::string::npos))
        refuse("the name cannot be that of a folder");
    validate_arguments(command, refuse);
    validate_numbers(command, refuse);
    validate_values(command, refuse);
    check_hand_over_format(command.format);
    if (command.parallel < 1) refuse("parallel = ", command.parallel, " must be >= 1");
    if (!(command.poll_s > 0)) refuse("poll = ", command.poll_s, " s must be > 0");
    if (!(command.queue_s > 0)) refuse("queue = ", command.queue_s, " s must be > 0");
    check_replaced_words(command, command.command);
    check_replaced_words(command, command.gradient_command);
}

QuantityResult evaluate(const ExternalCommand& command, SlurmQueue* queue, const QuantityRequest& request) {
    if (auto failure = vertices_finite(command.name, request.surface)) return {{}, {}, failure};
    const bool gradients = request.want_sensitivities && command.has_gradients;
    const bool apart = gradients && !command.gradient_command.empty();
    QuantityResult result =
        run_attempts({command, request, gradients && !apart ? Wanted::values_and_gradients : Wanted::values}, queue);
    if (result.failure && command.value_after_failure) {
        result.remarks.push_back(
            text(headline(*result.failure), "; ", *command.value_after_failure, " is used instead"));
        result.failure.reset();
        result.values.assign(value_keys(command).size(), *command.value_after_failure);
        result.is_substitute = true;
    }
    if (result.failure || !apart) return result;
    QuantityResult found = gradients_of(command, queue, request);
    found.values = found.failure ? std::vector<double>() : result.values;
    found.remarks.insert(found.remarks.begin(), result.remarks.begin(), result.remarks.end());
    return found;
}

/// The arguments as written in the case.
std::string identity(const ExternalCommand& command) {
    std::string words = command.format;
    for (const std::string& argument : command.command) words.append(1, '\0').append(argument);
    for (const std::string& argument : command.gradient_command) words.append("\0gradient ", 10).append(argument);
    return words;
}

/// The same plus everything that determines the answers: names, and the current contents of the program and the named
/// files.
std::string cache_key(const ExternalCommand& command) {
    std::string key = identity(command) + '\0' + command.units;
    for (const std::string& name : command.outputs) key += '\0' + name;
    if (command.depends_on)
        for (const std::string& name : *command.depends_on) key += '\0' + ("by " + name);
    if (command.points) key += '\0' + command.points->origin;
    std::vector<std::filesystem::path> files = command.files;
    for (const Wanted wanted : {Wanted::values, Wanted::gradients}) {
        if (wanted == Wanted::gradients && command.gradient_command.empty()) continue;
        const std::string program = arguments_of(command, Call{wanted}).front();
        std::error_code ignored;
        if (program.find('/') != std::string::npos && std::filesystem::is_regular_file(program, ignored))
            files.push_back(program);
    }
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
    for (const Wanted wanted : {Wanted::values, Wanted::gradients}) {
        const bool is_gradient = wanted == Wanted::gradients;
        const auto& words = is_gradient ? command.gradient_command : command.command;
        if (words.empty()) continue;
        const std::string& written = words.front();
        if (!words_in_braces(written).empty() && written.find("{case_dir}") == std::string::npos)
            continue;  // a program in the evaluation's folder, which does not exist yet
        try {
            find_program(arguments_of(command, Call{wanted}).front());
            if (command.slurm)
                for (const char* client : {"sbatch", "squeue", "scancel"}) find_program(client);
        } catch (const Refused& refused) {
            return Failure{refused.failure.kind,
                           text(command.name, is_gradient ? " (gradient_command)" : "", ": ", refused.failure.message)};
        }
    }
    return {};
}

Quantity external(const ExternalCommand& command) {
    validate(command);
    Quantity quantity;
    if (command.outputs.empty())
        quantity.names = {command.name};
    else
        for (const std::string& value : command.outputs) quantity.names.push_back(command.name + "." + value);
    std::shared_ptr<SlurmQueue> queue;
    if (command.slurm) queue = std::make_shared<SlurmQueue>(command.poll_s);
    quantity.evaluate = [command, queue](const QuantityRequest& request) {
        return evaluate(command, queue.get(), request);
    };
    if (command.has_gradients && !command.gradient_command.empty())
        quantity.differentiate = [command, queue](const QuantityRequest& request) {
            return gradients_of(command, queue.get(), request);
        };
    quantity.parallel = command.parallel;
    quantity.has_sensitivities = command.has_gradients;
    quantity.program = identity(command);
    quantity.cache = command.cache;
    if (!command.cache.empty()) quantity.cache_key = cache_key(command);
    return quantity;
}

}  // namespace strake
