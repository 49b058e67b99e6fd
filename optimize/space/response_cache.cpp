#include "optimize/space/response_cache.hpp"

namespace strake {

void ResponseCache::use(const std::vector<int>& pin) {
    if (pin == pin_) return;
    pin_ = pin;
    columns_.clear();
}

const ResponseCache::Column* ResponseCache::find(const std::string& key) const {
    const auto at = columns_.find(key);
    return at == columns_.end() ? nullptr : &at->second;
}

}  // namespace strake
