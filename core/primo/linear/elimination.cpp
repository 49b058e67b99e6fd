#include "core/primo/linear/elimination.hpp"

#include <algorithm>
#include <array>

namespace strake {
namespace {

/// Parents of the columns in their order, -1: a root. Paths are shortened as they are walked.
std::vector<int> elimination_tree(const Neighbours& neighbours, const std::vector<int>& order,
                                  const std::vector<int>& place) {
    const int n = static_cast<int>(order.size());
    std::vector<int> parent(n, -1), ancestor(n, -1);
    for (int j = 0; j < n; ++j)
        for (const int other : neighbours[order[j]])
            for (int i = place[other]; i < j && i != -1;) {
                const int next = ancestor[i];
                ancestor[i] = j;
                if (next == -1) parent[i] = j;
                i = next == j ? -1 : next;
            }
    return parent;
}

std::vector<int> places(const std::vector<int>& order) {
    std::vector<int> place(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<int>(k);
    return place;
}

/// Rows of each column below the diagonal, ascending: its own, and those of its children in the tree. A column whose
/// only child has the same rows and itself goes on with that child's supernode.
class Columns {
public:
    Columns(const Neighbours& neighbours, const std::vector<int>& order)
        : neighbours_(neighbours),
          order_(order),
          place_(places(order)),
          seen_(order.size(), -1),
          rows_(order.size()),
          first_child_(order.size(), -1),
          next_child_(order.size(), -1) {}

    std::vector<Supernode> supernodes() {
        std::vector<Supernode> out;
        for (int j = 0; j < static_cast<int>(order_.size()); ++j) {
            const bool only_child = first_child_[j] == j - 1 && j > 0 && next_child_[j - 1] == -1;
            collect(j);
            if (only_child && rows_[j - 1].size() == rows_[j].size() + 1) {
                out.back().last = j + 1;
                rows_[j - 1] = {};  // those of a supernode are its last column's
            } else {
                out.push_back({j, j + 1, {}, 0});
            }
            if (!rows_[j].empty()) {
                const int parent = rows_[j].front();
                next_child_[j] = first_child_[parent];
                first_child_[parent] = j;
            }
        }
        for (Supernode& s : out) s.below = std::move(rows_[s.last - 1]);
        return out;
    }

private:
    const Neighbours& neighbours_;
    const std::vector<int>& order_;
    std::vector<int> place_, seen_;
    std::vector<std::vector<int>> rows_;
    std::vector<int> first_child_, next_child_;

    void add(int j, int row) {
        if (row <= j || seen_[row] == j) return;
        seen_[row] = j;
        rows_[j].push_back(row);
    }
    void collect(int j) {
        for (const int other : neighbours_[order_[j]]) add(j, place_[other]);
        for (int c = first_child_[j]; c != -1; c = next_child_[c])
            for (const int row : rows_[c]) add(j, row);
        std::sort(rows_[j].begin(), rows_[j].end());
    }
};

/// Whether a panel so wide may hold such a share of zeros.
bool may_join(int columns, double share) {
    constexpr std::array<std::pair<int, double>, 2> limits{{{16, 0.8}, {48, 0.1}}};
    if (columns <= 4) return true;
    return std::any_of(limits.begin(), limits.end(),
                       [&](const auto& limit) { return columns <= limit.first && share < limit.second; }) ||
           share < 0.05;
}

/// The child that ends where its parent begins, joined with it: its rows below are all among the parent's.
bool join(Supernode& child, const Supernode& parent, int columns_each) {
    if (child.last != parent.first || child.below.empty() || child.below.front() >= parent.last) return false;
    const double own = child.last - child.first, others = parent.last - parent.first;
    const double below = static_cast<double>(parent.below.size());
    const double added = own * (others + below - static_cast<double>(child.below.size()));
    const double zeros = child.zeros + parent.zeros + added, columns = own + others;
    if (added > 0 &&
        !may_join(static_cast<int>(columns) * columns_each, zeros / (columns * (columns + 1) / 2 + columns * below)))
        return false;
    child = {child.first, parent.last, parent.below, zeros};
    return true;
}

}  // namespace

std::vector<int> postordered(const Neighbours& neighbours, const std::vector<int>& order) {
    const int n = static_cast<int>(order.size());
    const std::vector<int> parent = elimination_tree(neighbours, order, places(order));
    std::vector<int> first_child(n, -1), next_child(n, -1), out;
    for (int j = n - 1; j >= 0; --j)
        if (parent[j] != -1) next_child[j] = first_child[parent[j]], first_child[parent[j]] = j;
    out.reserve(n);
    std::vector<int> path;
    for (int root = 0; root < n; ++root) {
        if (parent[root] != -1) continue;
        path.push_back(root);
        while (!path.empty()) {
            const int j = path.back(), child = first_child[j];
            if (child != -1) {
                first_child[j] = next_child[child];
                path.push_back(child);
            } else {
                out.push_back(order[j]);
                path.pop_back();
            }
        }
    }
    return out;
}

std::vector<Supernode> supernodes_of(const Neighbours& neighbours, const std::vector<int>& order, int columns_each) {
    std::vector<Supernode> out;
    for (Supernode& next : Columns(neighbours, order).supernodes()) {
        out.push_back(std::move(next));
        while (out.size() > 1 && join(out[out.size() - 2], out.back(), columns_each)) out.pop_back();
    }
    return out;
}

}  // namespace strake
