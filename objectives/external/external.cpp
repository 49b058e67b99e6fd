#include "objectives/external/external.hpp"

#include "core/error.hpp"
#include "core/mesh/io.hpp"
#include "objectives/external/gradient.hpp"
#include "objectives/external/handed_over.hpp"
#include "objectives/external/process.hpp"
#include "objectives/external/refused.hpp"
#include "objectives/external/result.hpp"
#include "objectives/finite.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

namespace strake {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t result_limit = std::size_t{16} << 20;
constexpr double match_rel = 1e-5;  // of the diagonal, DESIGN section 7

constexpr std::array<const char*, 5> replaced_words{"surface", "request", "result", "folder", "case_dir"};

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
    check_replaced_words(command);
}

struct Call {
    fs::path folder, surface, request, result;
};

/// Each word in braces replaced within its own argument, once: what is put in is not looked at again.
std::string replaced(const std::string& argument, const Call& call, const ExternalCommand& command) {
    const std::array<std::string, 5> values{call.surface.string(), call.request.string(), call.result.string(),
                                            call.folder.string(), fs::absolute(command.case_dir).string()};
    std::string done;
    for (std::size_t at = 0; at < argument.size();) {
        std::size_t k = 0, length = 0;
        for (; argument[at] == '{' && k < replaced_words.size(); ++k) {
            const std::string key = text("{", replaced_words[k], "}");
            if (argument.compare(at, key.size(), key) != 0) continue;
            length = key.size();
            break;
        }
        done += length > 0 ? values[k] : argument.substr(at, 1);
        at += std::max<std::size_t>(length, 1);
    }
    return done;
}

/// A path that contains '/' is relative to the case file; a plain name is looked up on PATH.
std::string program_of(const ExternalCommand& command, const std::string& argument) {
    if (argument.find('/') == std::string::npos) return argument;
    return (fs::absolute(command.case_dir) / argument).lexically_normal().string();
}

/// An attempt never gets a folder that another has had: what that one still writes must not be taken for its result.
Call fresh_folder(const ExternalCommand& command, int evaluation, int attempt) {
    if (evaluation < 0) throw InvalidInput(text(command.name, ": evaluation = ", evaluation, " must be >= 0"));
    char number[16];
    std::snprintf(number, sizeof number, "%06d", evaluation);
    fs::path first = fs::absolute(command.evaluations_dir).lexically_normal() / number;
    if (command.own_folder) first /= command.name;
    Call call;
    std::error_code error;
    fs::create_directories(first.parent_path(), error);
    if (error) throw OutputError(text(first.parent_path().string(), ": cannot be created: ", error.message()));
    for (;; ++attempt) {
        call.folder = first;
        if (attempt > 1) call.folder += text("-", attempt);
        if (fs::create_directory(call.folder, error)) break;
        if (error) throw OutputError(text(call.folder.string(), ": cannot be created: ", error.message()));
        if (!command.may_follow_others)
            throw OutputError(
                text(call.folder.string(), ": exists already; the folder of an evaluation must be fresh"));
    }
    call.surface = call.folder / ("surface" + extension_of(format_named(command.format)));
    call.request = call.folder / "request.json";
    call.result = call.folder / "result.json";
    return call;
}

std::vector<std::string> value_keys(const ExternalCommand& command) {
    return command.gives.empty() ? std::vector<std::string>{"value"} : command.gives;
}

/// Own variables by which the values have to be differentiated.
std::vector<std::string> wanted_variables(const ExternalCommand& command, const QuantityRequest& request) {
    std::vector<std::string> names;
    for (const auto& [name, value] : request.own)
        if (!command.depends_on ||
            std::find(command.depends_on->begin(), command.depends_on->end(), name) != command.depends_on->end())
            names.push_back(name);
    return names;
}

std::string request_json(const ExternalCommand& command, const QuantityRequest& request, const Call& call,
                         bool want_gradients) {
    using json = nlohmann::ordered_json;
    json variables = json::object();
    for (const auto* list : {&request.own, &request.variables})
        for (const auto& [name, value] : *list) {
            if (!std::isfinite(value)) throw InvalidInput(text(command.name, ": variable ", name, " = ", value));
            variables[name] = value;
        }
    json wanted = json::object();
    wanted["values"] = value_keys(command);
    wanted["gradients"] = want_gradients ? value_keys(command) : std::vector<std::string>{};
    wanted["variables"] = want_gradients ? wanted_variables(command, request) : std::vector<std::string>{};
    json file = json::object();
    file["quantity"] = command.name;
    file["evaluation"] = request.evaluation;
    file["level"] = request.level;
    file["wanted"] = wanted;
    file["surface"] = call.surface.filename().string();
    file["result"] = call.result.filename().string();
    file["vertices"] = request.surface.num_vertices();
    file["triangles"] = request.surface.num_triangles();
    file["units"] = {{"length", command.units}, {"angle", "rad"}};
    file["variables"] = variables;
    return file.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

QuantityResult read_results(const ExternalCommand& command, const QuantityRequest& request, const Call& call,
                            bool want_gradients) {
    QuantityResult result;
    const std::string bytes = read_handed_over(call.folder, call.result.filename().string(), result_limit);
    const std::vector<std::string> by = wanted_variables(command, request);
    const ProgramResult found = parse_result(bytes, command.gives, want_gradients, by, command.may_lack_derivatives);
    const std::size_t gradient_limit = result_limit + 1024 * static_cast<std::size_t>(request.surface.num_vertices());
    for (const std::string& file : found.gradient_files)
        result.dJ_dv.push_back(parse_gradient(read_handed_over(call.folder, file, gradient_limit), file,
                                              request.surface, match_rel * command.diagonal));
    for (const std::vector<double>& derivatives : found.by_variable) {
        Eigen::VectorXd& all = result.dJ_down.emplace_back(Eigen::VectorXd::Zero(static_cast<int>(request.own.size())));
        for (std::size_t j = 0, k = 0; j < request.own.size() && k < by.size(); ++j)
            if (request.own[j].first == by[k]) all[static_cast<int>(j)] = derivatives[k++];
    }
    result.values = found.values;
    return result;
}

QuantityResult attempt(const ExternalCommand& command, const QuantityRequest& request, int number) {
    const bool want_gradients = request.want_sensitivities && command.has_gradients;
    const Call call = fresh_folder(command, request.evaluation, number);
    write_surface(call.surface, request.surface, format_named(command.format));
    write_atomically(call.request, request_json(command, request, call, want_gradients));

    ProcessCommand process;
    for (const std::string& argument : command.command) process.arguments.push_back(replaced(argument, call, command));
    process.arguments.front() = program_of(command, process.arguments.front());
    process.folder = call.folder;
    process.timeout_s = command.timeout_s;
    process.grace_s = command.grace_s;
    process.stop_wanted = request.stop_wanted;
    const ProcessEnd end = run_process(process);
    if (end.failure && end.failure->kind == "interrupted") throw Interrupted{};

    Failure failure;
    try {
        if (end.failure) throw Refused{*end.failure};
        return read_results(command, request, call, want_gradients);
    } catch (const Refused& refused) {
        failure = refused.failure;
    }
    failure.message =
        text(command.name, ", evaluation ", request.evaluation, ": ", failure.message, "\n  in ", call.folder.string());
    if (!end.last_lines.empty()) failure.message += "\n  the program's last lines:\n" + end.last_lines;
    return {{}, {}, failure};
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

QuantityResult evaluate(const ExternalCommand& command, const QuantityRequest& request) {
    if (auto failure = vertices_finite(command.name, request.surface)) return {{}, {}, failure};
    std::vector<std::string> remarks;
    QuantityResult result;
    const int attempts = 1 + command.retries;
    for (int k = 1; k <= attempts; ++k) {
        if (k > 1) pause_before(command, request, k);
        result = attempt(command, request, k);
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

}  // namespace

std::optional<Failure> check_program(const ExternalCommand& command) {
    validate(command);
    const Call nowhere;
    if (replaced(command.command.front(), nowhere, command) != command.command.front() &&
        command.command.front().find("{case_dir}") == std::string::npos)
        return {};  // a program in the evaluation's folder: there is none yet
    try {
        find_program(program_of(command, replaced(command.command.front(), nowhere, command)));
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
    quantity.evaluate = [command](const QuantityRequest& request) { return evaluate(command, request); };
    quantity.has_sensitivities = command.has_gradients;
    quantity.program = identity(command);
    return quantity;
}

}  // namespace strake
