#include "core/error.hpp"
#include "core/repair/surface_parts.hpp"

#include <algorithm>
#include <numeric>

namespace strake::mending {

void drop_components(Surface& surface, const RepairOptions& options) {
    if (options.keep_largest <= 0 && options.min_area_share <= 0 && options.min_triangles <= 0) return;
    const TriMesh& mesh = surface.mesh;
    const std::vector<int> component = edge_components(mesh, adjacency(mesh));
    const int count = component.empty() ? 0 : *std::max_element(component.begin(), component.end()) + 1;
    std::vector<double> area(static_cast<std::size_t>(count));
    std::vector<int> triangles(area.size()), first(area.size(), -1), order(area.size());
    double total = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const int c = component[t];
        const double a = area_vector(mesh, t).norm();
        area[c] += a;
        total += a;
        if (triangles[c]++ == 0) first[c] = t;
    }
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return area[a] > area[b]; });
    std::vector<const char*> why(area.size(), nullptr);
    for (std::size_t i = 0; i < order.size(); ++i) {
        const int c = order[i];
        if (options.keep_largest > 0 && i >= static_cast<std::size_t>(options.keep_largest))
            why[c] = "not among the largest";
        else if (area[c] < options.min_area_share * total)
            why[c] = "its area is too small a share";
        else if (triangles[c] < options.min_triangles)
            why[c] = "too few triangles";
    }
    if (static_cast<std::size_t>(std::count(why.begin(), why.end(), nullptr)) == 0)
        throw InvalidInput(text("components: none of ", count, " would be left"));
    std::vector<char> is_gone(component.size());
    for (std::size_t t = 0; t < component.size(); ++t) is_gone[t] = why[component[t]] != nullptr;
    for (int c = 0; c < count; ++c)
        if (why[c])
            surface.items.push_back({RepairKind::component, -1, surface.source[first[c]], surface.center(first[c]),
                                     area[c], triangles[c],
                                     text("component of ", triangles[c], " triangles, area ", area[c], ": ", why[c])});
    surface.remove(is_gone);
}

}  // namespace strake::mending
