#include "core/primo/aggregation.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

/// Strong connections: neighbours of each row and how strong.
struct Graph {
    std::vector<int> begin{0}, neighbour;
    std::vector<float> strength;
    int size() const { return static_cast<int>(begin.size()) - 1; }
};

template <class Real>
Graph strong_connections(const BlockRows<Real>& A, double threshold) {
    const int n = A.size();
    std::vector<float> norm(A.column.size()), strongest(n, 0);
    for (int i = 0; i < n; ++i)
        for (int k = A.begin[i]; k < A.begin[i + 1]; ++k) {
            Real squares = 0;
            for (int q = 0; q < block_entries; ++q) squares += A.block(k)[q] * A.block(k)[q];
            norm[k] = static_cast<float>(std::sqrt(squares));
            strongest[i] = std::max(strongest[i], norm[k]);
        }
    Graph graph;
    for (int i = 0; i < n; ++i) {
        for (int k = A.begin[i]; k < A.begin[i + 1]; ++k)
            if (norm[k] > 0 && norm[k] >= threshold * std::min(strongest[i], strongest[A.column[k]])) {
                graph.neighbour.push_back(A.column[k]);
                graph.strength.push_back(norm[k]);
            }
        graph.begin.push_back(static_cast<int>(graph.neighbour.size()));
    }
    return graph;
}

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

/// What has no cluster joins that of its strongest neighbour with one; all at once, so that clusters stay round.
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

template <class Real>
Clusters aggregate(const BlockRows<Real>& A, double threshold, int radius) {
    const Graph graph = strong_connections(A, threshold);
    Clusters clusters{std::vector<int>(A.size(), -1), 0};
    std::vector<int> rows;
    const auto is_free = [&](int i) { return clusters.of[i] < 0; };
    for (int i = 0; i < A.size(); ++i) {
        if (!is_free(i)) continue;
        ball(graph, i, radius, rows);
        if (!std::all_of(rows.begin(), rows.end(), is_free)) continue;
        for (const int j : rows) clusters.of[j] = clusters.count;
        ++clusters.count;
    }
    for (int step = 0; step < radius && join(graph, clusters); ++step) {
    }
    for (int i = 0; i < A.size(); ++i) {  // far from every root
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
