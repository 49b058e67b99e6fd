#pragma once
#include <string>

/// Words of command lines, as a shell reads them.
namespace strake {

/// In single quotes, for scripts: a POSIX shell reads back the very bytes, whatever they are.
std::string shell_word(const std::string& word);

/// A path as a person would type it: bare where that is the same to every shell, else quoted; invisible characters are
/// escaped ($'\n', which bash, zsh and ksh read back). A path that begins with a dash gets ./ before it, or it would be
/// an option.
std::string typed_path(const std::string& path);

}  // namespace strake
