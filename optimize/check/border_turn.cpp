#include "optimize/check/border_turn.hpp"

#include "core/mesh/geometry.hpp"
#include "core/wrap/wrap_map.hpp"

#include <cmath>
#include <numbers>

namespace strake {

BorderTurn border_turn(const RestFacts& rest, const Adjacency& adjacent, const std::vector<char>& held,
                       const Points& motion, double size) {
    BorderTurn most;
    const double largest = motion.rowwise().norm().maxCoeff();
    if (!(largest > 0)) return most;
    const TriMesh moved = with_vertices(rest.surface, rest.surface.vertices + size / largest * motion);
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        const auto& sides = adjacent.edge_triangles[e];
        bool is_border = false, is_free = false;
        for (const int t : sides) (held[static_cast<std::size_t>(t)] ? is_border : is_free) = true;
        if (!is_border || !is_free) continue;
        for (const int t : sides) {
            if (held[static_cast<std::size_t>(t)]) continue;
            const Eigen::Vector3d before = area_vector(rest.surface, t), after = area_vector(moved, t);
            const double angle = std::atan2(before.cross(after).norm(), before.dot(after));
            if (const double degrees = angle * 180 / std::numbers::pi; degrees > most.degrees) most = {degrees, t};
        }
    }
    return most;
}

std::vector<char> pinned_triangles(const RestFacts& rest) {
    const std::vector<int>& pin = rest.setup.options.pin;
    std::vector<char> held(static_cast<std::size_t>(rest.surface.num_triangles()), 0);
    if (rest.wrap) {
        const std::vector<char>& is_held = rest.wrap->held();
        for (std::size_t t = 0; t < held.size(); ++t) {
            const Eigen::RowVector3i v = rest.surface.triangles.row(static_cast<Eigen::Index>(t));
            held[t] = is_held[static_cast<std::size_t>(v[0])] && is_held[static_cast<std::size_t>(v[1])] &&
                      is_held[static_cast<std::size_t>(v[2])];
        }
        return held;
    }
    for (std::size_t t = 0; t < pin.size(); ++t) held[t] = pin[t] != free_prism;
    return held;
}

}  // namespace strake
