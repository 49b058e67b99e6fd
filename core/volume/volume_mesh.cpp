#include "core/volume/volume_mesh.hpp"

#include <algorithm>
#include <array>
#include <map>

namespace strake {
namespace {

using Face = std::vector<int>;

/// Faces of a prism of n corners below and n above, and of the pyramid; normals outwards.
std::vector<Face> prism(int n) {
    std::vector<Face> faces(2);
    for (int k = 0; k < n; ++k) {
        faces[0].push_back((n - k) % n);
        faces[1].push_back(n + k);
        const int next = (k + 1) % n;
        faces.push_back({k, next, n + next, n + k});
    }
    return faces;
}

struct Shape {
    int corners;
    std::vector<Face> faces;
};

const std::map<int, Shape>& shapes() {
    static const std::map<int, Shape> known = [] {
        const Shape tetrahedron{4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
        const Shape voxel{8, {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {1, 3, 7, 5}, {3, 2, 6, 7}, {2, 0, 4, 6}}};
        const Shape pyramid{5, {{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}};
        const Shape hexahedron{8, prism(4)}, wedge{6, prism(3)};
        return std::map<int, Shape>{{10, tetrahedron}, {24, tetrahedron},    {11, voxel},         {12, hexahedron},
                                    {25, hexahedron},  {29, hexahedron},     {33, hexahedron},    {13, wedge},
                                    {26, wedge},       {32, wedge},          {14, pyramid},       {27, pyramid},
                                    {37, pyramid},     {15, {10, prism(5)}}, {16, {12, prism(6)}}};
    }();
    return known;
}

/// Of VTK's numbers: vertices, lines and polygons, also curved ones.
bool is_flat(int kind) {
    constexpr std::array flat{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 21, 22, 23, 28, 30, 34, 35, 36};
    return std::find(flat.begin(), flat.end(), kind) != flat.end();
}

}  // namespace

void Polygons::add(std::span<const int> polygon) {
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    first.push_back(static_cast<int>(corners.size()));
}

int num_corners(int kind) {
    const auto at = shapes().find(kind);
    return at == shapes().end() ? 0 : at->second.corners;
}

void add_cell(VolumeMesh& mesh, int kind, std::span<const int> corners, std::vector<int>& kinds) {
    const auto at = shapes().find(kind);
    if (at == shapes().end() || static_cast<int>(corners.size()) < at->second.corners) {
        mesh.num_unchecked += is_flat(kind) ? 0 : 1;
        return;
    }
    Face polygon;
    for (const Face& face : at->second.faces) {
        polygon.clear();
        for (const int k : face) polygon.push_back(corners[static_cast<std::size_t>(k)]);
        mesh.faces.add(polygon);
        mesh.owner.push_back(mesh.num_cells);
        mesh.neighbour.push_back(-1);
    }
    ++mesh.num_cells;
    kinds.push_back(kind);
}

TriMesh triangulated(const Points& points, const Polygons& polygons) {
    std::vector<int> corners;
    for (int f = 0; f < polygons.size(); ++f) {
        const std::span<const int> polygon = polygons[f];
        for (std::size_t k = 2; k < polygon.size(); ++k)
            corners.insert(corners.end(), {polygon[0], polygon[k - 1], polygon[k]});
    }
    TriMesh mesh;
    mesh.vertices = points;
    mesh.triangles = Eigen::Map<const Triangles>(corners.data(), static_cast<Eigen::Index>(corners.size() / 3), 3);
    return mesh;
}

}  // namespace strake
