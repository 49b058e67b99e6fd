#pragma once
#include "core/mesh/point_triangle.hpp"

#include <memory>

/// Closest point on a triangulation.
namespace strake {

/// A tree over a copy of the triangles; queries are exact in double precision and thread-safe.
class ClosestPointTree {
public:
    explicit ClosestPointTree(const TriMesh& mesh);  ///< @throws InvalidInput without triangles
    ~ClosestPointTree();
    ClosestPoint find(const Eigen::Vector3d& x) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace strake
