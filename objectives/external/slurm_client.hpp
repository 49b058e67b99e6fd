#pragma once
#include "objectives/external/process.hpp"

namespace strake {

/// What a client of Slurm printed, or why it did not end well.
struct ClientOutput {
    bool is_done = false;
    std::string words;
};

/// Runs it within a minute. @param scratch folder in which files may be made meanwhile. @throws OutputError.
ClientOutput slurm_client(const std::vector<std::string>& arguments, const std::filesystem::path& scratch);

}  // namespace strake
