#include "cases/schema_parts.hpp"

namespace strake {

const std::vector<Key>& schema() {
    static const std::vector<Key> keys = [] {
        std::vector<Key> all;
        for (const auto& part : {surface_keys(), shell_keys(), parameter_keys(), goal_keys(), run_keys()})
            all.insert(all.end(), part.begin(), part.end());
        return all;
    }();
    return keys;
}

}  // namespace strake
