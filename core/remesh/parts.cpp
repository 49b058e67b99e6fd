#include "core/remesh/passes.hpp"

#include <thread>

namespace strake {

void in_parts(int n, int threads, const std::function<void(int, int)>& f) {
    const int parts = std::clamp(std::min(threads, n / 2000), 1, 64);
    std::vector<std::thread> others;
    for (int i = 1; i < parts; ++i)
        others.emplace_back(f, static_cast<int>(static_cast<long>(n) * i / parts),
                            static_cast<int>(static_cast<long>(n) * (i + 1) / parts));
    f(0, n / parts);
    for (std::thread& other : others) other.join();
}

}  // namespace strake
