#include "cli/outputs.hpp"

#include "core/error.hpp"

namespace strake::cli {
namespace {

namespace fs = std::filesystem;

bool is_same(const fs::path& a, const fs::path& b) {
    std::error_code failed;
    if (fs::equivalent(a, b, failed) && !failed) return true;
    const fs::path one = fs::weakly_canonical(a, failed), other = fs::weakly_canonical(b, failed);
    return !failed && one == other;
}

}  // namespace

void check_outputs(const std::vector<fs::path>& outputs, const std::vector<fs::path>& inputs) {
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        if (outputs[i].empty()) continue;
        for (const fs::path& input : inputs)
            if (is_same(outputs[i], input))
                throw InvalidInput(text(outputs[i].string(), ": would overwrite what is read; choose another output"));
        for (std::size_t j = 0; j < i; ++j)
            if (!outputs[j].empty() && is_same(outputs[i], outputs[j]))
                throw InvalidInput(text(outputs[i].string(), ": two outputs of the same name"));
    }
}

}  // namespace strake::cli
