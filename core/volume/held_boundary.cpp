#include "core/volume/held_boundary.hpp"

#include "core/error.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/text/file.hpp"

namespace strake {
namespace {

const BoundaryPart& part_named(const VolumeMesh& mesh, const std::string& name) {
    std::string known;
    for (const BoundaryPart& part : mesh.boundary) {
        if (part.name == name) return part;
        known += (known.empty() ? "" : ", ") + printable(part.name, 60);
    }
    throw InvalidInput(text("the mesh has no boundary '", printable(name, 60),
                            "'; it has: ", known.empty() ? "none with a name" : known));
}

}  // namespace

Eigen::VectorXd hold_factors(const VolumeMesh& mesh, const std::vector<std::string>& names,
                             const Eigen::VectorXd& distances) {
    Eigen::VectorXd factor = Eigen::VectorXd::Ones(mesh.num_points());
    Polygons held;
    for (const std::string& name : names) {
        const BoundaryPart& part = part_named(mesh, name);
        for (int f = 0; f < part.faces.size(); ++f) held.add(part.faces[f]);
    }
    const TriMesh wall = triangulated(mesh.points, held);
    if (wall.num_triangles() == 0) return factor;
    const ClosestPointTree tree(wall);
    std::vector<char> is_on(static_cast<std::size_t>(mesh.num_points()), 0);
    for (const int v : held.corners) is_on[static_cast<std::size_t>(v)] = 1;
    for (int p = 0; p < mesh.num_points(); ++p) {
        const double d = is_on[static_cast<std::size_t>(p)] ? 0 : tree.find(mesh.points.row(p)).distance;
        const double x = distances[p] == 0 ? 1 : d / (d + distances[p]);
        factor[p] = x * x * (3 - 2 * x);
    }
    return factor;
}

}  // namespace strake
