#include "cases/regions.hpp"

#include "cases/scalars.hpp"
#include "core/mesh/geometry.hpp"

#include <algorithm>
#include <fstream>
#include <numeric>
#include <set>

namespace strake {
namespace {

constexpr double border_rel = 1e-9;  ///< of the diagonal: what lies on the border is inside

template <class Inside>
std::vector<int> triangles_with(const TriMesh& mesh, const Inside& inside) {
    std::vector<char> vertex(mesh.num_vertices());
    for (int v = 0; v < mesh.num_vertices(); ++v) vertex[v] = inside(mesh.vertices.row(v).transpose());
    std::vector<int> found;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (vertex[mesh.triangles(t, 0)] && vertex[mesh.triangles(t, 1)] && vertex[mesh.triangles(t, 2)])
            found.push_back(t);
    return found;
}

std::string box_text(const TriMesh& mesh) {
    const Box box = bounding_box(mesh);
    return text("[[", box.min[0], ", ", box.min[1], ", ", box.min[2], "], [", box.max[0], ", ", box.max[1], ", ",
                box.max[2], "]]");
}

/// Numbers, one a line; blank lines are passed over.
std::vector<int> read_triangle_numbers(const std::filesystem::path& file, int num_triangles) {
    std::ifstream in(file);
    if (!in) throw InvalidInput(text(printable(file.string(), 300), ": cannot be read"));
    std::set<int> numbers;
    std::string line;
    for (int k = 1; std::getline(in, line); ++k) {
        const std::size_t first = line.find_first_not_of(" \t\r"), last = line.find_last_not_of(" \t\r");
        if (first == std::string::npos) continue;
        Value value;
        value.text = line.substr(first, last - first + 1);
        const std::string where = text(printable(file.string(), 300), ":", k, ": ");
        const std::string error = convert_scalar(value, Type::integer, Key{}, {});
        if (!error.empty()) throw InvalidInput(text(where, "'", printable(value.text, 40), "' ", error));
        if (value.number < 0 || value.number >= num_triangles)
            throw InvalidInput(text(where, "triangle ", value.text, " must be in [0, ", num_triangles, ")"));
        if (!numbers.insert(static_cast<int>(value.number)).second)
            throw InvalidInput(text(where, "triangle ", value.text, " is listed twice"));
    }
    return {numbers.begin(), numbers.end()};
}

struct Evaluate {
    const StartSurface& start;
    const PatchHierarchy& tree;

    std::vector<int> operator()(const BoxShape& box) const {
        const double slack = border_rel * start.diagonal;
        return triangles_with(start.mesh, [&](const Eigen::Vector3d& x) {
            return ((x - box.min).array() >= -slack).all() && ((box.max - x).array() >= -slack).all();
        });
    }
    std::vector<int> operator()(const SphereShape& sphere) const {
        const double reach = sphere.radius.in(start.diagonal) + border_rel * start.diagonal;
        return triangles_with(start.mesh,
                              [&](const Eigen::Vector3d& x) { return (x - sphere.center).norm() <= reach; });
    }
    std::vector<int> operator()(const HalfSpace& plane) const {
        const double slack = border_rel * start.diagonal, sign = plane.above ? 1 : -1;
        return triangles_with(start.mesh, [&](const Eigen::Vector3d& x) {
            return sign * (plane.normal.dot(x) - plane.offset) >= -slack;
        });
    }
    std::vector<int> operator()(const SolidShape& solid) const {
        const auto& names = start.mesh.group_names;
        const auto found = std::find(names.begin(), names.end(), solid.name);
        if (start.mesh.group.empty()) throw InvalidInput("the surface file names no parts");
        if (found == names.end()) {
            const std::string near = nearest(solid.name, names);
            std::vector<std::string> shown;
            for (std::size_t k = 0; k < names.size() && k < 10; ++k) shown.push_back(printable(names[k], 40));
            throw InvalidInput(text("the surface has no solid '", printable(solid.name), "'; ",
                                    near.empty() ? "" : text("did you mean '", printable(near), "'? "), "solids: ",
                                    joined(shown), names.size() > 10 ? text(", ... (", names.size(), ")") : ""));
        }
        // Two parts of one name are both meant.
        std::vector<int> triangles;
        for (int t = 0; t < start.mesh.num_triangles(); ++t)
            if (names[start.mesh.group[t]] == solid.name) triangles.push_back(t);
        return triangles;
    }
    std::vector<int> operator()(const ComponentShape& component) const {
        const std::vector<int> number = edge_components(start.mesh, start.adjacent);
        const int count = number.empty() ? 0 : 1 + *std::max_element(number.begin(), number.end());
        if (component.number >= count)
            throw InvalidInput(text("component ", component.number, " must be below ", count,
                                    ", the number of connected pieces of the surface"));
        std::vector<int> triangles;
        for (int t = 0; t < start.mesh.num_triangles(); ++t)
            if (number[t] == component.number) triangles.push_back(t);
        return triangles;
    }
    std::vector<int> operator()(const PatchShape& patch) const {
        const PatchPlace place = find_patch(tree, patch.name);
        return tree.levels[place.level].patches[place.id].triangles;
    }
    std::vector<int> operator()(const TriangleFile& list) const {
        if (start.is_remeshed)
            throw InvalidInput(
                "triangle numbers of the surface file mean nothing after remesh; remesh beforehand, or "
                "state another shape");
        if (start.source_triangle.empty()) return read_triangle_numbers(list.file, start.mesh.num_triangles());
        std::vector<char> is_listed(static_cast<std::size_t>(start.file_triangles));
        for (const int t : read_triangle_numbers(list.file, start.file_triangles)) is_listed[t] = 1;
        std::vector<int> triangles;
        for (int t = 0; t < start.mesh.num_triangles(); ++t)
            if (const int source = start.source_triangle[t]; source >= 0 && is_listed[source]) triangles.push_back(t);
        return triangles;
    }
};

}  // namespace

std::vector<int> region_triangles(const Region& region, const StartSurface& start, const PatchHierarchy& tree) {
    std::vector<int> triangles = std::visit(Evaluate{start, tree}, region.shape);
    if (triangles.empty()) {
        const bool is_geometric = region.shape.index() <= 2;
        throw InvalidInput(text("region '", region.name, "' holds no triangle",
                                is_geometric ? text("; a triangle is inside when its three vertices are; the surface's "
                                                    "box is ",
                                                    box_text(start.mesh))
                                             : ""));
    }
    return triangles;
}

}  // namespace strake
