#pragma once
#include "core/mesh/adjacency.hpp"

namespace strake::mending {

/// Connectivity over edges of two triangles, before joining.
class Joined {
public:
    explicit Joined(const Adjacency& before);

    /// New edges of `after` that make a surface one-sided: with all older edges and earlier new ones consistent, their
    /// two triangles cannot agree. Ascending.
    /// @param parent per triangle of `after`: its triangle of `before`.
    std::vector<int> one_sided(const Adjacency& after, const std::vector<int>& parent) const;

private:
    std::vector<std::array<int, 2>> pairs_;  ///< of triangles, sorted
};

}  // namespace strake::mending
