#pragma once
#include "core/patches/hierarchy.hpp"

#include <limits>

/// What the motion of each patch has brought: the change of the objective along the path of accepted designs,
/// integrated as (dJ/dv before + dJ/dv after) / 2 . (v after - v before), vertex by vertex. Shares of disjoint patches
/// add up; what they leave of the whole change is the integration's error and what variables other than shape did.
namespace strake {

struct PatchShare {
    int triangles = 0;
    double area = 0;          ///< at the start, length squared
    double contribution = 0;  ///< to the change of the objective; NaN: sensitivities are not known
    double mean_outward = 0;  ///< displacement at the end along the normals of the start, mean over the area, length
    double most_moved = 0;    ///< length
};

class PatchShares {
public:
    explicit PatchShares(const TriMesh& start);
    /// The next design on the path. @param dJ_dv n x 3, or empty where it is not known.
    void add(const Points& displacement, const Points& dJ_dv, double objective);

    /// Of each patch of a level. Vertices between patches count for each in proportion to its triangles there.
    std::vector<PatchShare> of(const PatchLevel& level) const;
    /// Change of the objective along the path, and how much of it the shares hold; NaN: not known.
    double change() const { return last_ - first_; }
    double explained() const;

private:
    TriMesh start_;
    Eigen::VectorXd contribution_;  ///< per vertex
    Points displacement_, dJ_dv_;   ///< of the last design
    double first_ = std::numeric_limits<double>::quiet_NaN(), last_ = first_;
    bool is_known_ = true;
};

}  // namespace strake
