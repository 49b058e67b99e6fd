#pragma once
#include <exception>
#include <string>

namespace strake::cli {

struct ProgramEnd {
    int status = 0;
    std::string message;  ///< for stderr, without the end of line; may be empty
};

/// Exit status and words for what a command has thrown. The words are ours, never those of the C++ library.
ProgramEnd end_of(const std::exception_ptr& thrown);

}  // namespace strake::cli
