#include "core/primo/linear/supernodes.hpp"

#include <algorithm>
#include <cstdint>

namespace strake {
namespace {

// Shares of all entries: subtrees above the first belong to the last round, one task after the other; each limit is
// half of the previous one, which leaves unbranched chains between limits.
constexpr double first_limit = 0.6;
constexpr int num_limits = 4;
constexpr double min_task = 0.02;  // of the first round, if the tree has no larger one

/// Per supernode: the one above it, -1: none.
std::vector<int> parents(const Supernodes& f) {
    std::vector<int> owner(f.size), parent(f.num_supernodes(), -1);
    for (int s = 0; s < f.num_supernodes(); ++s)
        std::fill(owner.begin() + f.first_column[s], owner.begin() + f.first_column[s + 1], s);
    for (int s = 0; s < f.num_supernodes(); ++s) {
        const long below = f.first_row[s] + f.first_column[s + 1] - f.first_column[s];
        if (below < f.first_row[s + 1]) parent[s] = owner[f.row[below]];
    }
    return parent;
}

/// Per supernode the round in which it is done: 0, the first, for subtrees below the last limit.
std::vector<int> rounds(const std::vector<std::int64_t>& below, std::int64_t all) {
    std::vector<int> round(below.size(), 0);
    for (std::size_t s = 0; s < below.size(); ++s) {
        double limit = first_limit * static_cast<double>(all);
        for (int k = num_limits; k > 0 && round[s] == 0; --k, limit /= 2)
            if (static_cast<double>(below[s]) > limit) round[s] = k;
    }
    return round;
}

}  // namespace

void Supernodes::plan() {
    const int count = num_supernodes();
    const std::vector<int> parent = parents(*this);
    std::vector<std::int64_t> below(count, 0);  // entries of the subtree
    std::int64_t all = 0;
    for (int s = 0; s < count; ++s) {
        const std::int64_t own = static_cast<std::int64_t>(first_column[s + 1] - first_column[s]) *
                                 static_cast<std::int64_t>(first_row[s + 1] - first_row[s]);
        all += own;
        below[s] += own;
        if (parent[s] >= 0) below[parent[s]] += below[s];
    }
    const std::vector<int> round = rounds(below, all);
    // Tasks are numbered round by round in the order of their topmost supernodes; small subtrees share one.
    std::vector<int> task(count, -1);
    int tasks = 0;
    round_begin.assign(1, 0);
    for (int r = 0; r <= num_limits; ++r) {
        std::int64_t filled = 0;
        for (int s = count - 1; s >= 0; --s) {
            if (round[s] != r) continue;
            if (parent[s] >= 0 && round[parent[s]] == r) {
                task[s] = task[parent[s]];
                continue;
            }
            const bool joins =
                r == 0 && filled > 0 && static_cast<double>(filled + below[s]) < min_task * static_cast<double>(all);
            filled = joins ? filled + below[s] : below[s];
            task[s] = joins ? tasks - 1 : tasks++;
        }
        round_begin.push_back(tasks);
    }
    task_begin.assign(tasks + 1, 0);
    for (const int t : task) ++task_begin[t + 1];
    for (int t = 0; t < tasks; ++t) task_begin[t + 1] += task_begin[t];
    std::vector<int> next(task_begin.begin(), task_begin.end() - 1);
    order.resize(count);
    for (int s = 0; s < count; ++s) order[next[task[s]]++] = s;
    list_outside_rows(task);
}

void Supernodes::list_outside_rows(const std::vector<int>& task) {
    std::vector<int> task_of_row(size), place(size, -1);
    for (int s = 0; s < num_supernodes(); ++s)
        std::fill(task_of_row.begin() + first_column[s], task_of_row.begin() + first_column[s + 1], task[s]);
    outside.clear();
    outside_begin.assign(1, 0);
    for (int t = 0; t + 1 < static_cast<int>(task_begin.size()); ++t) {
        for (int q = task_begin[t]; q < task_begin[t + 1]; ++q)
            for (long k = first_row[order[q]]; k < first_row[order[q] + 1]; ++k) {
                const int r = row[k];
                if (task_of_row[r] == t) continue;
                if (place[r] < outside_begin.back()) {
                    place[r] = static_cast<int>(outside.size());
                    outside.push_back(r);
                }
                row[k] = size + place[r];
            }
        outside_begin.push_back(static_cast<int>(outside.size()));
    }
}

}  // namespace strake
