#include "core/mesh/mesh.hpp"

#include "core/error.hpp"

namespace strake {

TriMesh with_vertices(const TriMesh& mesh, const Points& vertices) {
    if (vertices.rows() != mesh.vertices.rows())
        throw InvalidInput(
            text("with_vertices: ", vertices.rows(), " vertices given, the surface has ", mesh.vertices.rows()));
    TriMesh moved = mesh;
    moved.vertices = vertices;
    return moved;
}

}  // namespace strake
