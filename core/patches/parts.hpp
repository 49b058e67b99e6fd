#pragma once
#include "core/patches/creases.hpp"

#include <vector>

/// Sets of triangles and how they fall apart: the tools of automatic levels. All work within one set and cost
/// O(s log s) for its s triangles.
namespace strake {

using TriangleSet = std::vector<int>;  ///< ascending

/// Scratch over the whole surface: what the triangles of the set at hand are labelled with; -1 elsewhere.
class Parts {
public:
    Parts(const Body& body, const Creases& creases);

    /// Splits `set` into pieces: edge-connected parts of equal `key` (aligned with `set`; -1 belongs to whoever is
    /// nearest along the surface), stopping at creases if asked; then parts smaller than `min_area` join, smallest
    /// first, the neighbour they share most smooth border with, or the nearest part if they have none.
    std::vector<TriangleSet> split(const TriangleSet& set, const std::vector<int>& key, bool at_creases,
                                   double min_area);
    double area(const TriangleSet& set) const;

private:
    int flood(const TriangleSet& set, const std::vector<int>& key, bool at_creases);
    int grow(const TriangleSet& set, int count);
    void absorb(const TriangleSet& set, int count, double min_area);

    const Body& body_;
    const Creases& creases_;
    std::vector<int> label_, key_;
    std::vector<double> reached_;
};

}  // namespace strake
