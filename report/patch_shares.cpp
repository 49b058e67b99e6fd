#include "report/patch_shares.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace strake {

PatchShares::PatchShares(const TriMesh& start)
    : start_(start), contribution_(Eigen::VectorXd::Zero(start.num_vertices())) {}

void PatchShares::add(const Points& displacement, const Points& dJ_dv, double objective) {
    if (displacement_.rows() > 0) {
        const Points moved = displacement - displacement_;
        // If the sensitivities at one end are unknown, use those of the other.
        const bool before = dJ_dv_.rows() > 0, after = dJ_dv.rows() > 0;
        if (before && after)
            contribution_ += 0.5 * (dJ_dv_ + dJ_dv).cwiseProduct(moved).rowwise().sum();
        else if (before || after)
            contribution_ += (before ? dJ_dv_ : dJ_dv).cwiseProduct(moved).rowwise().sum();
        else
            is_known_ = false;
    }
    if (!std::isfinite(first_)) first_ = objective;
    last_ = objective;
    displacement_ = displacement;
    dJ_dv_ = dJ_dv;
}

double PatchShares::explained() const {
    return is_known_ && std::isfinite(first_) ? contribution_.sum() : std::numeric_limits<double>::quiet_NaN();
}

std::vector<PatchShare> PatchShares::of(const PatchLevel& level) const {
    Eigen::VectorXd uses = Eigen::VectorXd::Zero(start_.num_vertices());
    for (Eigen::Index k = 0; k < start_.triangles.size(); ++k) uses[start_.triangles.data()[k]] += 1;
    std::vector<PatchShare> shares(level.patches.size());
    const bool has_moved = displacement_.rows() > 0;
    for (int t = 0; t < start_.num_triangles(); ++t) {
        PatchShare& share = shares[static_cast<std::size_t>(level.label[static_cast<std::size_t>(t)])];
        Eigen::Vector3d corner[3], moved = Eigen::Vector3d::Zero();
        for (int k = 0; k < 3; ++k) {
            const int v = start_.triangles(t, k);
            corner[k] = start_.vertices.row(v);
            if (!has_moved) continue;
            share.contribution += contribution_[v] / uses[v];
            moved += displacement_.row(v).transpose() / 3;
            share.max_displacement = std::max(share.max_displacement, displacement_.row(v).norm());
        }
        const Eigen::Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]) / 2;
        ++share.triangles;
        share.area += normal.norm();
        share.mean_outward += moved.dot(normal);
    }
    for (PatchShare& share : shares) {
        share.mean_outward = share.area > 0 ? share.mean_outward / share.area : 0;
        if (!is_known_ || !has_moved) share.contribution = std::numeric_limits<double>::quiet_NaN();
    }
    return shares;
}

}  // namespace strake
