#pragma once
#include "core/mesh/adjacency.hpp"
#include "core/primo/shell.hpp"

#include <memory>

/// The closed parts of a surface while it deforms: each stays the right way out, and inside of what it was inside of.
namespace strake {

/// A part is a set of triangles connected over edges. It is closed when every edge has two triangles that agree; with
/// a plane of symmetry also when its other edges lie on the plane (both ends within 1e-6 of the diagonal).
class ClosedParts {
public:
    /// @param intersecting pairs of triangles that intersect at rest: parts that pierce each other are in no relation.
    ClosedParts(std::shared_ptr<const TriMesh> rest, const Adjacency& adjacent,
                const std::optional<SymmetryPlane>& symmetry, const std::vector<std::array<int, 2>>& intersecting);

    /// A part whose enclosed volume has no longer the sign that it has at rest, in words; else empty. Parts without
    /// volume at rest are ignored.
    std::string inside_out(const Points& vertices) const;

    /// A part that went wholly into another one, or out of it, in words; else empty. By winding numbers, for surfaces
    /// of up to 16 closed parts. @pre no two parts intersect that did not at rest.
    std::string swallowed(const Points& vertices) const;

private:
    struct Part {
        std::vector<int> triangles;
        bool by_plane = false;  ///< closed together with the plane
        double volume = 0;      ///< at rest
    };
    double volume(const Part& part, const Points& vertices) const;
    int winding(const Part& part, const Points& vertices, const Eigen::Vector3d& x) const;
    int vertex_away(const Part& part, const Part& other, const Points& rest) const;
    int inside(int vertex, int other, const Points& vertices) const;
    std::string words(const Part& part) const;

    std::shared_ptr<const TriMesh> rest_;
    std::optional<SymmetryPlane> symmetry_;
    Eigen::Vector3d origin_;  ///< of the volumes: on the plane of symmetry
    std::vector<Part> parts_;
    struct Relation {
        int part, other;
        int vertex;  ///< of `part`, away from `other`
        int inside;  ///< winding number of `other` about it at rest
    };
    std::vector<Relation> relations_;
};

}  // namespace strake
