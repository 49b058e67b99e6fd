#include "core/primo/linear/vectors.hpp"

#include <algorithm>
#include <vector>

#include "core/parallel.hpp"

namespace strake {
namespace {

constexpr int entries_per_task = 8192;

template <class Work>
void for_parts(Eigen::Index size, const Work& work) {
    for_blocks(static_cast<int>(size), entries_per_task, [&](int begin, int end) { work(begin, end - begin); });
}

}  // namespace

double dot(const ConstColumn& a, const ConstColumn& b) {
    return ordered_sum(static_cast<int>(a.size()), entries_per_task, [&](int begin, int end) {
        return a.segment(begin, end - begin).dot(b.segment(begin, end - begin));
    });
}

double largest_entry(const ConstColumn& a) {
    std::vector<double> largest(static_cast<std::size_t>(a.size() / entries_per_task + 1), 0.0);
    for_parts(a.size(), [&](int begin, int size) {
        largest[begin / entries_per_task] = a.segment(begin, size).lpNorm<Eigen::Infinity>();
    });
    return *std::max_element(largest.begin(), largest.end());
}

void add_multiple(Column y, double factor, const ConstColumn& x) {
    for_parts(y.size(), [&](int begin, int size) { y.segment(begin, size) += factor * x.segment(begin, size); });
}

void scale_and_add(Column p, double factor, const ConstColumn& z) {
    for_parts(p.size(), [&](int begin, int size) {
        p.segment(begin, size) = z.segment(begin, size) + factor * p.segment(begin, size);
    });
}

}  // namespace strake
