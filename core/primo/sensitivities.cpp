#include "core/error.hpp"
#include "core/primo/conjugate_gradients.hpp"
#include "core/primo/shell_impl.hpp"

/// Derivatives at an equilibrium g(T, x) = 0: tangent solves forward, one adjoint solve per functional backward.
namespace strake {
namespace {

using Eigen::Vector3d;

constexpr double exact = 1e-10;  // relative, in the energy norm; limited by round-off
constexpr int block_width = 16;  // right-hand sides at once: bounds the memory of a block of substitutions

void check_count(const RestState& rest, const Points& field, const char* what) {
    if (field.rows() != rest.mesh.num_vertices())
        throw InvalidInput(
            text("shell: ", what, " has ", field.rows(), " rows for ", rest.mesh.num_vertices(), " vertices"));
    if (!field.allFinite()) throw InvalidInput(text("shell: ", what, " is not finite"));
}

/// Wrenches on the pinned prisms when the free ones move with `twist`: H_pf twist, m x 6. The energy's cross terms are
/// bilinear in the poses: these blocks are exact.
Eigen::MatrixXd pinned_wrenches(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn,
                                const Eigen::VectorXd& twist) {
    Eigen::MatrixXd wrench = Eigen::MatrixXd::Zero(rest.num_prisms(), 6);
    const auto add = [&](int p, const Arms& arm_p, int f, const Arms& arm_f, double weight) {
        const Eigen::VectorXd motion = twist.segment<6>(6 * rest.free_index[f]);
        for (int g = 0; g < 4; ++g) {
            const Vector3d a = turned(turn[p], arm_p[g]), b = turned(turn[f], arm_f[g]);
            const Vector3d force = -weight / 2 * (Vector3d(motion.head<3>()).cross(b) + motion.tail<3>());
            wrench.row(p).head<3>() += a.cross(force);
            wrench.row(p).tail<3>() += force;
        }
    };
    for (const SharedFace& face : rest.faces) {
        const bool i = rest.free_index[face.i] >= 0, j = rest.free_index[face.j] >= 0;
        if (!i && j) add(face.i, face.arm_i, face.j, face.arm_j, face.weight);
        if (i && !j) add(face.j, face.arm_j, face.i, face.arm_i, face.weight);
    }
    return wrench;
}

/// Forces on the free prisms when the pinned ones move with `twist` (m x 6): H_fp twist.
Eigen::VectorXd free_wrenches(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn,
                              const Eigen::MatrixXd& twist) {
    Eigen::VectorXd wrench = Eigen::VectorXd::Zero(6 * rest.num_free());
    const auto add = [&](int f, const Arms& arm_f, int p, const Arms& arm_p, double weight) {
        for (int g = 0; g < 4; ++g) {
            const Vector3d a = turned(turn[f], arm_f[g]), b = turned(turn[p], arm_p[g]);
            const Vector3d force =
                -weight / 2 * (Vector3d(twist.row(p).head<3>()).cross(b) + twist.row(p).tail<3>().transpose());
            wrench.segment<3>(6 * rest.free_index[f]) += a.cross(force);
            wrench.segment<3>(6 * rest.free_index[f] + 3) += force;
        }
    };
    for (const SharedFace& face : rest.faces) {
        const bool i = rest.free_index[face.i] >= 0, j = rest.free_index[face.j] >= 0;
        if (i && !j) add(face.i, face.arm_i, face.j, face.arm_j, face.weight);
        if (!i && j) add(face.j, face.arm_j, face.i, face.arm_i, face.weight);
    }
    return wrench;
}

/// dJ/d(twist) of the pinned prisms through the vertices that follow them, m x 6.
Eigen::MatrixXd pinned_vertex_wrenches(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn,
                                       const Points& dJ_dv) {
    Eigen::MatrixXd wrench = Eigen::MatrixXd::Zero(rest.num_prisms(), 6);
    for (int k = 0; k < rest.mesh.num_vertices(); ++k) {
        const auto prisms = rest.vertex_prisms[k];
        if (prisms.empty() || rest.pin[prisms[0]] == free_prism) continue;
        Vector3d force = dJ_dv.row(k).transpose() / static_cast<double>(prisms.size());
        if (rest.on_plane[k]) force = rest.plane_projector * force;
        for (const int i : prisms) {
            wrench.row(i).head<3>() += turned(turn[i], rest.vertex_arm(k, i)).cross(force);
            wrench.row(i).tail<3>() += force;
        }
    }
    return wrench;
}

/// -y^T dg/dh: the energy depends on h through the Gauss points X of the faces alone.
Eigen::VectorXd height_sensitivities(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const Jumps& jump,
                                     const Eigen::VectorXd& y) {
    Eigen::VectorXd dJ_dh = Eigen::VectorXd::Zero(rest.mesh.num_vertices());
    const Jumps rate = jump_rates(rest, turn, y);
    const auto spin = [&](int i) {
        return rest.free_index[i] < 0 ? Vector3d(Vector3d::Zero()) : Vector3d(y.segment<3>(6 * rest.free_index[i]));
    };
    const auto rotate = [&](int i, const Vector3d& x) { return turned(turn[i], x); };
    for (std::size_t f = 0; f < rest.faces.size(); ++f) {
        const SharedFace& face = rest.faces[f];
        for (int g = 0; g < 4; ++g) {
            const auto [u, z] = gauss_points()[g];
            const Vector3d r = jump.face[f][g], dr = rate.face[f][g];
            for (int k = 0; k < 2; ++k) {
                const Vector3d dX = 0.5 * z * (k == 0 ? 1 - u : u) * face.normal[k];
                const Vector3d jump = turn[face.i] * dX - turn[face.j] * dX;
                const Vector3d jump_rate =
                    spin(face.i).cross(rotate(face.i, dX)) - spin(face.j).cross(rotate(face.j, dX));
                dJ_dh[face.vertex[k]] -= face.weight / 2 * (jump.dot(dr) + jump_rate.dot(r));
            }
        }
    }
    for (std::size_t f = 0; f < rest.mirrored.size(); ++f) {
        const MirroredFace& face = rest.mirrored[f];
        const Vector3d n = rest.symmetry->normal;
        for (int g = 0; g < 4; ++g) {
            const auto [u, z] = gauss_points()[g];
            for (int k = 0; k < 2; ++k) {
                const Vector3d dX = 0.5 * z * (k == 0 ? 1 - u : u) * face.normal[k];
                dJ_dh[face.vertex[k]] -=
                    face.weight * (n.dot(turn[face.i] * dX) * rate.mirrored[4 * f + g] +
                                   n.dot(spin(face.i).cross(rotate(face.i, dX))) * jump.mirrored[4 * f + g]);
            }
        }
    }
    return dJ_dh;
}

/// Adjoints of the previous design, rotated with the prisms: neighbouring designs have nearly the same.
Eigen::MatrixXd last_adjoints(const PrimoShell::Impl& shell) {
    Eigen::MatrixXd Y = shell.adjoints.cast<double>();
    if (Y.cols() == 0) return Y;
    const std::vector<Eigen::Quaterniond> now = shell.free_rotations();
    for (int f = 0; f < shell.rest.num_free(); ++f) {
        const Eigen::Matrix3d turn = (now[f] * shell.adjoint_rotation[f].conjugate()).toRotationMatrix();
        Y.middleRows<3>(6 * f) = (turn * Y.middleRows<3>(6 * f)).eval();
        Y.middleRows<3>(6 * f + 3) = (turn * Y.middleRows<3>(6 * f + 3)).eval();
    }
    return Y;
}

void keep_adjoints(PrimoShell::Impl& shell, const Eigen::MatrixXd& Y) {
    shell.adjoints.resize(0, 0);
    if (Y.cols() > block_width) return;
    const Eigen::RowVectorXd size = Y.colwise().lpNorm<Eigen::Infinity>().cwiseMax(1e-300);
    shell.adjoints = (Y * size.cwiseInverse().asDiagonal()).cast<float>();
    shell.adjoint_rotation = shell.free_rotations();
}

/// Velocities of the vertices that follow pinned prisms. @param pinned twist of each prism
void place_pinned_rates(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const Eigen::MatrixXd& pinned,
                        Points& rate) {
    for (int k = 0; k < rest.mesh.num_vertices(); ++k) {
        const auto prisms = rest.vertex_prisms[k];
        if (prisms.empty() || rest.pin[prisms[0]] == free_prism) continue;
        Vector3d v = Vector3d::Zero();
        for (const int i : prisms)
            v += Vector3d(pinned.row(i).head<3>()).cross(turned(turn[i], rest.vertex_arm(k, i))) +
                 pinned.row(i).tail<3>().transpose();
        v /= static_cast<double>(prisms.size());
        rate.row(k) = rest.on_plane[k] ? Vector3d(rest.plane_projector * v) : v;
    }
}

}  // namespace

Matrix6 motion_twist(const RigidMotion& motion, const Vector3d& rest_centroid) {
    const Eigen::Matrix3d J = left_jacobian(motion.rotation);
    const Vector3d arm = rotation_of(motion.rotation) * (rest_centroid - motion.about);
    Matrix6 T = Matrix6::Zero();
    T.topLeftCorner<3, 3>() = J;
    for (int c = 0; c < 3; ++c) T.block<3, 1>(3, c) = Vector3d(J.col(c)).cross(arm);
    T.bottomRightCorner<3, 3>().setIdentity();
    return T;
}

void PrimoShell::Impl::need_tangent() {
    if (has_tangent && kept.is_built()) return;
    prepare(loads.spring);
    const auto turn = rotation_differences(poses);
    assemble(turn, jumps(rest, poses, turn), loads, StressTerm::exact);
    if (!factorize())
        throw SolverError("shell: the exact Hessian is not positive definite at these poses; solve first");
    has_tangent = true;
}

void PrimoShell::refresh_tangent() {
    impl_->kept.drop();
    impl_->need_tangent();
}

std::vector<Points> PrimoShell::response(const std::vector<Points>& dF, double tolerance) {
    Impl& shell = *impl_;
    for (const Points& field : dF) check_count(shell.rest, field, "a load change");
    shell.need_tangent();
    const auto turn = rotation_differences(shell.poses);
    const Points at = shell.placed();
    std::vector<Points> rates;
    rates.reserve(dF.size());
    for (std::size_t first = 0; first < dF.size(); first += block_width) {
        const std::size_t count = std::min<std::size_t>(block_width, dF.size() - first);
        Eigen::MatrixXd B(6 * shell.rest.num_free(), count);
        for (std::size_t c = 0; c < count; ++c) B.col(c) = vertex_wrenches(shell.rest, turn, dF[first + c]);
        const Eigen::MatrixXd X = solve_columns(shell, B, tolerance);
        for (std::size_t c = 0; c < count; ++c) {
            rates.push_back(vertex_rates(shell.rest, turn, X.col(c)));
            if (shell.rest.attached) shell.rest.attached->place_rates(at, rates.back());
        }
    }
    return rates;
}

std::vector<std::array<Points, 6>> PrimoShell::motion_response() {
    Impl& shell = *impl_;
    const RestState& rest = shell.rest;
    shell.need_tangent();
    const auto turn = rotation_differences(shell.poses);
    const Points at = shell.placed();
    std::vector<std::array<Points, 6>> rates(shell.motions.size());
    for (std::size_t m = 0; m < shell.motions.size(); ++m)
        for (int c = 0; c < 6; ++c) {
            Eigen::MatrixXd pinned = Eigen::MatrixXd::Zero(rest.num_prisms(), 6);
            for (int i = 0; i < rest.num_prisms(); ++i)
                if (rest.pin[i] == static_cast<int>(m) + 1)
                    pinned.row(i) = motion_twist(shell.motions[m], rest.centroid.row(i)).col(c).transpose();
            const Eigen::VectorXd twist = solve_columns(shell, -free_wrenches(rest, turn, pinned), exact);
            Points rate = vertex_rates(rest, turn, twist);
            place_pinned_rates(rest, turn, pinned, rate);
            if (rest.attached) rest.attached->place_rates(at, rate);
            rates[m][c] = rate;
        }
    return rates;
}

std::vector<ShellSensitivities> PrimoShell::adjoint(const std::vector<Points>& of_all, const AdjointOptions& options) {
    Impl& shell = *impl_;
    const RestState& rest = shell.rest;
    for (const Points& field : of_all) check_count(rest, field, "dJ/dv");
    std::vector<Points> dJ_dv = of_all;
    if (rest.attached)
        for (Points& field : dJ_dv) rest.attached->pull_back(shell.placed(), field);
    shell.need_tangent();
    const auto turn = rotation_differences(shell.poses);
    const Jumps jump = jumps(rest, shell.poses, turn);
    Eigen::MatrixXd B(6 * rest.num_free(), dJ_dv.size());
    for (std::size_t c = 0; c < dJ_dv.size(); ++c) B.col(c) = vertex_wrenches(rest, turn, dJ_dv[c]);
    const Eigen::MatrixXd Y = solve_columns(shell, B, options.tolerance, last_adjoints(shell));
    keep_adjoints(shell, Y);
    std::vector<ShellSensitivities> all(dJ_dv.size());
    for (std::size_t c = 0; c < dJ_dv.size(); ++c) {
        const Eigen::VectorXd y = Y.col(c);
        ShellSensitivities& s = all[c];
        s.vertex = of_all[c];
        s.force = vertex_rates(rest, turn, y);
        s.spring = -2 * (jump.vertex.cwiseProduct(s.force)).rowwise().sum();
        if (options.prism_height) s.prism_height = height_sensitivities(rest, turn, jump, y);
        s.motion.assign(shell.motions.size(), Vector6::Zero());
        if (shell.motions.empty()) continue;
        s.wrench = pinned_vertex_wrenches(rest, turn, dJ_dv[c]) - pinned_wrenches(rest, turn, y);
        for (int i = 0; i < rest.num_prisms(); ++i)
            if (rest.pin[i] > 0) {
                const RigidMotion& motion = shell.motions[rest.pin[i] - 1];
                s.motion[rest.pin[i] - 1] +=
                    motion_twist(motion, rest.centroid.row(i)).transpose() * s.wrench.row(i).transpose();
            } else {
                s.wrench.row(i).setZero();
            }
    }
    return all;
}

Points PrimoShell::linear_response(const Loads& given, const std::vector<RigidMotion>& motions) {
    Impl& shell = *impl_;
    const RestState& rest = shell.rest;
    const Loads loads = complete(given, rest.mesh.num_vertices());
    check_motions(rest, motions);
    shell.prepare(loads.spring);
    const Poses before = shell.poses;
    shell.reset_poses();
    const auto still = rotation_differences(shell.poses);
    shell.assemble(still, jumps(rest, shell.poses, still), loads, StressTerm::none);
    if (!shell.factorize())
        throw SolverError("shell: the rest stiffness is not positive definite; a part is barely held");
    shell.place_pinned(motions);
    const auto turn = rotation_differences(shell.poses);
    const Jumps jump = jumps(rest, shell.poses, turn);
    const Eigen::MatrixXd g6 = energy_gradient(rest, turn, jump, loads);
    Eigen::VectorXd g(6 * rest.num_free());
    for (int f = 0; f < rest.num_free(); ++f) g.segment<6>(6 * f) = g6.row(rest.free_prisms[f]).transpose();
    const Points rate = vertex_rates(rest, still, solve_columns(shell, -g, exact));
    shell.poses = before;
    shell.has_moved();
    Points v = rest.mesh.vertices;
    for (int k = 0; k < v.rows(); ++k)
        if (!rest.vertex_prisms[k].empty()) v.row(k) += jump.vertex.row(k) + rate.row(k);
    if (rest.attached) rest.attached->place(v);
    return v;
}

}  // namespace strake
