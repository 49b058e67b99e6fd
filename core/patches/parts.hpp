#pragma once
#include "core/patches/creases.hpp"

#include <vector>

/// Splits sets of triangles, for automatic levels. All functions work within one set of s triangles and cost O(s log
/// s).
namespace strake {

using TriangleSet = std::vector<int>;  ///< ascending

/// Scratch labels over the whole surface: of the current set's triangles; -1 elsewhere.
class Parts {
public:
    Parts(const Body& body, const Creases& creases);

    /// Splits `set` into pieces: edge-connected parts of equal `key` (aligned with `set`; -1 joins the nearest along
    /// the surface), optionally stopping at creases; then parts smaller than `min_area` join, smallest first, the
    /// neighbour they share most smooth border with, or the nearest part if they have none.
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
