#include "core/primo/energy.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/primo/face_kernels.hpp"

namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d cross(const Vector3d& a) {
    Matrix3d c;
    c << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return c;
}

Vector3d row(const Points& points, int k) { return points.row(k).transpose(); }

/// Velocity of the point at current arm `a` of prism i; zero for pinned prisms.
Vector3d velocity(const RestState& rest, const Eigen::VectorXd& twist, int i, const Vector3d& a) {
    const int f = rest.free_index[i];
    if (f < 0) return Vector3d::Zero();
    return Vector3d(twist.segment<3>(6 * f)).cross(a) + twist.segment<3>(6 * f + 3);
}

Vector3d project(const RestState& rest, int k, const Vector3d& d) {
    return rest.on_plane[k] ? Vector3d(rest.plane_projector * d) : d;
}

/// dE/d(vertex displacement) at vertex k: 2 lambda d - F, projected for vertices in the symmetry plane.
Vector3d vertex_force(const RestState& rest, int k, const Vector3d& d, const Loads& loads) {
    return project(rest, k, 2 * loads.spring[k] * d - row(loads.force, k));
}

constexpr int at_once = 1024;  // faces, prisms or vertices of one thread

template <class Work>
void for_vertices(const RestState& rest, const Work& work) {
    for_blocks(rest.mesh.num_vertices(), at_once, [&](int begin, int end) {
        for (int k = begin; k < end; ++k) work(k);
    });
}

bool is_zero(const Points& points, int k) { return (points.row(k).array() == 0).all(); }

/// Per vertex: the share of its force on each of its prisms.
Points shared_forces(const RestState& rest, const Points& force) {
    Points shared(force.rows(), 3);
    for_vertices(rest, [&](int k) {
        const auto count = rest.vertex_prisms[k].size();
        if (count == 0 || is_zero(force, k))
            shared.row(k).setZero();
        else
            shared.row(k) = project(rest, k, row(force, k)) / static_cast<double>(count);
    });
    return shared;
}

/// The same of dE/d(vertex displacement).
Points vertex_forces(const RestState& rest, const Jumps& jump, const Loads& loads) {
    Points shared(rest.mesh.num_vertices(), 3);
    for_vertices(rest, [&](int k) {
        const auto count = rest.vertex_prisms[k].size();
        if (count == 0 || (!(loads.spring[k] > 0) && is_zero(loads.force, k)))
            shared.row(k).setZero();
        else
            shared.row(k) = vertex_force(rest, k, row(jump.vertex, k), loads) / static_cast<double>(count);
    });
    return shared;
}

/// Adds torque and force of the vertices' forces. @param part position of prism i; null: none
template <class Part>
void add_vertex_wrenches(const RestState& rest, const std::vector<Matrix3d>& turn, const Points& force,
                         const Part& part) {
    for_blocks(rest.num_prisms(), at_once, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
            double* to = part(i);
            if (!to) continue;
            Eigen::Map<Vector6> wrench(to);
            for (const int k : rest.prism_vertices[i]) {
                if (is_zero(force, k)) continue;
                const Vector3d f = row(force, k);
                wrench.head<3>() += turned(turn[i], rest.vertex_arm(k, i)).cross(f);
                wrench.tail<3>() += f;
            }
        }
    });
}

/// Position of prism i in a vector of the free prisms.
auto free_part(const RestState& rest, Eigen::VectorXd& wrench) {
    return
        [&rest, &wrench](int i) { return rest.free_index[i] < 0 ? nullptr : wrench.data() + 6L * rest.free_index[i]; };
}

}  // namespace

Loads complete(const Loads& loads, int n) {
    Loads result = loads;
    if (loads.force.size() == 0) result.force = Points::Zero(n, 3);
    if (loads.spring.size() == 0) result.spring = Eigen::VectorXd::Zero(n);
    if (result.force.rows() != n || result.spring.size() != n)
        throw InvalidInput(text("shell: loads for ", result.force.rows(), " and springs for ", result.spring.size(),
                                " of ", n, " vertices"));
    if (!result.force.allFinite() || !result.spring.allFinite())
        throw InvalidInput("shell: a load or spring is not finite");
    if ((result.spring.array() < 0).any())
        throw InvalidInput(text("shell: spring ", result.spring.minCoeff(), " must be >= 0"));
    return result;
}

std::vector<Matrix3d> rotation_differences(const Poses& poses) {
    std::vector<Matrix3d> turn(poses.rotation.size());
    for_blocks(static_cast<int>(turn.size()), at_once, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
            const Matrix3d v = cross(poses.rotation[i].vec());
            turn[i] = 2 * (poses.rotation[i].w() * v + v * v);
        }
    });
    return turn;
}

Jumps jumps(const RestState& rest, const Poses& poses, const std::vector<Matrix3d>& turn) {
    Jumps jump;
    face_jumps(rest, poses, turn, jump.face);
    for (const MirroredFace& f : rest.mirrored)
        for (int g = 0; g < 4; ++g)
            jump.mirrored.push_back(rest.symmetry->normal.dot(turn[f.i] * f.arm[g] + row(poses.displacement, f.i)));
    jump.vertex.resize(rest.mesh.num_vertices(), 3);
    vertex_sums(rest, poses, turn, jump.vertex);
    for_vertices(rest, [&](int k) {
        if (const auto count = rest.vertex_prisms[k].size(); count > 0)
            jump.vertex.row(k) = project(rest, k, row(jump.vertex, k) / static_cast<double>(count));
    });
    return jump;
}

Jumps jump_rates(const RestState& rest, const std::vector<Matrix3d>& turn, const Eigen::VectorXd& twist) {
    Jumps rate;
    face_jump_rates(rest, turn, twist, rate.face);
    for (const MirroredFace& f : rest.mirrored)
        for (int g = 0; g < 4; ++g)
            rate.mirrored.push_back(rest.symmetry->normal.dot(velocity(rest, twist, f.i, turned(turn[f.i], f.arm[g]))));
    rate.vertex = vertex_rates(rest, turn, twist);
    return rate;
}

Jumps sum(const Jumps& a, Jumps s) {
    for_blocks(static_cast<int>(s.face.size()), at_once, [&](int begin, int end) {
        for (int f = begin; f < end; ++f)
            for (int g = 0; g < 4; ++g) {
                s.face[f].x[g] += a.face[f].x[g];
                s.face[f].y[g] += a.face[f].y[g];
                s.face[f].z[g] += a.face[f].z[g];
            }
    });
    for (std::size_t i = 0; i < s.mirrored.size(); ++i) s.mirrored[i] += a.mirrored[i];
    s.vertex += a.vertex;
    return s;
}

double energy(const RestState& rest, const Jumps& jump, const Loads& loads) {
    double E = ordered_sum(static_cast<int>(rest.faces.size()), at_once, [&](int begin, int end) {
        double sum = 0;
        for (int f = begin; f < end; ++f) {
            double squares = 0;
            for (int g = 0; g < 4; ++g) squares += jump.face[f][g].squaredNorm();
            sum += rest.faces[f].weight / 4 * squares;
        }
        return sum;
    });
    for (std::size_t f = 0; f < rest.mirrored.size(); ++f)
        for (int g = 0; g < 4; ++g)
            E += rest.mirrored[f].weight / 2 * jump.mirrored[4 * f + g] * jump.mirrored[4 * f + g];
    E += ordered_sum(rest.mesh.num_vertices(), at_once, [&](int begin, int end) {
        double sum = 0;
        for (int k = begin; k < end; ++k)
            sum += loads.spring[k] * jump.vertex.row(k).squaredNorm() - loads.force.row(k).dot(jump.vertex.row(k));
        return sum;
    });
    return E;
}

Wrenches energy_gradient(const RestState& rest, const std::vector<Matrix3d>& turn, const Jumps& jump,
                         const Loads& loads) {
    Wrenches g6;
    face_wrenches(rest, turn, jump.face, g6);
    for (std::size_t f = 0; f < rest.mirrored.size(); ++f)
        for (int g = 0; g < 4; ++g) {
            const MirroredFace& face = rest.mirrored[f];
            const Vector3d force = face.weight * jump.mirrored[4 * f + g] * rest.symmetry->normal;
            g6.row(face.i).head<3>() += turned(turn[face.i], face.arm[g]).cross(force);
            g6.row(face.i).tail<3>() += force;
        }
    add_vertex_wrenches(rest, turn, vertex_forces(rest, jump, loads), [&](int i) { return g6.data() + 6L * i; });
    return g6;
}

Wrenches applied_forces(const RestState& rest, const std::vector<Matrix3d>& turn, const Loads& loads) {
    Wrenches wrench = Wrenches::Zero(rest.num_prisms(), 6);
    add_vertex_wrenches(rest, turn, shared_forces(rest, loads.force), [&](int i) { return wrench.data() + 6L * i; });
    return wrench;
}

BlockMatrix hessian_pattern(const RestState& rest) {
    std::vector<std::pair<int, int>> pairs;
    for (const SharedFace& f : rest.faces)
        if (rest.free_index[f.i] >= 0 && rest.free_index[f.j] >= 0)
            pairs.emplace_back(rest.free_index[f.i], rest.free_index[f.j]);
    return block_matrix(rest.num_free(), pairs);
}

namespace {

using Matrix36 = Eigen::Matrix<double, 3, 6>;

Matrix36 velocity_map(const Vector3d& a) {
    Matrix36 J;
    J << -cross(a), Matrix3d::Identity();
    return J;
}

/// Two prisms share at most one face, except on tiny closed surfaces: every block is written once.
bool has_one_face_each(const RestState& rest, const BlockMatrix& H) {
    std::size_t count = 0;
    for (const SharedFace& f : rest.faces) count += rest.free_index[f.i] >= 0 && rest.free_index[f.j] >= 0;
    return count == H.below.size();
}

/// The symmetric matrix with those entries: xx, yy, zz, xy, yz, zx.
Matrix3d symmetric(const double* entries) {
    Matrix3d S;
    S << entries[0], entries[3], entries[5], entries[3], entries[1], entries[4], entries[5], entries[4], entries[2];
    return S;
}

/// sym(A) - tr(A) I from A = sum f a^T: the curvature term of SO(3) for forces f at arms a.
Matrix3d stress_block(const OwnBlock& own, StressTerm term) {
    if (term == StressTerm::none) return Matrix3d::Zero();
    const Matrix3d A = symmetric(own.moment), S = A - A.trace() * Matrix3d::Identity();
    if (term != StressTerm::clipped) return S;
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(S);
    return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
}

/// sum w J(a)^T J(a) and the stress term.
Matrix6 diagonal_block(const OwnBlock& own, StressTerm term) {
    const Matrix3d S = symmetric(own.square), C = cross(Vector3d(own.arm[0], own.arm[1], own.arm[2]));
    Matrix6 block;
    block << S.trace() * Matrix3d::Identity() - S + stress_block(own, term), C, -C,
        4 * own.weight * Matrix3d::Identity();
    return block;
}

}  // namespace

void assemble_hessian(const RestState& rest, const std::vector<Matrix3d>& turn, const Jumps& stress, const Loads& loads,
                      StressTerm term, BlockMatrix& H) {
    const bool is_sum = !has_one_face_each(rest, H);
    if (is_sum)
        for (Matrix6& block : H.below) block.setZero();
    std::vector<OwnBlock> own(rest.num_free());
    add_face_blocks(rest, turn, stress.face, is_sum, own, H.below, H);
    for (std::size_t f = 0; f < rest.mirrored.size(); ++f) {
        const MirroredFace& face = rest.mirrored[f];
        const int i = rest.free_index[face.i];
        for (int g = 0; g < 4 && i >= 0; ++g)
            own[i].add_moment(face.weight * stress.mirrored[4 * f + g] * rest.symmetry->normal,
                              strake::turned(turn[face.i], face.arm[g]));
    }
    const Points force = vertex_forces(rest, stress, loads);
    for_blocks(rest.num_free(), at_once, [&](int begin, int end) {
        for (int f = begin; f < end; ++f) {
            const int i = rest.free_prisms[f];
            for (const int k : rest.prism_vertices[i])
                if (!is_zero(force, k))
                    own[f].add_moment(row(force, k), strake::turned(turn[i], rest.vertex_arm(k, i)));
            H.diagonal[f] = diagonal_block(own[f], term);
        }
    });
    for (const MirroredFace& face : rest.mirrored) {
        const int i = rest.free_index[face.i];
        for (int g = 0; g < 4 && i >= 0; ++g) {
            const Vector6 c =
                velocity_map(strake::turned(turn[face.i], face.arm[g])).transpose() * rest.symmetry->normal;
            H.diagonal[i] += face.weight * c * c.transpose();
        }
    }
}

void add_spring_product(const RestState& rest, const std::vector<Matrix3d>& turn, const Eigen::VectorXd& spring,
                        const Eigen::VectorXd& x, Eigen::VectorXd& y) {
    Points force(rest.mesh.num_vertices(), 3);
    for_vertices(rest, [&](int k) {
        const auto prisms = rest.vertex_prisms[k];
        Vector3d v = Vector3d::Zero();
        if (spring[k] != 0 && !prisms.empty()) {
            for (const int i : prisms) v += velocity(rest, x, i, turned(turn[i], rest.vertex_arm(k, i)));
            const double m = static_cast<double>(prisms.size());
            v = 2 * spring[k] / (m * m) * project(rest, k, v);
        }
        force.row(k) = v;
    });
    add_vertex_wrenches(rest, turn, force, free_part(rest, y));
}

void add_lumped_springs(const RestState& rest, const std::vector<Matrix3d>& turn, const Eigen::VectorXd& spring,
                        BlockMatrix& H) {
    for (int k = 0; k < rest.mesh.num_vertices(); ++k) {
        if (spring[k] == 0) continue;
        const auto prisms = rest.vertex_prisms[k];
        for (const int i : prisms) {
            const int f = rest.free_index[i];
            if (f < 0) continue;
            Matrix36 J = velocity_map(strake::turned(turn[i], rest.vertex_arm(k, i)));
            if (rest.on_plane[k]) J = rest.plane_projector * J;
            H.diagonal[f] += 2 * spring[k] / static_cast<double>(prisms.size()) * J.transpose() * J;
        }
    }
}

Points vertex_rates(const RestState& rest, const std::vector<Matrix3d>& turn, const Eigen::VectorXd& twist) {
    Points rate(rest.mesh.num_vertices(), 3);
    for_vertices(rest, [&](int k) {
        const auto prisms = rest.vertex_prisms[k];
        Vector3d v = Vector3d::Zero();
        for (const int i : prisms) v += velocity(rest, twist, i, turned(turn[i], rest.vertex_arm(k, i)));
        rate.row(k) = prisms.empty() ? v : project(rest, k, v / static_cast<double>(prisms.size()));
    });
    return rate;
}

Eigen::VectorXd vertex_wrenches(const RestState& rest, const std::vector<Matrix3d>& turn, const Points& force) {
    Eigen::VectorXd wrench = Eigen::VectorXd::Zero(6 * rest.num_free());
    add_vertex_wrenches(rest, turn, shared_forces(rest, force), free_part(rest, wrench));
    return wrench;
}

}  // namespace strake
