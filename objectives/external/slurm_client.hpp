#pragma once
#include "objectives/external/process.hpp"

namespace strake {

/// Output of a Slurm client, or why it failed.
struct ClientOutput {
    bool is_done = false;
    std::string words;
};

/// Runs it for at most a minute. @param scratch folder for temporary files @throws OutputError.
ClientOutput slurm_client(const std::vector<std::string>& arguments, const std::filesystem::path& scratch);

}  // namespace strake
