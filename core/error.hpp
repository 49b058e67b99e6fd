#pragma once
#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>

/// Typed errors of the whole project. The command line maps each to an exit status.
namespace strake {

/// The caller broke a precondition (bad option, open mesh where a closed one is needed).
struct InvalidInput : std::invalid_argument {
    using invalid_argument::invalid_argument;
};

/// A surface file is missing, unreadable or wrong; the text starts with `path:line:` (text formats)
/// or names the byte or element (binary formats).
struct InputError : std::runtime_error {
    using runtime_error::runtime_error;
};

/// A file or folder cannot be written; the text names the path and the system's reason.
struct OutputError : std::runtime_error {
    using runtime_error::runtime_error;
};

/// A linear system or an external solver failed; the text says which one and in what state.
struct SolverError : std::runtime_error {
    using runtime_error::runtime_error;
};

/// Joins its arguments to one string, in the classic locale whatever the program's is. (GCC 12 has no `format`.)
template <class... T>
std::string text(const T&... parts) {
    std::ostringstream s;
    s.imbue(std::locale::classic());  // the global one may write 1.234,5
    s.precision(10);
    (s << ... << parts);
    return s.str();
}

}  // namespace strake
