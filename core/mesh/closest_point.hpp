#pragma once
#include "core/mesh/mesh.hpp"

#include <memory>

/// Closest point on a triangulation.
namespace strake {

struct ClosestPoint {
    Eigen::Vector3d point;
    int triangle = -1;  ///< tie: the smallest number
    int corner_a = -1,
        corner_b = -1;  ///< local corners of the closest edge (both), vertex (corner_a), or face (neither)
    double distance = 0;
};

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
