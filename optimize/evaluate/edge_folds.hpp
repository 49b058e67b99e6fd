#pragma once
#include "core/mesh/adjacency.hpp"

#include <array>
#include <memory>

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
    EdgeFolds(std::shared_ptr<const TriMesh> rest, const Adjacency& adjacent, const std::vector<char>& excluded);

    bool is_none() const { return hinges_.empty(); }
    /// Edges with a dihedral above `degrees`, ascending. @param normal of all triangles
    std::vector<int> above(double degrees, const Points& normal) const;
    bool any_above(double degrees, const Points& vertices) const;
    /// The same with derivatives: the largest first, at most `count`, no two at one vertex.
    std::vector<Row> rows(const Points& vertices, double degrees, int count) const;
    const std::array<int, 2>& triangles(int edge) const { return hinges_[static_cast<std::size_t>(edge)]; }
    /// Its two vertices.
    std::array<int, 2> ends(int edge) const;

private:
    std::array<int, 4> vertices(int edge) const;  ///< as in `Row`
    Points normals(const Points& vertices) const;
    Row row(int edge, const Points& vertices, double angle) const;

    std::shared_ptr<const TriMesh> rest_;
    std::vector<std::array<int, 2>> hinges_;  ///< triangles at interior edges whose dihedral is below 120 degrees
};

}  // namespace strake
