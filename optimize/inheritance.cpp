#include "optimize/design_levels.hpp"

#include <Eigen/QR>

/// What a level takes over from the one above it: the same demand on the shell, in its own variables as far as it has
/// them, the rest carried.
namespace strake {
namespace {

/// The child's degrees of freedom that give every triangle what the parent's give it. Strains as the motion of the
/// child's core about its own centroid: tau_c = (exp(rho) - I)(c_c - c_P) + tau_P.
Eigen::VectorXd wanted_freedoms(const DesignSpace& parent, const Eigen::VectorXd& x, const DesignSpace& child) {
    const Eigen::VectorXd above = freedoms(parent, x);
    Eigen::VectorXd wanted = Eigen::VectorXd::Zero(child.num_freedoms());
    for (const Patch& patch : child.patches().patches) {
        const Eigen::Index at = slot::count * patch.id, from = slot::count * patch.parent;
        wanted.segment<4>(at + slot::load) = above.segment<4>(from + slot::load);
        wanted[at + slot::stiffness] = above[from + slot::stiffness];
        if (child.motion[patch.id] < 0 || parent.motion[patch.parent] < 0) continue;
        RigidMotion motion = parent.carried_motion[patch.parent];
        motion.rotation += above.segment<3>(from + slot::rotation);
        motion.translation += above.segment<3>(from + slot::translation);
        const double angle = motion.rotation.norm();
        const Eigen::Matrix3d turn = angle > 0 ? Eigen::AngleAxisd(angle, motion.rotation / angle).toRotationMatrix()
                                               : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
        const Eigen::Vector3d arm = child.carried_motion[patch.id].about - motion.about;
        wanted.segment<3>(at + slot::rotation) = motion.rotation;
        wanted.segment<3>(at + slot::translation) = turn * arm - arm + motion.translation;
    }
    return wanted;
}

/// Degrees of freedom from variables, num_freedoms() x size().
Eigen::MatrixXd moves_matrix(const DesignSpace& space) {
    Eigen::MatrixXd moves = Eigen::MatrixXd::Zero(space.num_freedoms(), space.size());
    for (int j = 0; j < space.size(); ++j)
        for (const Freedom& move : space.variables[j].moves)
            moves(move.index, j) += space.variables[j].unit * move.factor;
    return moves;
}

/// x whose degrees of freedom come closest to the wanted ones.
class Expression {
public:
    explicit Expression(const DesignSpace& space) : space_(space) {
        std::vector<int> users(space.num_freedoms(), 0);
        for (const Variable& variable : space.variables) {
            is_simple_ &= variable.moves.size() == 1;
            for (const Freedom& move : variable.moves) is_simple_ &= ++users[move.index] == 1;
        }
        if (!is_simple_) solver_.compute(moves_matrix(space));
    }
    Eigen::VectorXd operator()(const Eigen::VectorXd& wanted) const {
        if (!is_simple_) return solver_.solve(wanted);
        Eigen::VectorXd x(space_.size());
        for (int j = 0; j < space_.size(); ++j) {
            const Freedom& move = space_.variables[j].moves.front();
            x[j] = wanted[move.index] / (space_.variables[j].unit * move.factor);
        }
        return x;
    }

private:
    const DesignSpace& space_;
    bool is_simple_ = true;
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver_;
};

/// Keeps what the child's variables cannot say.
void carry(DesignSpace& child, const Eigen::VectorXd& left) {
    for (const Patch& patch : child.patches().patches) {
        const Eigen::Index at = slot::count * patch.id;
        const Eigen::RowVector3d load = left.segment<3>(at + slot::load).transpose();
        const double normal = left[at + slot::normal];
        for (const int t : patch.triangles) child.carried_traction.row(t) += load + normal * child.rest->normal.row(t);
        if (child.motion[patch.id] >= 0) {
            child.carried_motion[patch.id].rotation += left.segment<3>(at + slot::rotation);
            child.carried_motion[patch.id].translation += left.segment<3>(at + slot::translation);
        }
        if (child.carried_log_height.size() > 0)
            for (const int t : patch.triangles) child.carried_log_height[t] += left[at + slot::stiffness];
    }
}

Eigen::MatrixXd prolongation_at(const DesignSpace& parent, const Eigen::VectorXd& x, const DesignSpace& child,
                                const Expression& express) {
    // Linear but for strains, where the second order of a step of 1e-5 is below what a preconditioner notices.
    constexpr double step = 1e-5;
    Eigen::MatrixXd prolongation(child.size(), parent.size());
    for (int i = 0; i < parent.size(); ++i) {
        Eigen::VectorXd up = x, down = x;
        up[i] += step;
        down[i] -= step;
        prolongation.col(i) =
            express((wanted_freedoms(parent, up, child) - wanted_freedoms(parent, down, child)) / (2 * step));
    }
    return prolongation;
}

}  // namespace

InheritedSpace refine(const DesignSpace& parent, const Eigen::VectorXd& x) {
    return refine(parent, x, front_at(*parent.rest->tree, parent.level + 1));
}

InheritedSpace refine(const DesignSpace& parent, const Eigen::VectorXd& x, const Front& front) {
    InheritedSpace result{make_space(parent.rest, parent.level + 1, front, &parent), {}, {}};
    DesignSpace& child = result.space;
    const int m = parent.rest->surface.num_triangles();
    child.carried_traction = parent.carried_traction.rows() > 0 ? parent.carried_traction : Points(Points::Zero(m, 3));
    if (parent.changes_height())
        child.carried_log_height = parent.carried_log_height.size() > 0 ? parent.carried_log_height
                                                                        : Eigen::VectorXd(Eigen::VectorXd::Zero(m));
    const Expression express(child);
    const Eigen::VectorXd wanted = wanted_freedoms(parent, x, child);
    result.x = express(wanted);
    Eigen::VectorXd left = wanted;
    for (int j = 0; j < child.size(); ++j)
        for (const Freedom& move : child.variables[j].moves)
            left[move.index] -= result.x[j] * child.variables[j].unit * move.factor;
    for (Eigen::Index i = 0; i < left.size(); ++i)
        if (std::abs(left[i]) <= 1e-14 * std::abs(wanted[i])) left[i] = 0;  // round-off is not carried
    carry(child, left);
    result.prolongation = prolongation_at(parent, x, child, express);
    if (child.carried_traction.isZero(0)) child.carried_traction.resize(0, 3);
    child.lower = child.lower.cwiseMin(result.x);
    child.upper = child.upper.cwiseMax(result.x);
    return result;
}

}  // namespace strake
