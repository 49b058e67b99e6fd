#pragma once
#include "core/patches/hierarchy.hpp"

#include <limits>

/// The contribution of each patch's motion: the change of the objective along the path of accepted designs, integrated
/// as (dJ/dv before + dJ/dv after) / 2 . (v after - v before), vertex by vertex. Shares of disjoint patches add up; the
/// rest of the total change is the integration error and the effect of variables other than shape.
namespace strake {

struct PatchShare {
    int triangles = 0;
    double area = 0;              ///< at the start, length squared
    double contribution = 0;      ///< to the change of the objective; NaN: sensitivities unknown
    double mean_outward = 0;      ///< final displacement along the start normals, mean over the area, length
    double max_displacement = 0;  ///< length
};

class PatchShares {
public:
    explicit PatchShares(const TriMesh& start);
    /// The next design on the path. @param dJ_dv n x 3, or empty if unknown.
    void add(const Points& displacement, const Points& dJ_dv, double objective);

    /// For each patch of a level. A vertex between patches counts for each in proportion to its triangles there.
    std::vector<PatchShare> of(const PatchLevel& level) const;
    /// Change of the objective along the path, and the part of it that the shares explain; NaN: unknown.
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
