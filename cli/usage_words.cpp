#include "casefile/schema/explain.hpp"
#include "casefile/yaml/diagnostics.hpp"
#include "cli/command_table.hpp"

#include <fmt/format.h>

namespace strake::cli {
namespace {

std::string suggestion(const std::string& word, const std::vector<std::string>& candidates) {
    const std::string near = nearest(word, candidates);
    return near.empty() ? "" : fmt::format("; did you mean '{}'?", near);
}

std::string unknown_command(const std::string& word, const std::vector<CommandRow>& table) {
    std::vector<std::string> names;
    for (const CommandRow& command : table) names.push_back(command.name);
    const std::string near = suggestion(word, names);
    return fmt::format("strake: unknown command '{}'{}", printable(word, 100),
                       near.empty() ? "; commands: " + joined(names) : near);
}

/// "--evaluations" of a command that takes --set: the key of the case that ends like it, the shortest one; empty: none.
std::string setting_for(const std::string& word, const std::vector<std::string>& options) {
    if (!word.starts_with("--") || std::find(options.begin(), options.end(), "--set") == options.end()) return "";
    std::string key = word.substr(2), best;
    std::replace(key.begin(), key.end(), '-', '_');
    for (const std::string& path : key_paths()) {
        const bool is_plain = path.find_first_of("*[") == std::string::npos;
        if (is_plain && path.ends_with("." + key) && (best.empty() || path.size() < best.size())) best = path;
    }
    return best.empty() ? "" : fmt::format("; the key of the case is set by --set {}=VALUE", best);
}

/// The first argument that looks like an option but is not one of the command.
std::string unknown_option(const CommandRow& command, const std::vector<std::string>& arguments, std::size_t from) {
    std::vector<std::string> names;
    for (const OptionRow& option : command.options)
        if (!option.is_positional) names.insert(names.end(), option.names.begin(), option.names.end());
    for (std::size_t i = from; i < arguments.size() && arguments[i] != "--"; ++i) {
        const std::string word = arguments[i].substr(0, arguments[i].find('='));
        if (word.size() < 2 || word[0] != '-' || (word[1] >= '0' && word[1] <= '9') || word[1] == '.') continue;
        bool known = std::find(names.begin(), names.end(), word) != names.end();
        if (!word.starts_with("--")) known |= std::find(names.begin(), names.end(), word.substr(0, 2)) != names.end();
        if (known) continue;
        const std::string setting = setting_for(word, names);
        return fmt::format("strake: {}: unknown option '{}'{}", command.name, printable(word, 100),
                           setting.empty() ? suggestion(word, names) : setting);
    }
    return "";
}

std::string needs_a_value(const CommandRow& command, const OptionRow& option, const std::string& name) {
    return fmt::format("strake: {}: {} needs a value: {}", command.name, name, option.doc);
}

/// The parser takes whatever follows an option as its value, even another option, which it then misses.
std::string swallowed_option(const CommandRow& command, const std::vector<std::string>& arguments) {
    const auto option_of = [&](const std::string& word) {
        return std::find_if(command.options.begin(), command.options.end(), [&](const OptionRow& option) {
            return !option.is_positional &&
                   std::find(option.names.begin(), option.names.end(), word) != option.names.end();
        });
    };
    for (std::size_t i = 1; i + 1 < arguments.size() && arguments[i] != "--"; ++i) {
        const auto option = option_of(arguments[i]);
        if (option != command.options.end() && option->takes_value &&
            option_of(arguments[i + 1]) != command.options.end())
            return needs_a_value(command, *option, arguments[i]);
    }
    return "";
}

std::string positionals(const CommandRow& command) {
    std::string out;
    for (const OptionRow& option : command.options)
        if (option.is_positional) out += " " + (option.required ? option.names[0] : "[" + option.names[0] + "]");
    return out;
}

/// "--level: 3x" and the like of the parser, in our form.
std::string other_words(const CommandRow& command, const CLI::ParseError& error) {
    std::string words = error.what();
    for (const OptionRow& option : command.options) {
        const std::string& name = option.names.back();
        if (words == name + " is required")
            return option.is_positional ? fmt::format("strake: {}: {} is missing: {}", command.name, name, option.doc)
                                        : fmt::format("strake: {}: {} is required: {}", command.name, name, option.doc);
    }
    for (const OptionRow& option : command.options)
        for (const std::string& name : option.names) {
            if (words.starts_with(name + ": At Most ") || words.starts_with(name + ": 1 required but received"))
                return fmt::format("strake: {}: {} may be given only once", command.name, name);
            if (words.starts_with(name + ": 1 required")) return needs_a_value(command, option, name);
        }
    const std::string not_expected = words.substr(words.rfind(' ') + 1);
    if (words.starts_with("The following argument"))
        return fmt::format("strake: {}: unexpected argument '{}'", command.name, printable(not_expected, 100));
    const std::string unreadable = "Could not convert: ";
    if (words.starts_with(unreadable))
        return fmt::format("strake: {}: {} must be a number", command.name,
                           printable(words.substr(unreadable.size()), 200));
    return fmt::format("strake: {}: {}", command.name, printable(words, 300));
}

}  // namespace

std::string usage_words(const CLI::App& app, const CLI::ParseError& error, const std::vector<std::string>& arguments) {
    const std::vector<CommandRow> table = command_table(app);
    if (arguments.empty()) return app.help();
    if (arguments[0].starts_with("-"))
        return fmt::format("strake: unknown option '{}'{}\nsee `strake --help`", printable(arguments[0], 100),
                           suggestion(arguments[0], {"--help", "--version"}));
    const auto command =
        std::find_if(table.begin(), table.end(), [&](const CommandRow& row) { return row.name == arguments[0]; });
    if (command == table.end()) return unknown_command(arguments[0], table) + "\nsee `strake --help`";
    std::string words = unknown_option(*command, arguments, 1);
    if (words.empty()) words = swallowed_option(*command, arguments);
    if (words.empty()) words = other_words(*command, error);
    return fmt::format("{}\nusage: strake {}{} [OPTIONS]; see `strake {} --help`", words, command->name,
                       positionals(*command), command->name);
}

}  // namespace strake::cli
