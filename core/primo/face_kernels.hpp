#pragma once
#include "core/primo/energy.hpp"

/// The loops over all faces and prisms of a shell, four Gauss points at a time; what they compute stands in energy.hpp.
namespace strake {

/// Gaping of the shared faces.
void face_jumps(const RestState& rest, const Poses& poses, const std::vector<Eigen::Matrix3d>& turn,
                std::vector<Quad>& jump);
void face_jump_rates(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const Eigen::VectorXd& twist,
                     std::vector<Quad>& rate);
/// Torque and force of the shared faces on each prism.
void face_wrenches(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const std::vector<Quad>& jump,
                   Wrenches& wrench);

/// What a prism's diagonal block is made of: sums over its own points, of stiffness and of forces f at arms a.
struct OwnBlock {
    double square[6] = {};  ///< sum w a a^T: xx, yy, zz, xy, yz, zx
    double arm[3] = {};     ///< sum w a
    double weight = 0;      ///< sum w
    double moment[6] = {};  ///< symmetric part of sum f a^T

    OwnBlock& operator+=(const OwnBlock& other);
    void add_moment(const Eigen::Vector3d& f, const Eigen::Vector3d& a);
};
/// Blocks between free prisms that share a face, and what the faces add to their own. @param is_sum two prisms may
/// share several faces: `below` is added to, else written
void add_face_blocks(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const std::vector<Quad>& stress,
                     bool is_sum, std::vector<OwnBlock>& own, std::vector<Matrix6>& below, const BlockMatrix& pattern);

/// Sum of R x - x + u over the prisms of vertex k.
void vertex_sums(const RestState& rest, const Poses& poses, const std::vector<Eigen::Matrix3d>& turn, Points& sum);

}  // namespace strake
