#include "core/primo/shell.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/primo/held.hpp"
#include "core/primo/shell_impl.hpp"

namespace strake {
namespace {

constexpr double way_turn = 0.75;     // rotation of a prism's path in a step, relative to its own
constexpr int prisms_at_once = 1024;  // of one thread

struct Timer {
    double& total;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    explicit Timer(double& seconds) : total(seconds) {}
    ~Timer() { total += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); }
};

}  // namespace

std::string to_string(SolveStatus status) {
    switch (status) {
        case SolveStatus::converged:
            return "converged";
        case SolveStatus::not_converged:
            return "not_converged";
        case SolveStatus::unstable:
            return "unstable";
        case SolveStatus::cancelled:
            return "cancelled";
    }
    return "unknown";
}

Eigen::Quaterniond rotation_of(const Eigen::Vector3d& r) {
    const double angle = r.norm();
    const double s = angle < 1e-4 ? 0.5 - angle * angle / 48 : std::sin(angle / 2) / angle;
    Eigen::Quaterniond q;
    q.w() = std::cos(angle / 2);
    q.vec() = s * r;
    return q;
}

Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& r) {
    Eigen::Matrix3d C;
    C << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
    const double a = r.norm(), a2 = a * a;
    const double p = a < 1e-3 ? 0.5 - a2 / 24 : (1 - std::cos(a)) / a2;
    const double q = a < 1e-3 ? 1.0 / 6 - a2 / 120 : (a - std::sin(a)) / (a2 * a);
    return Eigen::Matrix3d::Identity() + p * C + q * C * C;
}

PrimoShell::Impl::Impl(RestState given, LinearSolver solver, int expected_solves) : rest(std::move(given)) {
    if (rest.num_free() == 0) throw InvalidInput("shell: every triangle is fixed or pinned; nothing is free to move");
    reset_poses();
    loads = complete({}, rest.mesh.num_vertices());
    const double edge = std::sqrt(rest.area.mean() * 4 / std::sqrt(3.0));
    const double height_in_edges = rest.prism_height.mean() / edge;
    kept.use(Preconditioner::choose(solver, rest.num_free(), height_in_edges, expected_solves), height_in_edges,
             solver == LinearSolver::automatic);
}

void PrimoShell::Impl::reset_poses() {
    poses.rotation.assign(rest.num_prisms(), Eigen::Quaterniond::Identity());
    poses.displacement = Points::Zero(rest.num_prisms(), 3);
    has_moved();
}

void check_motions(const RestState& rest, const std::vector<RigidMotion>& motions) {
    int wanted = 0;
    for (const int pin : rest.pin) wanted = std::max(wanted, pin);
    if (static_cast<int>(motions.size()) != wanted)
        throw InvalidInput(text("shell: ", motions.size(), " motions for ", wanted, " pinned regions"));
    for (const RigidMotion& motion : motions)
        if (!motion.rotation.allFinite() || !motion.translation.allFinite() || !motion.about.allFinite())
            throw InvalidInput("shell: a pinned motion is not finite");
    for (int k = 0; k < rest.mesh.num_vertices(); ++k) {
        if (!rest.on_plane[k] || rest.fixed_vertex[k]) continue;
        for (const int i : rest.vertex_prisms[k]) {
            if (rest.pin[i] <= 0) continue;
            const RigidMotion& motion = motions[rest.pin[i] - 1];
            const Eigen::Vector3d x = rest.mesh.vertices.row(k).transpose() - motion.about;
            const Eigen::Vector3d d = rotation_of(motion.rotation) * x - x + motion.translation;
            if (std::abs(rest.symmetry->normal.dot(d)) > 1e-9 * rest.diagonal)
                throw InvalidInput(text("shell: strain ", rest.pin[i] - 1, " moves vertex ", k,
                                        " off the symmetry plane by ", rest.symmetry->normal.dot(d),
                                        "; move it within the plane only"));
        }
    }
}

void PrimoShell::Impl::place_pinned(const std::vector<RigidMotion>& given) {
    for (int i = 0; i < rest.num_prisms(); ++i) {
        if (rest.pin[i] <= 0) continue;
        const RigidMotion& motion = given[rest.pin[i] - 1];
        poses.rotation[i] = rotation_of(motion.rotation);
        const Eigen::Vector3d arm = rest.centroid.row(i).transpose() - motion.about;
        Poses one{{poses.rotation[i]}, Points()};
        poses.displacement.row(i) = (rotation_differences(one)[0] * arm + motion.translation).transpose();
    }
}

void PrimoShell::Impl::has_moved() {
    has_tangent = is_kept_here = false;
    turn_since_kept.clear();
    reached.reset();
}

void PrimoShell::Impl::prepare(const Eigen::VectorXd& wanted) {
    std::vector<char> pattern(wanted.size());
    for (int k = 0; k < wanted.size(); ++k) pattern[k] = wanted[k] > 0;
    if (pattern != spring_pattern) {
        check_held(rest, wanted);
        spring_pattern = pattern;
        has_moved();
    }
    if (H.size() > 0) return;
    const Timer timer(seconds.ordering);
    H = hessian_pattern(rest);
    kept.analyze(H);
}

void PrimoShell::Impl::assemble(const std::vector<Eigen::Matrix3d>& turn, const Jumps& stress, const Loads& under,
                                StressTerm term) {
    const Timer timer(seconds.assembly);
    assemble_hessian(rest, turn, stress, under, term, H);
    spring = under.spring.isZero(0) ? Eigen::VectorXd() : under.spring;
    if (spring.size() > 0) spring_turn = turn;
    has_tangent = false;
}

bool PrimoShell::Impl::factorize() {
    const Timer timer(seconds.factorization);
    spent = rate = 0;
    if (spring.size() > 0) {
        const std::vector<Matrix6> diagonal = H.diagonal;
        add_lumped_springs(rest, spring_turn, spring, H);
        is_kept_here = kept.build(H, free_centroids());
        H.diagonal = diagonal;
    } else {
        is_kept_here = kept.build(H, free_centroids());
    }
    turn_since_kept.clear();
    if (!is_kept_here) return false;
    kept_rotation = free_rotations();
    return true;
}

Eigen::VectorXd PrimoShell::Impl::product(const Eigen::VectorXd& x) const {
    Eigen::VectorXd y = H.multiply(x);
    if (spring.size() > 0) add_spring_product(rest, spring_turn, spring, x, y);
    return y;
}

Eigen::MatrixXd PrimoShell::Impl::products(const Eigen::MatrixXd& X) const {
    Eigen::MatrixXd Y = H.multiply_columns(X);
    for (Eigen::Index c = 0; c < X.cols() && spring.size() > 0; ++c) {
        Eigen::VectorXd y = Y.col(c);
        add_spring_product(rest, spring_turn, spring, X.col(c), y);
        Y.col(c) = y;
    }
    return Y;
}

/// Rotates X, six rows per free prism, into the frames in which `kept` was built, or back.
void PrimoShell::Impl::turn_to_kept(Eigen::MatrixXd& X, bool back) {
    const bool is_new = turn_since_kept.empty();
    turn_since_kept.resize(rest.num_free());
    for_blocks(rest.num_free(), prisms_at_once, [&](int begin, int end) {
        for (int f = begin; f < end; ++f) {
            Eigen::Matrix3d& turn = turn_since_kept[f];
            if (is_new) turn = (poses.rotation[rest.free_prisms[f]] * kept_rotation[f].conjugate()).toRotationMatrix();
            for (Eigen::Index c = 0; c < X.cols(); ++c)
                for (const int at : {6 * f, 6 * f + 3}) {
                    const Eigen::Vector3d part = X.col(c).segment<3>(at);
                    if (back)
                        X.col(c).segment<3>(at) = turn * part;
                    else
                        X.col(c).segment<3>(at) = turn.transpose() * part;
                }
        }
    });
}

Eigen::MatrixXd PrimoShell::Impl::precondition(const Eigen::Ref<const Eigen::MatrixXd>& B, Cycle kind) {
    const Timer timer(seconds.substitution);
    ++substitutions;
    if (is_kept_here) return kept.apply(B, kind);
    Eigen::MatrixXd X = B;
    turn_to_kept(X, false);
    X = kept.apply(X, kind);
    turn_to_kept(X, true);
    return X;
}

Points PrimoShell::Impl::free_centroids() const {
    return (rest.centroid + poses.displacement)(rest.free_prisms, Eigen::all);
}

std::vector<Eigen::Quaterniond> PrimoShell::Impl::free_rotations() const {
    std::vector<Eigen::Quaterniond> rotations(rest.num_free());
    for (int f = 0; f < rest.num_free(); ++f) rotations[f] = poses.rotation[rest.free_prisms[f]];
    return rotations;
}

/// Straight paths would stretch a part that rotates by an angle t by t^2/2; circular arcs would shrink it by as much or
/// half. A part that bends from its root keeps its length if the path rotates three quarters as far as the prism.
void PrimoShell::Impl::advance(const Eigen::VectorXd& twist) {
    for_blocks(rest.num_free(), prisms_at_once, [&](int begin, int end) {
        for (int f = begin; f < end; ++f) {
            const int i = rest.free_prisms[f];
            const Eigen::Vector3d turn = twist.segment<3>(6 * f), way = twist.segment<3>(6 * f + 3);
            poses.rotation[i] = (rotation_of(turn) * poses.rotation[i]).normalized();
            poses.displacement.row(i) += (left_jacobian(way_turn * turn) * way).transpose();
        }
    });
    has_moved();
}

Points PrimoShell::Impl::vertices() const {
    const Jumps jump = jumps(rest, poses, rotation_differences(poses));
    Points v = rest.mesh.vertices;
    for (int k = 0; k < v.rows(); ++k)
        if (!rest.vertex_prisms[k].empty()) v.row(k) += jump.vertex.row(k);
    if (rest.attached) rest.attached->place(v);
    return v;
}

double step_size(const RestState& rest, const Eigen::VectorXd& twist) {
    double largest = 0;
    for (int f = 0; f < rest.num_free(); ++f)
        largest = std::max(largest, twist.segment<3>(6 * f + 3).norm() +
                                        twist.segment<3>(6 * f).norm() * rest.prism_radius[rest.free_prisms[f]]);
    return twist.allFinite() ? largest / rest.diagonal : std::numeric_limits<double>::infinity();
}

PrimoShell::PrimoShell(const TriMesh& mesh, const ShellOptions& options)
    : impl_(std::make_unique<Impl>(rest_state(mesh, options), options.solver, options.expected_solves)) {}
PrimoShell::~PrimoShell() = default;
PrimoShell::PrimoShell(PrimoShell&&) noexcept = default;
PrimoShell& PrimoShell::operator=(PrimoShell&&) noexcept = default;

Points PrimoShell::vertices() const { return impl_->vertices(); }
Poses PrimoShell::poses() const {
    Poses poses = impl_->poses;
    const RestState& rest = impl_->rest;
    if (!rest.attached) return poses;
    const std::vector<Eigen::Quaterniond> turned = rest.attached->rotations(impl_->vertices());
    for (int t = 0; t < rest.num_prisms(); ++t)
        if (const int part = rest.attached->part_of()[t]; part >= 0) poses.rotation[t] = turned[part];
    return poses;
}
void PrimoShell::reset() { impl_->reset_poses(); }
int PrimoShell::num_free_prisms() const { return impl_->rest.num_free(); }
LinearSolver PrimoShell::solver() const {
    return impl_->kept.is_exact() ? LinearSolver::direct : LinearSolver::multigrid;
}
const std::vector<char>& PrimoShell::fixed_vertices() const { return impl_->rest.fixed_vertex; }

void PrimoShell::set_poses(const Poses& poses) {
    const int m = impl_->rest.num_prisms();
    if (static_cast<int>(poses.rotation.size()) != m || poses.displacement.rows() != m)
        throw InvalidInput(text("shell: ", poses.rotation.size(), " poses for ", m, " prisms"));
    const Poses& now = impl_->poses;
    const auto same = [](const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) { return a.coeffs() == b.coeffs(); };
    if (now.displacement == poses.displacement && std::ranges::equal(now.rotation, poses.rotation, same)) return;
    impl_->poses = poses;
    impl_->has_moved();
    if (!impl_->rest.attached) return;
    for (int t = 0; t < m; ++t)
        if (impl_->rest.attached->part_of()[t] >= 0) impl_->poses.rotation[t].setIdentity();
}

double PrimoShell::energy(const Loads& loads) const {
    const Jumps jump = jumps(impl_->rest, impl_->poses, rotation_differences(impl_->poses));
    return strake::energy(impl_->rest, jump, complete(loads, impl_->rest.mesh.num_vertices()));
}

Eigen::MatrixXd PrimoShell::gradient(const Loads& loads) const {
    const RestState& rest = impl_->rest;
    const auto turn = rotation_differences(impl_->poses);
    Eigen::MatrixXd g =
        energy_gradient(rest, turn, jumps(rest, impl_->poses, turn), complete(loads, rest.mesh.num_vertices()));
    for (int i = 0; i < rest.num_prisms(); ++i)
        if (rest.pin[i] != free_prism) g.row(i).setZero();
    return g;
}

TriMesh PrimoShell::prism_surface() const {
    const RestState& rest = impl_->rest;
    constexpr int sides[8][3] = {{2, 1, 0}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3},
                                 {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}};
    TriMesh prisms;
    prisms.vertices.resize(6 * rest.num_prisms(), 3);
    prisms.triangles.resize(8 * rest.num_prisms(), 3);
    for (int i = 0; i < rest.num_prisms(); ++i) {
        for (int corner = 0; corner < 6; ++corner) {
            const int v = rest.mesh.triangles(i, corner % 3);
            const double half = (corner < 3 ? -0.5 : 0.5) * rest.height[v];
            const Eigen::Vector3d arm = rest.vertex_arm(v, i) + half * corner_normal(rest, v, i);
            prisms.vertices.row(6 * i + corner) =
                rest.centroid.row(i) + impl_->poses.displacement.row(i) + (impl_->poses.rotation[i] * arm).transpose();
        }
        for (int s = 0; s < 8; ++s)
            for (int k = 0; k < 3; ++k) prisms.triangles(8 * i + s, k) = 6 * i + sides[s][k];
    }
    return prisms;
}

}  // namespace strake
