#pragma once
#include "core/mesh/adjacency.hpp"

namespace strake::mending {

/// What hangs together over edges of two triangles before something is joined.
class Joined {
public:
    explicit Joined(const Adjacency& before);

    /// Edges of `after` that are new between their triangles and that make a surface one-sided which was not: with the
    /// neighbours on all older edges agreeing, and on the new ones before it, its two triangles cannot. Ascending.
    /// @param parent per triangle of `after`: the one of `before` that it is, or is a piece of.
    std::vector<int> one_sided(const Adjacency& after, const std::vector<int>& parent) const;

private:
    std::vector<std::array<int, 2>> pairs_;  ///< of triangles, sorted
};

}  // namespace strake::mending
