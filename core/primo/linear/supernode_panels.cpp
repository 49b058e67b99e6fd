#include <algorithm>
#include <cstring>

#include "core/primo/linear/supernodes.hpp"

namespace strake {
namespace {

/// One supernode, `columns` of `rows` entries each, to its panels.
void pack(const std::vector<float>& from, int columns, int rows, float* to) {
    for (int j = 0, panel; j < columns; j += panel) {
        panel = panel_width(columns - j);
        const int below = rows - j - panel;
        const auto entry = [&](int row, int p) { return from[static_cast<std::size_t>(j + p) * rows + j + row]; };
        std::fill(to, to + panel_size(panel, rows - j), 0.0f);
        for (int p = 0; p < panel; ++p)
            for (int i = p; i < panel; ++i) to[p * panel_rows + i] = entry(i, p);
        to += triangle_size(panel);
        for (int i = 0; i < below; i += panel_rows)
            for (int p = 0; p < panel; ++p, to += panel_rows)
                for (int r = 0; r < std::min(panel_rows, below - i); ++r) to[r] = entry(panel + i + r, p);
    }
}

long packed_size(int columns, int rows) {
    long size = 0;
    for (int j = 0; j < columns; j += panel_width(columns - j)) size += panel_size(panel_width(columns - j), rows - j);
    return size;
}

}  // namespace

void Supernodes::take(double* doubles, const std::vector<long>& first) {
    entry.reset(reinterpret_cast<float*>(doubles));  // on every path
    first_entry.assign(1, 0);
    const auto* source = reinterpret_cast<const unsigned char*>(doubles);
    std::vector<float> one;
    for (int s = 0; s < num_supernodes(); ++s) {
        const int columns = first_column[s + 1] - first_column[s];
        const int rows = static_cast<int>(first_row[s + 1] - first_row[s]);
        one.resize(first[s + 1] - first[s]);
        for (std::size_t k = 0; k < one.size(); ++k) {
            double value;
            std::memcpy(&value, source + sizeof value * (first[s] + k), sizeof value);
            one[k] = static_cast<float>(value);
        }
        pack(one, columns, rows, entry.get() + first_entry[s]);
        first_entry.push_back(first_entry[s] + packed_size(columns, rows));
    }
    const std::size_t bytes = sizeof(float) * std::max(1L, first_entry.back());
    if (void* smaller = std::realloc(entry.get(), bytes)) {
        (void)entry.release();
        entry.reset(static_cast<float*>(smaller));
    }
}

}  // namespace strake
