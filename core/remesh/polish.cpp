#include "core/remesh/vertex_place.hpp"

#include <algorithm>

/// The finish: moves vertices of badly shaped triangles one by one to maximize the worst quality around each.
namespace strake {
namespace {

constexpr int max_tries = 12;  ///< per vertex and sweep: hundreds of thin triangles at one vertex would all request it

double worst_around(const WorkingMesh& mesh, int v) {
    double quality = 1;
    mesh.around(v, [&](int h) {
        quality = std::min(quality, mesh.quality(h / 3));
        return true;
    });
    return quality;
}

bool improve(WorkingMesh& mesh, const StepGuard& guard, int v, double below) {
    if (mesh.role[v] == VertexRole::fixed || !(worst_around(mesh, v) < below)) return false;
    const auto cost = [&](const VertexPlace& place, double) { return shape_cost(mesh, guard, v, place); };
    VertexPlace best;
    if (!find_best_place(mesh, guard, v, shape_cost(mesh, guard, v, place_of(mesh, v)), cost, best)) return false;
    put(mesh, v, best);
    return true;
}

}  // namespace

int polish(WorkingMesh& mesh, const StepGuard& guard, double below) {
    int count = 0;
    std::vector<int> look;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (mesh.is_alive(t) && mesh.quality(t) < below) look.push_back(t);
    const auto is_hopeless = [&](int t) { return mesh.quality(t) < 0.02; };
    if (4 * std::count_if(look.begin(), look.end(), is_hopeless) > mesh.num_triangles()) return 0;  // wires
    const std::size_t most = mesh.num_triangles() / 2;  // the finish may take time
    if (look.size() > most) {
        std::stable_sort(look.begin(), look.end(), [&](int t, int u) { return mesh.quality(t) > mesh.quality(u); });
        look.resize(most);
    }
    for (int sweep = 0; sweep < 4 && !look.empty(); ++sweep) {
        std::vector<int> tries(mesh.num_vertices(), 0);
        for (const int t : look)
            for (int k = 0; k < 3; ++k) {
                const int v = mesh.corner[3 * t + k];
                if (++tries[v] <= max_tries) count += improve(mesh, guard, v, below);
            }
        std::erase_if(look, [&](int t) { return mesh.quality(t) >= below; });
    }
    return count;
}

}  // namespace strake
