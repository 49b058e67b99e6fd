#pragma once
#include "core/remesh/working_mesh.hpp"

/// Self-intersections that the input did not have. Internal to core/remesh.
namespace strake {

class Crossings {
public:
    explicit Crossings(const BaseSurface& base) : base_(base) {}
    /// Pairs of triangles that intersect because of remeshing.
    std::vector<std::array<int, 2>> fresh(const WorkingMesh& mesh);
    /// Sets `marks` of the triangles of the input that lie within `reach` of the box of a pair.
    void mark_beside(const WorkingMesh& mesh, const std::array<int, 2>& pair, double reach,
                     std::vector<char>& marks) const;

private:
    void look_at_input();
    bool is_old(const WorkingMesh& mesh, const std::array<int, 2>& pair) const;
    const BaseSurface& base_;
    std::vector<char> crossing_;  ///< triangles of the input at its own intersections; empty: not computed
    int input_pairs_ = 0;         ///< intersections of the input, once computed
};

}  // namespace strake
