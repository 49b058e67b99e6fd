#pragma once
#include <algorithm>
#include <numeric>
#include <vector>

namespace strake {

/// Classes of the numbers 0 to count - 1, joined pair by pair. The root of a class is its smallest number.
class DisjointSets {
public:
    explicit DisjointSets(int count) : up_(static_cast<std::size_t>(count)) { std::iota(up_.begin(), up_.end(), 0); }
    int root(int i) {
        while (up_[i] != i) i = up_[i] = up_[up_[i]];
        return i;
    }
    void join(int i, int j) {
        i = root(i), j = root(j);
        up_[std::max(i, j)] = std::min(i, j);
    }

private:
    std::vector<int> up_;
};

}  // namespace strake
