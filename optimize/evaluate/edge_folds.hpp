#pragma once
#include "core/mesh/adjacency.hpp"
#include "optimize/problem/problem.hpp"

#include <array>
#include <memory>

/// Edges along which a surface folds up. A folded surface is refused, and that is known before anything is paid for,
/// with its derivative: searches keep to it as to a limit. So they do, where it is asked for, to a border of what is
/// held without a crease. Internal to the evaluator.
namespace strake {

class EdgeFolds {
public:
    static constexpr double folded = 170;  ///< degrees: dihedrals above it are refused
    static constexpr double kept = 168;    ///< that designs keep
    static constexpr double max_turn = Parameters::max_border_turn;
    /// Of which edges steps are told, and what they aim at, degrees.
    struct Angles {
        double nearly = 150, aimed = kept - 1;
    };

    /// An edge, and how its dihedral changes with its vertices and those opposite to it.
    struct Row {
        int edge = 0;  ///< of those that may fold
        /// Dihedral, degrees; at a border `kept` where it turns by `max_turn`, and 10 less for each degree less.
        double angle = 0;
        std::array<int, 4> vertices{};         ///< of the edge, then opposite to it in either triangle
        Eigen::Matrix<double, 4, 3> gradient;  ///< of the angle, degrees over length
        bool is_border = false;                ///< then of the last vertex alone
    };

    EdgeFolds() = default;                                                               ///< none
    explicit EdgeFolds(std::shared_ptr<const TriMesh> rest) : rest_(std::move(rest)) {}  ///< none yet
    /// @param excluded per triangle: edges at it are none that may fold; empty: no triangle.
    EdgeFolds(std::shared_ptr<const TriMesh> rest, const Adjacency& adjacent, const std::vector<char>& excluded);

    /// The same and edges between held and free triangles: normals of the free ones turn by at most `max_turn` from
    /// those of the datum.
    /// @param held per triangle: stays where it is
    EdgeFolds with_border(const Adjacency& adjacent, const std::vector<char>& held, const Points& datum) const;
    bool is_none() const { return hinges_.empty() && border_.empty(); }
    /// Edges with a dihedral above `degrees`, ascending. @param normal of all triangles
    std::vector<int> above(double degrees, const Points& normal) const;
    /// A border may have `kept` at most, whatever the degrees.
    bool any_above(double degrees, const Points& vertices) const;
    /// The same with derivatives, the largest first, at most `count`, no two at one vertex; then those of the border
    /// that turn by more than a tenth of `max_turn`, at most twice as many, no two at one free corner.
    std::vector<Row> rows(const Points& vertices, double degrees, int count) const;
    /// Of a border the held one first.
    std::array<int, 2> triangles(int edge) const;
    /// Its two vertices.
    std::array<int, 2> ends(int edge) const;

private:
    /// A free triangle beside a held one.
    struct Border {
        int held, free;
        Eigen::Vector3d normal;  ///< of the free one, on the datum
    };
    /// Signed, degrees, about the edge as the free triangle goes round it. @param normal of the free triangle
    double turn(const Border& border, const Points& vertices, const Eigen::Vector3d& normal) const;
    /// @param number in `border_`
    Row border_row(int number, const Points& vertices, const Eigen::Vector3d& normal, double turn) const;
    void add_border_rows(const Points& vertices, const Points& normal, double degrees, int count,
                         std::vector<Row>& chosen) const;
    std::array<int, 4> vertices(int edge) const;  ///< as in `Row`
    Points normals(const Points& vertices) const;
    Row row(int edge, const Points& vertices, double angle) const;

    std::shared_ptr<const TriMesh> rest_;
    std::vector<std::array<int, 2>> hinges_;  ///< triangles at interior edges whose dihedral is below 120 degrees
    std::vector<Border> border_;              ///< their edges follow those of the hinges
};

}  // namespace strake
