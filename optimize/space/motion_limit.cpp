#include "optimize/space/motion_limit.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <utility>

namespace strake {
namespace {

constexpr double tolerance = 1e-9;      ///< of a limit
constexpr double default_scale = 0.05;  ///< diagonals: where no limit gives the variables their size
constexpr double spread = 0.03;         ///< diagonals: rows of vertices closer than this say the same

constexpr double cancelled = 1e-9;  ///< of the area around a vertex: a shorter sum of its normals is rounding

}  // namespace

Points vertex_normals(const TriMesh& mesh) {
    const Points normal = triangle_normals(mesh);
    const Eigen::VectorXd area = triangle_areas(mesh);
    Points sum = Points::Zero(mesh.num_vertices(), 3);
    Eigen::VectorXd around = Eigen::VectorXd::Zero(mesh.num_vertices());
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            sum.row(mesh.triangles(t, k)) += area[t] * normal.row(t);
            around[mesh.triangles(t, k)] += area[t];
        }
    for (int v = 0; v < sum.rows(); ++v) {
        const double length = sum.row(v).norm();
        if (length > cancelled * around[v])
            sum.row(v) /= length;
        else
            sum.row(v).setZero();
    }
    return sum;
}

MotionLimit::MotionLimit(const RestFacts& rest, Points datum) : datum_(std::move(datum)), diagonal_(rest.diagonal) {
    const Parameters& p = rest.parameters;
    const auto lengths = [&](const Eigen::VectorXd& stated) {
        return Eigen::VectorXd(stated.size() > 0
                                   ? Eigen::VectorXd(rest.diagonal * stated)
                                   : Eigen::VectorXd::Constant(datum_.rows(), p.max_displacement * rest.diagonal));
    };
    outward_ = lengths(p.max_outward);
    inward_ = lengths(p.max_inward);
    const double largest = largest_limit(p);
    reference_ = (std::isfinite(largest) && largest > 0 ? largest : default_scale) * rest.diagonal;
    if (outward_ != inward_) normal_ = vertex_normals(with_vertices(rest.surface, datum_));
}

template <class Visit>
void MotionLimit::each(const Points& vertices, const Visit& visit) const {
    for (int v = 0; v < datum_.rows(); ++v) {
        const Eigen::RowVector3d d = vertices.row(v) - datum_.row(v);
        // Without a normal no side is known: the smaller limit holds in every direction.
        const bool has_sides = normal_.rows() > 0 && !normal_.row(v).isZero(0);
        const double any = has_sides ? std::max(outward_[v], inward_[v]) : std::min(outward_[v], inward_[v]);
        const double length = d.norm();
        if (std::isfinite(any)) visit(v, length > 0 ? Eigen::RowVector3d(d / length) : d, length, any);
        if (!has_sides) continue;
        const Eigen::RowVector3d n = normal_.row(v);
        if (outward_[v] < any) visit(v, n, n.dot(d), outward_[v]);
        if (inward_[v] < any) visit(v, Eigen::RowVector3d(-n), -n.dot(d), inward_[v]);
    }
}

bool MotionLimit::is_within(const Points& vertices, double slack) const {
    bool is = true;
    each(vertices, [&](int, const Eigen::RowVector3d&, double moved, double limit) {
        is &= limit > 0 ? moved <= (1 - slack) * limit : moved <= 0.5 * tolerance * reference_;
    });
    return is;
}

MotionLimit::Use MotionLimit::max_use(const Points& vertices, double nearly) const {
    Use most;
    int last = -1;
    each(vertices, [&](int v, const Eigen::RowVector3d&, double moved, double limit) {
        if (!(limit > 0)) return;
        if (moved >= nearly * limit && std::exchange(last, v) != v) ++most.num_there;
        if (most.vertex < 0 || moved / limit > most.share)
            most.vertex = v, most.share = moved / limit, most.limit = limit;
    });
    return most;
}

std::string MotionLimit::excess(const Points& vertices) const {
    double worst = 0, moved_there = 0, limit_there = 0;
    int at = -1, count = 0;
    each(vertices, [&](int v, const Eigen::RowVector3d&, double moved, double limit) {
        const double over = (moved - limit) / (limit > 0 ? limit : reference_);
        if (!(over > tolerance)) return;
        ++count;
        if (!(over > worst)) return;
        worst = over, at = v, moved_there = moved, limit_there = limit;
    });
    if (at < 0) return "";
    return text("vertex ", at, " is ", 100 * moved_there / diagonal_,
                " % of the diagonal from its datum, the motion limit is ", 100 * limit_there / diagonal_, " % (", count,
                count == 1 ? " vertex is" : " vertices are", " beyond), at (", vertices(at, 0), ", ", vertices(at, 1),
                ", ", vertices(at, 2), ")");
}

std::vector<MotionLimit::Row> MotionLimit::rows(const Points& vertices, double min_used, int count) const {
    std::vector<std::pair<double, Row>> all;
    each(vertices, [&](int v, const Eigen::RowVector3d& direction, double moved, double limit) {
        const double use = limit > 0 ? moved / limit : 1 + moved / reference_;
        if (use >= min_used && direction.squaredNorm() > 0) all.push_back({use, {v, direction, moved - limit, limit}});
    });
    // Vertices that use as much but for rounding are taken in their order: units and rounding choose no other ones.
    const auto steps = [](double use) { return std::round(use * 1e9); };
    std::stable_sort(all.begin(), all.end(),
                     [&](const auto& a, const auto& b) { return steps(a.first) > steps(b.first); });
    std::vector<Row> chosen;
    for (const auto& entry : all) {
        const Row& row = entry.second;
        if (static_cast<int>(chosen.size()) >= count) break;
        const bool is_new = std::none_of(chosen.begin(), chosen.end(), [&](const Row& other) {
            return (datum_.row(other.vertex) - datum_.row(row.vertex)).norm() < (1 + 1e-9) * spread * diagonal_ &&
                   other.direction.dot(row.direction) > 0.9;
        });
        if (is_new) chosen.push_back(row);
    }
    return chosen;
}

bool limits_border(const Parameters& p) { return p.keeps_smooth_border && !p.lets_border_turn && !p.planform; }

bool limits_motion(const Parameters& p) {
    if (p.limits_variables) return false;
    const auto any = [&](const Eigen::VectorXd& limits) {
        return limits.size() > 0 ? std::isfinite(limits.minCoeff()) : std::isfinite(p.max_displacement);
    };
    return any(p.max_outward) || any(p.max_inward);
}

Parameters with_stated_limit(Parameters p) {
    if (p.is_limit_stated || p.limits_variables) return p;
    p.variable_scale = variable_scale(p);
    p.max_displacement = std::numeric_limits<double>::infinity();
    p.max_outward.resize(0);
    p.max_inward.resize(0);
    return p;
}

double largest_limit(const Parameters& p) {
    const double everywhere = p.max_displacement;
    return std::max(p.max_outward.size() > 0 ? p.max_outward.maxCoeff() : everywhere,
                    p.max_inward.size() > 0 ? p.max_inward.maxCoeff() : everywhere);
}

double variable_scale(const Parameters& p) {
    if (p.variable_scale > 0) return p.variable_scale;
    return std::isfinite(p.max_displacement) && p.max_displacement > 0 ? p.max_displacement : default_scale;
}

bool has_own_limit(const UserVariable& variable) { return variable.unit > 0 || variable.max_displacement > 0; }

}  // namespace strake
