#pragma once
#include "core/mesh/adjacency.hpp"

#include <array>

/// Edges along which a surface folds up. A folded surface is refused, and that is known before anything is paid for,
/// with its derivative: searches keep to it as to a limit. Internal to the evaluator.
namespace strake {

class EdgeFolds {
public:
    static constexpr double folded = 170;  ///< degrees: dihedrals above it are refused
    static constexpr double kept = 168;    ///< that designs keep
    /// Of which edges steps are told, and what they aim at, degrees.
    struct Angles {
        double nearly = 150, aimed = kept - 1;
    };

    /// An edge, and how its dihedral changes with its vertices and those opposite to it.
    struct Row {
        int edge = 0;                          ///< of those that may fold
        double angle = 0;                      ///< dihedral, degrees
        std::array<int, 4> vertices{};         ///< of the edge, then opposite to it in either triangle
        Eigen::Matrix<double, 4, 3> gradient;  ///< of the angle, degrees over length
    };

    EdgeFolds() = default;  ///< none
    /// @param excluded per triangle: edges at it are none that may fold; empty: no triangle.
    EdgeFolds(const TriMesh& rest, const Adjacency& adjacent, const std::vector<char>& excluded);

    bool is_none() const { return hinges_.empty(); }
    /// Edges with a dihedral above `degrees`, ascending. @param normal of all triangles
    std::vector<int> above(double degrees, const Points& normal) const;
    bool any_above(double degrees, const Points& vertices) const;
    /// The same with derivatives: the largest first, at most `count`, no two at one vertex.
    std::vector<Row> rows(const Points& vertices, double degrees, int count) const;
    const std::array<int, 2>& triangles(int edge) const { return hinges_[static_cast<std::size_t>(edge)].triangles; }
    /// Its two vertices.
    std::array<int, 2> ends(int edge) const;

private:
    struct Hinge {
        std::array<int, 2> triangles;
        std::array<int, 4> vertices;  ///< as in `Row`
    };
    Points normals(const Points& vertices) const;
    Row row(int edge, const Points& vertices, double angle) const;

    Triangles triangles_;
    std::vector<Hinge> hinges_;  ///< interior edges whose dihedral is below 120 degrees at rest
};

}  // namespace strake
