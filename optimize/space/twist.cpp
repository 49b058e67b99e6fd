#include "optimize/space/twist.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/space/design_space.hpp"

#include <Eigen/Cholesky>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Smallest pivot of a matrix with a diagonal of ones that is taken for regular.
constexpr double regular = 1e-10;

void check(const TwistSpec& spec, int num_triangles) {
    const auto refuse = [&](const std::string& why) { throw InvalidInput(text("twist ", spec.name, ": ", why)); };
    if (spec.name.empty()) refuse("it has no name");
    if (spec.triangles.empty()) refuse("it has no triangles");
    for (const int t : spec.triangles)
        if (t < 0 || t >= num_triangles) refuse(text("triangle ", t, " must be in [0, ", num_triangles, ")"));
    if (!(std::abs(spec.axis.norm() - 1) < 1e-9)) refuse(text("axis: length ", spec.axis.norm(), " must be 1"));
    if (!spec.about.allFinite()) refuse("about is not finite");
    if (!(spec.max_angle > 0) || !std::isfinite(spec.max_angle))
        refuse(text("max_angle = ", spec.max_angle, " must be > 0"));
    if (spec.stations.empty() && spec.count < 2) refuse(text("stations = ", spec.count, " must be >= 2"));
    for (std::size_t k = 1; k < spec.stations.size(); ++k)
        if (!(spec.stations[k] > spec.stations[k - 1]))
            refuse(text("station ", k + 1, " at ", spec.stations[k], " must lie beyond station ", k, " at ",
                        spec.stations[k - 1]));
}

/// The stations and what their unit motions do: degree of freedom 3 k + i moves triangle t by hat_k(t) shape_i(t), with
/// shape_0 the turn about the axis over `radius`, shape_1 and shape_2 the translations across it.
class Sections {
public:
    Sections(const TriMesh& rest, const TwistSpec& spec)
        : rest_(rest), spec_(spec), area_(triangle_areas(rest)), centre_(triangle_centroids(rest)) {
        check(spec, rest.num_triangles());
        place_stations();
        across_[0] = spec.axis.unitOrthogonal();
        across_[1] = spec.axis.cross(across_[0]);
        double polar = 0, all = 0;
        for (const int t : spec.triangles) {
            polar += area_[t] * turn(t).squaredNorm();
            all += area_[t];
        }
        radius_ = std::sqrt(polar / all);
        if (!(radius_ > 1e-6 * box_diagonal(rest)))
            throw InvalidInput(text("twist ", spec.name, ": the surface lies on the axis"));
    }

    int count() const { return static_cast<int>(station_.size()); }
    double radius() const { return radius_; }
    const std::vector<double>& stations() const { return station_; }

    /// Traction of a degree of freedom, or its motion: m x 3.
    Points field(int dof) const {
        Points all = Points::Zero(rest_.num_triangles(), 3);
        for (const int t : spec_.triangles)
            if (const double w = hat(dof / 3, t); w > 0) all.row(t) = w * shape(dof % 3, t).transpose();
        return all;
    }

    /// Integrals over the area of the products of the fields.
    MatrixXd gram(const std::vector<int>& dofs) const {
        const auto n = static_cast<Eigen::Index>(dofs.size());
        MatrixXd sum = MatrixXd::Zero(n, n);
        for (const int t : spec_.triangles)
            for (Eigen::Index i = 0; i < n; ++i) {
                const double w = hat(dofs[i] / 3, t);
                for (Eigen::Index j = 0; w > 0 && j < n; ++j)
                    sum(i, j) += area_[t] * w * hat(dofs[j] / 3, t) * shape(dofs[i] % 3, t).dot(shape(dofs[j] % 3, t));
            }
        return sum;
    }

    /// Integral over the area of the field times a displacement: the work of it as a load.
    double work(int dof, const Points& displacement) const {
        double sum = 0;
        for (const int t : spec_.triangles) {
            const double w = hat(dof / 3, t);
            if (w <= 0) continue;
            Vector3d moved = Vector3d::Zero();
            for (int k = 0; k < 3; ++k) moved += displacement.row(rest_.triangles(t, k)).transpose() / 3;
            sum += area_[t] * w * shape(dof % 3, t).dot(moved);
        }
        return sum;
    }

    /// Per station: most of the outline of its section is held.
    std::vector<char> held(const std::vector<int>& pin) const {
        VectorXd holds = VectorXd::Zero(rest_.num_vertices());
        for (int t = 0; t < rest_.num_triangles(); ++t)
            for (int k = 0; pin[t] != free_prism && k < 3; ++k) holds[rest_.triangles(t, k)] = 1;
        std::vector<char> result;
        for (int k = 0; k < count(); ++k) result.push_back(held_share(k, holds) >= 0.5);
        return result;
    }

    /// Three for each station that is not held.
    std::vector<int> dofs(const std::vector<char>& held) const {
        std::vector<int> list;
        for (int f = 0; f < 3 * count(); ++f)
            if (!held[f / 3]) list.push_back(f);
        return list;
    }

private:
    double along(const Vector3d& x) const { return spec_.axis.dot(x - spec_.about); }
    Vector3d turn(int t) const { return spec_.axis.cross(centre_.row(t).transpose() - spec_.about); }
    Vector3d shape(int i, int t) const { return i == 0 ? Vector3d(turn(t) / radius_) : across_[i - 1]; }

    double hat(int k, int t) const {
        const double s = along(centre_.row(t).transpose());
        if (s < station_[k]) return k == 0 ? 1 : std::max(0.0, 1 - (station_[k] - s) / (station_[k] - station_[k - 1]));
        return k + 1 == count() ? 1 : std::max(0.0, 1 - (s - station_[k]) / (station_[k + 1] - station_[k]));
    }

    void place_stations() {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const int t : spec_.triangles)
            for (int k = 0; k < 3; ++k) {
                const double s = along(rest_.vertices.row(rest_.triangles(t, k)).transpose());
                low = std::min(low, s);
                high = std::max(high, s);
            }
        const double slack = 1e-6 * box_diagonal(rest_);
        for (const double s : spec_.stations) {
            if (s < low - slack || s > high + slack)
                throw InvalidInput(text("twist ", spec_.name, ": the station at ", s, " must lie in [", low, ", ", high,
                                        "], where the surface is along the axis"));
            station_.push_back(std::clamp(s, low, high));
        }
        for (int k = 0; spec_.stations.empty() && k < spec_.count; ++k)
            station_.push_back(low + (high - low) * k / (spec_.count - 1));
        if (!(high - low > slack))
            throw InvalidInput(text("twist ", spec_.name, ": the surface has no extent along the axis"));
    }

    double held_share(int k, const VectorXd& holds) const {
        const double slack = 1e-9 * box_diagonal(rest_);
        double sum = 0;
        int count = 0;
        const auto from_plane = [&](int v) {
            const double s = along(rest_.vertices.row(v).transpose()) - station_[k];
            return std::abs(s) <= slack ? 0.0 : s;
        };
        for (const int t : spec_.triangles)
            for (int e = 0; e < 3; ++e) {
                const int a = rest_.triangles(t, e), b = rest_.triangles(t, (e + 1) % 3);
                const double at_a = from_plane(a), at_b = from_plane(b);
                if (at_a * at_b > 0) continue;
                const double share = at_a == at_b ? 0.5 : at_a / (at_a - at_b);
                sum += (1 - share) * holds[a] + share * holds[b];
                ++count;
            }
        if (count == 0)
            throw InvalidInput(text("twist ", spec_.name, ": there is no surface at the station ", station_[k]));
        return sum / count;
    }

    const TriMesh& rest_;
    const TwistSpec& spec_;
    VectorXd area_;
    Points centre_;
    std::vector<double> station_;
    Vector3d across_[2];
    double radius_ = 1;
};

/// A x = b for a positive definite A. @throws InvalidInput when it is not, beyond round-off.
MatrixXd solve(const MatrixXd& A, const MatrixXd& b, const std::string& why) {
    const VectorXd diagonal = A.diagonal();
    if (!(diagonal.minCoeff() > 1e-12 * diagonal.maxCoeff())) throw InvalidInput(why);
    const VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
    const Eigen::LDLT<MatrixXd> factor(scale.asDiagonal() * A * scale.asDiagonal());
    if (!(factor.vectorD().minCoeff() > regular)) throw InvalidInput(why);
    return scale.asDiagonal() * factor.solve(scale.asDiagonal() * b);
}

std::string too_close(const TwistSpec& spec) {
    return text("twist ", spec.name, ": the surface cannot follow its stations; give fewer, or wider apart");
}

/// Work of the fields in the linear responses to each other, by degree of freedom.
MatrixXd compliance(const RestFacts& rest, const Sections& sections, const std::vector<int>& dofs) {
    PrimoShell shell(rest.elastic(), rest.setup.options);
    std::vector<RigidMotion> still = rest.setup.motions;
    for (RigidMotion& motion : still) motion = {{0, 0, 0}, {0, 0, 0}, motion.about};
    const Equilibrium start = shell.solve({{}, rest.setup.loads.spring}, still);
    if (start.status != SolveStatus::converged) throw SolverError(text("the shell at rest: ", start.reason));
    std::vector<Points> forces;
    for (const int f : dofs) forces.push_back(traction_forces(rest.elastic(), sections.field(f)));
    const std::vector<Points> moved = shell.response(forces);
    const auto n = static_cast<Eigen::Index>(dofs.size());
    MatrixXd work(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = 0; j < n; ++j) work(i, j) = sections.work(dofs[i], moved[j]);
    return 0.5 * (work + work.transpose());
}

}  // namespace

TwistVariables twist_variables(const Problem& problem, const TwistSpec& spec) {
    const Sections sections(elastic_surface(problem), spec);
    const auto rest = rest_facts(problem);
    TwistVariables result{{}, sections.stations(), sections.held(rest->setup.options.pin)};
    const std::vector<int> dofs = sections.dofs(result.held);
    if (dofs.empty())
        throw InvalidInput(text("twist ", spec.name, ": the sections at all stations are fixed or strained"));
    const MatrixXd load = solve(compliance(*rest, sections, dofs), sections.gram(dofs), too_close(spec));
    const auto n = static_cast<Eigen::Index>(dofs.size());
    const auto rows = static_cast<Eigen::Index>(spec.triangles.size());
    std::vector<Points> traction(dofs.size() / 3, Points::Zero(rows, 3));
    for (Eigen::Index i = 0; i < n; ++i) {
        const Points field = sections.field(dofs[i])(spec.triangles, Eigen::all);
        for (std::size_t k = 0; k < traction.size(); ++k)
            traction[k] += sections.radius() * load(i, static_cast<Eigen::Index>(3 * k)) * field;
    }
    for (std::size_t k = 0; k < traction.size(); ++k) {
        UserVariable v;
        v.name = text(spec.name, ".", dofs[3 * k] / 3 + 1);
        v.triangles = spec.triangles;
        v.traction = std::move(traction[k]);
        v.unit = spec.max_angle;
        result.variables.push_back(std::move(v));
    }
    return result;
}

VectorXd section_twists(const TriMesh& rest, const TwistSpec& spec, const std::vector<char>& held,
                        const Points& displacement) {
    const Sections sections(rest, spec);
    const std::vector<int> dofs = sections.dofs(held);
    VectorXd work(static_cast<Eigen::Index>(dofs.size()));
    for (std::size_t i = 0; i < dofs.size(); ++i)
        work[static_cast<Eigen::Index>(i)] = sections.work(dofs[i], displacement);
    const VectorXd motion = solve(sections.gram(dofs), work, too_close(spec));
    VectorXd twist = VectorXd::Zero(sections.count());
    for (std::size_t i = 0; i < dofs.size(); i += 3)
        twist[dofs[i] / 3] = motion[static_cast<Eigen::Index>(i)] / sections.radius();
    return twist;
}

}  // namespace strake
