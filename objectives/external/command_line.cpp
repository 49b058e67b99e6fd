#include "core/error.hpp"
#include "core/text/shell_word.hpp"
#include "objectives/external/attempt.hpp"

#include <algorithm>

/// Command lines: arguments with placeholders replaced, and shell lines.
namespace strake {
namespace {

namespace fs = std::filesystem;

/// Replaces each placeholder once within its own argument; replaced text is not scanned again.
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

}  // namespace

std::vector<std::string> arguments_of(const ExternalCommand& command, const Call& call) {
    const auto& words = call.wanted == Wanted::gradients ? command.gradient_command : command.command;
    std::vector<std::string> arguments;
    for (const std::string& argument : words) arguments.push_back(replaced(argument, call, command));
    std::string& program = arguments.front();  // a plain name is looked up on PATH
    if (program.find('/') != std::string::npos)
        program = (fs::absolute(command.case_dir) / program).lexically_normal().string();
    return arguments;
}

double timeout_of(const ExternalCommand& command, const Call& call) {
    return call.wanted == Wanted::gradients ? command.gradient_timeout_s.value_or(command.timeout_s)
                                            : command.timeout_s;
}

std::string shell_line(const ExternalCommand& command, const Call& call) {
    std::string line;
    for (const std::string& argument : arguments_of(command, call)) line += shell_word(argument) + " ";
    return text(line, "> ", call.prefix, "stdout.log 2> ", call.prefix, "stderr.log < /dev/null");
}

}  // namespace strake
