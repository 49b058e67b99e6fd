#include "core/primo/linear/aggregation.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

/// The rows within `radius` connections of `root`, itself first.
void ball(const Graph& graph, int root, int radius, std::vector<int>& rows) {
    rows.assign(1, root);
    std::size_t first = 0;
    for (int step = 0; step < radius; ++step) {
        const std::size_t last = rows.size();
        for (; first < last; ++first)
            for (int k = graph.begin[rows[first]]; k < graph.begin[rows[first] + 1]; ++k)
                if (std::find(rows.begin(), rows.end(), graph.neighbour[k]) == rows.end())
                    rows.push_back(graph.neighbour[k]);
    }
}

/// Rows without a cluster join that of their strongest clustered neighbour; all at once, which keeps clusters round.
bool join(const Graph& graph, Clusters& clusters) {
    const std::vector<int> before = clusters.of;
    bool joined = false;
    for (int i = 0; i < graph.size(); ++i) {
        if (before[i] >= 0) continue;
        float best = 0;
        for (int k = graph.begin[i]; k < graph.begin[i + 1]; ++k) {
            const int to = before[graph.neighbour[k]];
            if (to < 0 || graph.strength[k] <= best) continue;
            best = graph.strength[k];
            clusters.of[i] = to;
            joined = true;
        }
    }
    return joined;
}

}  // namespace

Graph strong_connections(const Graph& all, double threshold) {
    std::vector<float> strongest(all.size(), 0);
    for (int i = 0; i < all.size(); ++i)
        for (int k = all.begin[i]; k < all.begin[i + 1]; ++k) strongest[i] = std::max(strongest[i], all.strength[k]);
    Graph strong;
    for (int i = 0; i < all.size(); ++i) {
        for (int k = all.begin[i]; k < all.begin[i + 1]; ++k) {
            const int j = all.neighbour[k];
            const float s = all.strength[k];
            if (!(s > 0) || s < threshold * std::min(strongest[i], strongest[j])) continue;
            strong.neighbour.push_back(j);
            strong.strength.push_back(s);
        }
        strong.begin.push_back(static_cast<int>(strong.neighbour.size()));
    }
    return strong;
}

template <class Real>
Clusters aggregate(const BlockRows<Real>& A, double threshold, int radius) {
    Graph graph{A.begin, A.column, std::vector<float>(A.column.size())};
    for (std::size_t k = 0; k < A.column.size(); ++k) {
        const Real* block = A.block(static_cast<int>(k));
        Real squares = 0;
        for (int q = 0; q < block_entries; ++q) squares += block[q] * block[q];
        graph.strength[k] = static_cast<float>(std::sqrt(squares));
    }
    return aggregate(strong_connections(graph, threshold), radius);
}

Clusters aggregate(const Graph& graph, int radius) {
    Clusters clusters{std::vector<int>(graph.size(), -1), 0};
    std::vector<int> rows;
    const auto is_free = [&](int i) { return clusters.of[i] < 0; };
    for (int i = 0; i < graph.size(); ++i) {
        if (!is_free(i)) continue;
        ball(graph, i, radius, rows);
        if (!std::all_of(rows.begin(), rows.end(), is_free)) continue;
        for (const int j : rows) clusters.of[j] = clusters.count;
        ++clusters.count;
    }
    for (int step = 0; step < radius && join(graph, clusters); ++step) {
    }
    for (int i = 0; i < graph.size(); ++i) {  // far from every root
        if (!is_free(i)) continue;
        ball(graph, i, radius, rows);
        for (const int j : rows)
            if (is_free(j)) clusters.of[j] = clusters.count;
        ++clusters.count;
    }
    return clusters;
}

template Clusters aggregate(const BlockRows<float>&, double, int);
template Clusters aggregate(const BlockRows<double>&, double, int);

}  // namespace strake
