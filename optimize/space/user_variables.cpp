#include "optimize/space/user_variables.hpp"

namespace strake {

void add_user_traction(const RestFacts& rest, const Eigen::VectorXd& values, Points& traction) {
    for (Eigen::Index g = 0; g < values.size(); ++g) {
        const UserVariable& v = rest.parameters.user_variables[g];
        if (values[g] == 0 || v.traction.rows() == 0) continue;
        for (std::size_t i = 0; i < v.triangles.size(); ++i)
            traction.row(v.triangles[i]) += values[g] * v.traction.row(static_cast<Eigen::Index>(i));
    }
}

void add_user_motions(const RestFacts& rest, const Eigen::VectorXd& values, std::vector<RigidMotion>& motions) {
    for (Eigen::Index g = 0; g < values.size(); ++g) {
        if (rest.setup.user_motion[g] < 0) continue;
        motions[rest.setup.user_motion[g]].rotation += values[g] * rest.parameters.user_variables[g].motion.rotation;
        motions[rest.setup.user_motion[g]].translation +=
            values[g] * rest.parameters.user_variables[g].motion.translation;
    }
}

Eigen::RowVector3d traction_gradient(const RestFacts& rest, const Points& dJ_dF, int triangle) {
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (int k = 0; k < 3; ++k) sum += rest.area[triangle] / 3 * dJ_dF.row(rest.elastic().triangles(triangle, k));
    return sum;
}

void add_user_gradient(const RestFacts& rest, int first, const std::vector<RigidMotion>& motions,
                       const ShellSensitivities& sensitivities, Eigen::VectorXd& gradient) {
    const auto& user = rest.parameters.user_variables;
    for (std::size_t g = 0; g < user.size(); ++g) {
        double& sum = gradient[first + static_cast<int>(g)];
        if (rest.setup.user_motion[g] < 0) {
            for (std::size_t i = 0; i < user[g].triangles.size(); ++i)
                sum += traction_gradient(rest, sensitivities.force, user[g].triangles[i])
                           .dot(user[g].traction.row(static_cast<Eigen::Index>(i)));
            continue;
        }
        if (sensitivities.wrench.rows() == 0) continue;
        Eigen::Matrix<double, 6, 1> rate;
        rate << user[g].motion.rotation, user[g].motion.translation;
        for (const int t : rest.setup.user_pinned[g]) {
            Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
            for (int k = 0; k < 3; ++k) centroid += rest.elastic().vertices.row(rest.elastic().triangles(t, k)) / 3;
            sum += sensitivities.wrench.row(t).dot(motion_twist(motions[rest.setup.user_motion[g]], centroid) * rate);
        }
    }
}

}  // namespace strake
