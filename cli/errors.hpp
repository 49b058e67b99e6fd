#pragma once
#include <exception>
#include <string>

namespace strake::cli {

struct ProgramEnd {
    int status = 0;
    std::string message;  ///< for stderr, without the end of line; may be empty
};

/// Exit status and message for what a command has thrown. The message is ours, never that of the C++ library.
ProgramEnd end_of(const std::exception_ptr& thrown);

}  // namespace strake::cli
