#include "optimize/space/design_levels.hpp"

#include <Eigen/QR>
#include <utility>

/// What a level takes over from the one above it: the same demand on the shell, in its own variables where it has
/// them, the rest carried.
namespace strake {
namespace {

/// The child's degrees of freedom that give every triangle what the parent's give it. Strains as the motion of the
/// child's core about its own centroid: tau_c = (exp(rho) - I)(c_c - c_P) + tau_P.
Eigen::VectorXd wanted_dofs(const DesignSpace& parent, const Eigen::VectorXd& x, const DesignSpace& child) {
    const Eigen::VectorXd above = dofs(parent, x);
    Eigen::VectorXd wanted = Eigen::VectorXd::Zero(child.num_dofs());
    for (const Patch& patch : child.patches().patches) {
        const Eigen::Index at = patch_dof::count * patch.id, from = patch_dof::count * patch.parent;
        wanted.segment<4>(at + patch_dof::load) = above.segment<4>(from + patch_dof::load);
        wanted[at + patch_dof::stiffness] = above[from + patch_dof::stiffness];
        if (child.motion[patch.id] < 0 || parent.motion[patch.parent] < 0) continue;
        RigidMotion motion = parent.carried_motion[patch.parent];
        motion.rotation += above.segment<3>(from + patch_dof::rotation);
        motion.translation += above.segment<3>(from + patch_dof::translation);
        const double angle = motion.rotation.norm();
        const Eigen::Matrix3d turn = angle > 0 ? Eigen::AngleAxisd(angle, motion.rotation / angle).toRotationMatrix()
                                               : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
        const Eigen::Vector3d arm = child.carried_motion[patch.id].about - motion.about;
        wanted.segment<3>(at + patch_dof::rotation) = motion.rotation;
        wanted.segment<3>(at + patch_dof::translation) = turn * arm - arm + motion.translation;
    }
    wanted.tail(child.carried_user_values.size()) = parent.user_values(above);
    return wanted;
}

/// Degrees of freedom from variables, num_dofs() x variables.
Eigen::MatrixXd moves_matrix(const DesignSpace& space, const std::vector<Variable>& variables) {
    Eigen::MatrixXd moves = Eigen::MatrixXd::Zero(space.num_dofs(), static_cast<Eigen::Index>(variables.size()));
    for (std::size_t j = 0; j < variables.size(); ++j)
        for (const DegreeOfFreedom& move : variables[j].moves)
            moves(move.index, static_cast<Eigen::Index>(j)) += variables[j].unit * move.factor;
    return moves;
}

/// x whose degrees of freedom come closest to the wanted ones; parameters have none and are left at 0. What falls to
/// dependent variables goes to those that do the same.
class Expression {
public:
    explicit Expression(const DesignSpace& space)
        : space_(space), all_(space.variables.begin(), space.variables.begin() + space.num_shape()) {
        for (const DependentVariable& other : space.dependent) all_.push_back(other.variable);
        std::vector<int> users(space.num_dofs(), 0);
        for (const Variable& variable : all_) {
            is_simple_ &= variable.moves.size() == 1;
            for (const DegreeOfFreedom& move : variable.moves) is_simple_ &= ++users[move.index] == 1;
        }
        if (!is_simple_) solver_.compute(moves_matrix(space, all_));
    }
    Eigen::VectorXd operator()(const Eigen::VectorXd& wanted) const {
        const Eigen::VectorXd of_all = is_simple_ ? one_by_one(wanted) : Eigen::VectorXd(solver_.solve(wanted));
        Eigen::VectorXd x = Eigen::VectorXd::Zero(space_.size());
        x.head(space_.num_shape()) = of_all.head(space_.num_shape());
        for (std::size_t d = 0; d < space_.dependent.size(); ++d)
            x.head(space_.num_shape()) +=
                of_all[space_.num_shape() + static_cast<Eigen::Index>(d)] * space_.dependent[d].share;
        return x;
    }

private:
    Eigen::VectorXd one_by_one(const Eigen::VectorXd& wanted) const {
        Eigen::VectorXd x(static_cast<Eigen::Index>(all_.size()));
        for (std::size_t j = 0; j < all_.size(); ++j) {
            const DegreeOfFreedom& move = all_[j].moves.front();
            x[static_cast<Eigen::Index>(j)] = wanted[move.index] / (all_[j].unit * move.factor);
        }
        return x;
    }

    const DesignSpace& space_;
    std::vector<Variable> all_;  ///< of the shape, then the dependent ones
    bool is_simple_ = true;
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver_;
};

/// Keeps what the child's variables cannot say.
void carry(DesignSpace& child, const Eigen::VectorXd& left) {
    for (const Patch& patch : child.patches().patches) {
        const Eigen::Index at = patch_dof::count * patch.id;
        const Eigen::RowVector3d load = left.segment<3>(at + patch_dof::load).transpose();
        const double normal = left[at + patch_dof::normal];
        for (const int t : patch.triangles) child.carried_traction.row(t) += load + normal * child.rest->normal.row(t);
        if (child.motion[patch.id] >= 0) {
            child.carried_motion[patch.id].rotation += left.segment<3>(at + patch_dof::rotation);
            child.carried_motion[patch.id].translation += left.segment<3>(at + patch_dof::translation);
        }
        if (child.carried_log_height.size() > 0)
            for (const int t : patch.triangles) child.carried_log_height[t] += left[at + patch_dof::stiffness];
    }
    child.carried_user_values += child.user_values(left);
}

/// Fields that are variables again have the values that were carried while they rested.
void take_up_fields(DesignSpace& child, Eigen::VectorXd& wanted) {
    for (const Variable& variable : child.variables) {
        if (variable.kind != VariableKind::field) continue;
        for (const DegreeOfFreedom& move : variable.moves) {
            double& carried = child.carried_user_values[move.index - child.num_patch_dofs()];
            wanted[move.index] += std::exchange(carried, 0);
        }
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
        prolongation.col(i) = express((wanted_dofs(parent, up, child) - wanted_dofs(parent, down, child)) / (2 * step));
    }
    const int own = child.num_parameters();
    prolongation.bottomRows(own).setZero();
    prolongation.bottomRightCorner(own, own).setIdentity();
    return prolongation;
}

}  // namespace

InheritedSpace refine(const DesignSpace& parent, const Eigen::VectorXd& x) {
    return refine(parent, x, level_set(*parent.rest, parent.level + 1));
}

InheritedSpace refine(const DesignSpace& parent, const Eigen::VectorXd& x, const Front& front) {
    return refine(parent, x, {front, parent.fields, true});
}

InheritedSpace refine(const DesignSpace& parent, const Eigen::VectorXd& x, const LevelSet& next) {
    LevelSet set = next;
    for (Patch& patch : set.front.patches.patches)  // its parents may be those of a space further up
        patch.parent = parent.patches().label[static_cast<std::size_t>(patch.triangles.front())];
    InheritedSpace result{make_space(parent.rest, parent.level + 1, set, &parent), {}, {}};
    DesignSpace& child = result.space;
    const int m = parent.rest->elastic().num_triangles();
    child.carried_traction = parent.carried_traction.rows() > 0 ? parent.carried_traction : Points(Points::Zero(m, 3));
    if (parent.changes_height())
        child.carried_log_height = parent.carried_log_height.size() > 0 ? parent.carried_log_height
                                                                        : Eigen::VectorXd(Eigen::VectorXd::Zero(m));
    child.carried_user_values = parent.carried_user_values;
    const Expression express(child);
    Eigen::VectorXd wanted = wanted_dofs(parent, x, child);
    if (set.takes_up) take_up_fields(child, wanted);
    result.x = express(wanted);
    result.x.tail(child.num_parameters()) = x.tail(parent.num_parameters());
    Eigen::VectorXd left = wanted;
    for (int j = 0; j < child.size(); ++j)
        for (const DegreeOfFreedom& move : child.variables[j].moves)
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
