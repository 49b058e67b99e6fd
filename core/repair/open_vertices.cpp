#include "core/repair/open_vertices.hpp"

namespace strake::mending {

OpenVertices open_vertices(const TriMesh& mesh, const Adjacency& adjacent) {
    OpenVertices open;
    open.is_open.resize(static_cast<std::size_t>(mesh.num_vertices()));
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (adjacent.edge_triangles[e].size() == 1)
            for (const int v : adjacent.edges[e]) open.is_open[v] = 1;
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (open.is_open[v]) open.numbers.push_back(v);
    open.points.resize(static_cast<Eigen::Index>(open.numbers.size()), 3);
    for (std::size_t i = 0; i < open.numbers.size(); ++i)
        open.points.row(static_cast<Eigen::Index>(i)) = mesh.vertices.row(open.numbers[i]);
    return open;
}

}  // namespace strake::mending
