#pragma once
#include "core/mesh/adjacency.hpp"

#include <array>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

/// Where a surface pierces or touches itself at rest: parts that pass through each other, T-junctions, doubled faces.
namespace strake {

/// When such a surface is moved by a one-to-one map of space, its cuts stay where they are on it, up to the chord
/// error: flat triangles do not follow the map. By that much a cut may wander to other triangles, and what touched may
/// come to overlap. These are no new intersections.
class Contacts {
public:
    /// @param intersecting pairs of triangles at rest.
    Contacts(std::shared_ptr<const TriMesh> rest, const Adjacency& adjacent,
             std::vector<std::array<int, 2>> intersecting);

    /// Triangles s and t lie at a contact: they belong to two connected parts that pierce each other, have neighbours
    /// (sharing a vertex) that intersect, or touch at rest: closer than 1e-5 of the diagonal, as open edges that count
    /// as one. Those that share a corner touch where another corner of one lies on the other, as at a T-junction.
    bool is_near(int s, int t) const;

    /// Distance of two triangles at rest.
    double distance(int s, int t) const;

private:
    bool shares_vertex(int s, int t) const;
    bool touches(int s, int t) const;
    double corner_distance(int v, int t) const;

    const Triangles& triangles() const { return rest_->triangles; }

    std::shared_ptr<const TriMesh> rest_;
    double touching_;
    std::vector<int> component_;                 ///< per triangle: its connected part
    std::set<std::pair<int, int>> piercing_;     ///< of them, the smaller number first
    std::map<int, std::vector<int>> partners_;   ///< of triangles: those that they intersect at rest
    std::map<int, std::vector<int>> at_vertex_;  ///< of vertices: their triangles with partners
};

}  // namespace strake
