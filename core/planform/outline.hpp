#pragma once
#include "core/mesh/mesh.hpp"
#include "core/planform/varying.hpp"

#include <string>
#include <vector>

/// Plane sections of a surface as ordered outlines. Internal to core/planform.
namespace strake {

/// The listed triangles of a part, ascending; all, if none is listed. @throws InvalidInput, which begins with `part`.
std::vector<int> part_of(const TriMesh& mesh, std::vector<int> listed, const std::string& part);

/// n . v of vertex v with its derivatives.
Varying component(const TriMesh& mesh, int v, const Eigen::Vector3d& n, bool sensitivities);

/// A plane n . x = offset, with the directions along the stream and up in it.
struct SectionFrame {
    Eigen::Vector3d normal, downstream, up;  ///< unit, perpendicular to each other
    Varying offset;
};

/// Points of an outline in order.
struct Outline {
    std::vector<PlanePoint> points;
    bool is_closed = false;  ///< the last is joined to the first
};

struct CutOptions {
    bool sensitivities = false;
    double join = 0;  ///< ends of open outlines closer than this are joined: cracks of the surface
};

/// Where the plane cuts the listed triangles. Each point lies on an edge from a (distance below the plane's offset) to
/// b: p = a + (offset - n . a) / (n . (b - a)) (b - a), with derivatives by both and by the offset. Vertices in the
/// plane count as above it. Outlines are in the order of their first triangle;
/// where some are closed, open ones that go one way (wakes) are left out.
std::vector<Outline> cut(const TriMesh& mesh, const std::vector<int>& triangles, const SectionFrame& frame,
                         const CutOptions& options = {});

}  // namespace strake
