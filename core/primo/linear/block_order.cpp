#include "core/primo/linear/block_order.hpp"

#include <metis.h>

#include <mutex>

#include "core/error.hpp"

namespace strake {
namespace {

/// @throws std::bad_alloc
void require_memory(std::size_t bytes) { ::operator delete(::operator new(bytes)); }

}  // namespace

std::vector<int> block_order(const BlockMatrix& A) {
    const idx_t n = A.size();
    std::vector<idx_t> begin(n + 1, 0);
    for (int j = 0; j < n; ++j)
        for (int k = A.begin[j]; k < A.begin[j + 1]; ++k) ++begin[j + 1], ++begin[A.row[k] + 1];
    for (int j = 0; j < n; ++j) begin[j + 1] += begin[j];
    std::vector<idx_t> next(begin.begin(), begin.end() - 1), neighbour(begin[n]);
    for (int j = 0; j < n; ++j)
        for (int k = A.begin[j]; k < A.begin[j + 1]; ++k)
            neighbour[next[j]++] = A.row[k], neighbour[next[A.row[k]]++] = j;
    std::vector<idx_t> order(n), place(n);
    if (neighbour.empty()) {  // METIS refuses graphs without edges
        for (int j = 0; j < n; ++j) order[j] = j;
        return {order.begin(), order.end()};
    }
    idx_t options[METIS_NOPTIONS];
    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = 1;
    static std::mutex one_at_a_time;  // METIS draws from the generator of the C library, which threads share
    const std::lock_guard lock(one_at_a_time);
    // Not METIS_NodeND: it catches SIGTERM and SIGABRT, jumps out in whatever thread the signal arrives, and restores
    // handlers without their flags. For one part this function gives the same order and leaves signals alone. It would
    // end the program when out of memory, so memory is checked first.
    require_memory(32 * (order.size() + neighbour.size()));  // it takes 20 to 25
    idx_t part_size = 0;
    if (METIS_NodeNDP(n, begin.data(), neighbour.data(), nullptr, 1, options, order.data(), place.data(), &part_size) !=
        METIS_OK)
        throw SolverError(text("METIS could not order ", n, " block rows"));
    return {order.begin(), order.end()};
}

}  // namespace strake
