#pragma once
#include "core/primo/energy.hpp"

/// Loops over the faces and prisms of a shell, four Gauss points at a time; energy.hpp defines the results.
namespace strake {

/// Jumps at the shared faces.
void face_jumps(const RestState& rest, const Poses& poses, const std::vector<Eigen::Matrix3d>& turn,
                std::vector<Quad>& jump);
void face_jump_rates(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const Eigen::VectorXd& twist,
                     std::vector<Quad>& rate);
/// Torque and force of the shared faces on each prism.
void face_wrenches(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const std::vector<Quad>& jump,
                   Wrenches& wrench);

/// Terms of a prism's diagonal block: sums over its points, of stiffness and of forces f at arms a.
struct OwnBlock {
    double square[6] = {};  ///< sum w a a^T: xx, yy, zz, xy, yz, zx
    double arm[3] = {};     ///< sum w a
    double weight = 0;      ///< sum w
    double moment[6] = {};  ///< symmetric part of sum f a^T

    OwnBlock& operator+=(const OwnBlock& other);
    void add_moment(const Eigen::Vector3d& f, const Eigen::Vector3d& a);
};
/// Blocks between free prisms that share a face, and the faces' share of their diagonal blocks. @param is_sum adds to
/// `below`, for prisms that share several faces; false: overwrites it
void add_face_blocks(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const std::vector<Quad>& stress,
                     bool is_sum, std::vector<OwnBlock>& own, std::vector<Matrix6>& below, const BlockMatrix& pattern);

/// Sum of R x - x + u over the prisms of vertex k.
void vertex_sums(const RestState& rest, const Poses& poses, const std::vector<Eigen::Matrix3d>& turn, Points& sum);

}  // namespace strake
