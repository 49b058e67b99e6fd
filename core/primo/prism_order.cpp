#include "core/primo/prism_order.hpp"

#include <algorithm>
#include <numeric>

namespace strake {
namespace {

constexpr int far_apart = 2000;     // prisms: their vectors and blocks fill a processor's private cache
constexpr double scattered = 0.05;  // share of faces with prisms farther apart

/// Calls work(i, j) for each face between two free prisms, by their numbers.
template <class Work>
void for_free_faces(const RestState& rest, const Work& work) {
    for (const SharedFace& face : rest.faces)
        if (const int i = rest.free_index[face.i], j = rest.free_index[face.j]; i >= 0 && j >= 0) work(i, j);
}

bool is_scattered(const RestState& rest) {
    long all = 0, far = 0;
    for_free_faces(rest, [&](int i, int j) { ++all, far += std::abs(i - j) > far_apart; });
    return static_cast<double>(far) > scattered * static_cast<double>(all);
}

IntLists neighbours(const RestState& rest) {
    IntLists lists;
    lists.begin.assign(rest.num_free() + 1, 0);
    for_free_faces(rest, [&](int i, int j) { ++lists.begin[i + 1], ++lists.begin[j + 1]; });
    std::partial_sum(lists.begin.begin(), lists.begin.end(), lists.begin.begin());
    std::vector<int> next(lists.begin.begin(), lists.begin.end() - 1);
    lists.items.resize(lists.begin.back());
    for_free_faces(rest, [&](int i, int j) { lists.items[next[i]++] = j, lists.items[next[j]++] = i; });
    return lists;
}

/// Appends all prisms connected with `start`, nearest first. @pre none of them is in `seen`
void spread(const IntLists& neighbour, int start, std::vector<char>& seen, std::vector<int>& order) {
    seen[start] = 1;
    order.push_back(start);
    for (std::size_t at = order.size() - 1; at < order.size(); ++at)
        for (const int j : neighbour[order[at]])
            if (!seen[j]) seen[j] = 1, order.push_back(j);
}

/// Part by part, each in layers from one end: layers from the middle would be twice as wide.
std::vector<int> layers(const RestState& rest) {
    const IntLists neighbour = neighbours(rest);
    std::vector<char> seen(rest.num_free(), 0);
    std::vector<int> order;
    order.reserve(rest.num_free());
    for (int i = 0; i < rest.num_free(); ++i) {
        if (seen[i]) continue;
        const std::size_t begin = order.size();
        spread(neighbour, i, seen, order);
        const int end = order.back();
        for (std::size_t k = begin; k < order.size(); ++k) seen[order[k]] = 0;
        order.resize(begin);
        spread(neighbour, end, seen, order);
    }
    return order;
}

}  // namespace

void order_locally(RestState& rest) {
    if (!is_scattered(rest)) return;
    std::vector<int> prisms(rest.free_prisms.size());
    const std::vector<int> order = layers(rest);
    for (std::size_t f = 0; f < order.size(); ++f) prisms[f] = rest.free_prisms[order[f]];
    rest.free_prisms = std::move(prisms);
    for (int f = 0; f < rest.num_free(); ++f) rest.free_index[rest.free_prisms[f]] = f;
    std::vector<std::array<int, 3>> place(rest.faces.size());  // of both prisms, and the number of the face
    for (std::size_t k = 0; k < place.size(); ++k) {
        const auto [first, last] = std::minmax(rest.free_index[rest.faces[k].i], rest.free_index[rest.faces[k].j]);
        place[k] = {first >= 0 ? first : last >= 0 ? last : rest.num_free(), last, static_cast<int>(k)};
    }
    std::ranges::sort(place);
    std::vector<SharedFace> faces;
    faces.reserve(place.size());
    for (const auto& [first, last, k] : place) faces.push_back(rest.faces[k]);
    rest.faces = std::move(faces);
}

}  // namespace strake
