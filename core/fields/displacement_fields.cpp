#include "core/fields/displacement_fields.hpp"

#include "core/error.hpp"
#include "core/fields/field_functions.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// A motion of which less than this is not done by those before it is left out: scaled up, it would be noise.
constexpr double min_own_share = 1e-3;
constexpr int max_number = 600;
constexpr double on_plane = 1e-6;  ///< of the largest half extent: such vertices lie on the plane of the cut

/// Triangles that share a vertex belong together.
std::vector<std::vector<int>> connected(const TriMesh& mesh, const std::vector<int>& triangles) {
    std::vector<int> root(static_cast<std::size_t>(mesh.num_vertices()));
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](int v) {
        while (root[v] != v) v = root[v] = root[root[v]];
        return v;
    };
    for (const int t : triangles)
        for (int k = 1; k < 3; ++k) {
            const int a = find(mesh.triangles(t, 0)), b = find(mesh.triangles(t, k));
            root[std::max(a, b)] = std::min(a, b);
        }
    std::map<int, std::vector<int>> parts;
    for (const int t : triangles) parts[find(mesh.triangles(t, 0))].push_back(t);
    std::vector<std::vector<int>> result;
    for (auto& [first, part] : parts) result.push_back(std::move(part));
    return result;
}

TriMesh part_of(const TriMesh& mesh, const std::vector<int>& triangles) {
    TriMesh part;
    part.vertices = mesh.vertices;
    part.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t i = 0; i < triangles.size(); ++i)
        part.triangles.row(static_cast<Eigen::Index>(i)) = mesh.triangles.row(triangles[i]);
    return part;
}

struct CutOff {
    VectorXd at_vertices, at_centroids;
    Points gradient;  ///< at the centroids
};

CutOff cut_off(const TriMesh& rest, const Points& centroid, const std::vector<int>& held, bool is_smooth) {
    const Eigen::Index n = rest.num_vertices(), m = rest.num_triangles();
    CutOff cut{VectorXd::Ones(n), VectorXd::Ones(m), Points::Zero(m, 3)};
    for (const std::vector<int>& part : connected(rest, held)) {
        const ClosestPointTree closest(part_of(rest, part));
        VectorXd distance(n);
        for (Eigen::Index v = 0; v < n; ++v) distance[v] = closest.find(rest.vertices.row(v)).distance;
        for (const int t : part)
            for (int k = 0; k < 3; ++k) distance[rest.triangles(t, k)] = 0;
        const double largest = distance.maxCoeff();
        if (!(largest > 0)) throw InvalidInput("fields: all of the surface is held");
        const Eigen::ArrayXd ramps = distance.array() / largest;
        cut.at_vertices.array() *= is_smooth ? Eigen::ArrayXd(ramps.square()) : ramps;
        for (Eigen::Index t = 0; t < m; ++t) {
            const Vector3d x = centroid.row(t);
            const ClosestPoint found = closest.find(x);
            const double linear = found.distance / largest;
            const double ramp = is_smooth ? linear * linear : linear;
            const Vector3d slope =
                (is_smooth ? 2 * linear : 1) *
                (found.distance > 0 ? Vector3d((x - found.point) / (found.distance * largest)) : Vector3d::Zero());
            cut.gradient.row(t) = ramp * cut.gradient.row(t) + cut.at_centroids[t] * slope.transpose();
            cut.at_centroids[t] *= ramp;
        }
    }
    return cut;
}

/// The functions at the vertices, columns in the order of `powers`, times the cut-off.
MatrixXd function_values(const FieldFrame& frame, const Points& x, const std::vector<Powers>& powers,
                         const VectorXd& cut) {
    std::array<int, 3> degree{0, 0, 0};
    for (const Powers& p : powers)
        for (int k = 0; k < 3; ++k) degree[k] = std::max(degree[k], p[k]);
    MatrixXd values(x.rows(), static_cast<Eigen::Index>(powers.size()));
    for (Eigen::Index v = 0; v < x.rows(); ++v) {
        const Vector3d at = frame.local(x.row(v));
        const LegendreValues a(at[0], degree[0]), b(at[1], degree[1]), c(at[2], degree[2]);
        for (std::size_t f = 0; f < powers.size(); ++f)
            values(v, static_cast<Eigen::Index>(f)) =
                cut[v] * a.value[powers[f][0]] * b.value[powers[f][1]] * c.value[powers[f][2]];
    }
    return values;
}

/// Where the field and its gradient are wanted.
struct PointValues {
    Vector3d value = Vector3d::Zero();
    Matrix3d by_local = Matrix3d::Zero();  ///< column k: by the local coordinate k
    PointValues(const FieldFrame& frame, const std::vector<Powers>& powers, const Coefficients& c, const Vector3d& x) {
        std::array<int, 3> degree{0, 0, 0};
        for (const Powers& p : powers)
            for (int k = 0; k < 3; ++k) degree[k] = std::max(degree[k], p[k]);
        const Vector3d at = frame.local(x);
        const LegendreValues a(at[0], degree[0]), b(at[1], degree[1]), d(at[2], degree[2]);
        for (std::size_t f = 0; f < powers.size(); ++f) {
            const Vector3d own = c.row(static_cast<Eigen::Index>(f));
            const auto [i, j, k] = powers[f];
            value += a.value[i] * b.value[j] * d.value[k] * own;
            by_local.col(0) += a.slope[i] * b.value[j] * d.value[k] * own;
            by_local.col(1) += a.value[i] * b.slope[j] * d.value[k] * own;
            by_local.col(2) += a.value[i] * b.value[j] * d.slope[k] * own;
        }
        for (int k = 0; k < 3; ++k) by_local.col(k) *= frame.half[k] > 0 ? 1 / frame.half[k] : 0;
    }
};

/// The point that a field of this symmetry can leave alone: on the plane, and on the axis.
Vector3d symmetric_point(Vector3d x, const std::optional<SymmetryPlane>& plane, const std::optional<ShapeKind>& kind) {
    if (kind && kind->type != ShapeKind::Type::extruded)
        x = kind->through + (x - kind->through).dot(kind->axis) * kind->axis;
    if (plane) x -= (plane->normal.dot(x) - plane->offset) * plane->normal;
    return x;
}

/// Rotation of the polar decomposition, by Newton's iteration X <- (X + X^-T) / 2 (Higham 1986); det F > 0.
Matrix3d polar_rotation(const Matrix3d& F) {
    Matrix3d X = F;
    for (int i = 0; i < 30; ++i) {
        const Matrix3d next = 0.5 * (X + X.inverse().transpose());
        const double change = (next - X).norm();
        X = next;
        if (change < 1e-12) break;
    }
    return X;
}

/// Takes motions one after the other, without what those before them do. Columns are 3 functions long: the mean product
/// over the surface of two motions is that of R times their coefficients.
class Orthogonalization {
public:
    explicit Orthogonalization(MatrixXd triangle) : triangle_(std::move(triangle)) {}

    /// What is left of the motion, of length one; none where next to nothing is.
    std::optional<Coefficients> add(Coefficients motion) {
        const double length = (triangle_ * motion).norm();
        if (!(length > 0)) return {};
        motion /= length;
        for (int pass = 0; pass < 2; ++pass)
            for (const auto& [known, product] : known_) {
                const double share = product.cwiseProduct(triangle_ * motion).sum();
                motion -= share * known;
            }
        Coefficients product = triangle_ * motion;
        const double own = product.norm();
        if (own < min_own_share) return {};
        motion /= own;
        product /= own;
        known_.emplace_back(motion, product);
        return motion;
    }

private:
    MatrixXd triangle_;
    std::vector<std::pair<Coefficients, Coefficients>> known_;
};

void check(const TriMesh& rest, const FieldConditions& conditions, const FieldOptions& options) {
    if (options.number < 1 || options.number > max_number)
        throw InvalidInput(text("fields: number = ", options.number, " must be in [1, ", max_number, "]"));
    if (conditions.cut && conditions.mirror)
        throw InvalidInput("fields: a half model has no mirror image to tie to it");
    for (const int t : conditions.held)
        if (t < 0 || t >= rest.num_triangles())
            throw InvalidInput(text("fields: held triangle ", t, " must be in [0, ", rest.num_triangles(), ")"));
}

}  // namespace

DisplacementFields::DisplacementFields(const TriMesh& rest, const FieldConditions& conditions,
                                       const FieldOptions& options) {
    check(rest, conditions, options);
    const std::optional<SymmetryPlane>& plane = conditions.cut ? conditions.cut : conditions.mirror;
    frame_ = field_frame(rest, plane, conditions.cut.has_value(), options.axis, conditions.kind);
    centroid_ = triangle_centroids(rest);
    CutOff cut = cut_off(rest, centroid_, conditions.held, conditions.smooth_border);
    cut_off_ = std::move(cut.at_centroids);
    cut_off_gradient_ = std::move(cut.gradient);
    if (conditions.still && conditions.held.empty())
        still_ = symmetric_point(*conditions.still, plane, conditions.kind);
    std::vector<FieldCandidate> rigid;
    if (conditions.held.empty() && !conditions.keeps_rigid_motions)
        rigid = rigid_candidates(frame_, plane.has_value(), conditions.kind);
    for (int tried = 2 * options.number + 20;; tried *= 2) {
        const std::vector<FieldCandidate> candidates =
            field_candidates(frame_, plane.has_value(), tried, conditions.kind);
        choose(rest, cut.at_vertices, rigid, candidates, options.number);
        const bool are_all = static_cast<int>(candidates.size()) < tried || tried > 8 * max_number;
        if (size() == options.number || are_all) break;
    }
    if (names_.empty()) throw InvalidInput("fields: nothing is left that could move");
    if (conditions.cut) keep_in_plane(rest, *conditions.cut);
}

void DisplacementFields::choose(const TriMesh& rest, const VectorXd& cut, const std::vector<FieldCandidate>& rigid,
                                const std::vector<FieldCandidate>& candidates, int count) {
    powers_.clear();
    coefficients_.clear();
    names_.clear();
    std::map<Powers, int> number;
    const auto list = [&](const FieldCandidate& candidate) {
        for (const FieldCandidate::Term& term : candidate.terms)
            if (number.emplace(term.powers, static_cast<int>(powers_.size())).second) powers_.push_back(term.powers);
    };
    std::for_each(rigid.begin(), rigid.end(), list);
    std::for_each(candidates.begin(), candidates.end(), list);
    values_ = function_values(frame_, rest.vertices, powers_, cut);
    const Eigen::HouseholderQR<MatrixXd> qr(vertex_areas(rest).cwiseSqrt().asDiagonal() * values_);
    const Eigen::Index rows = std::min(values_.rows(), values_.cols());
    Orthogonalization orthogonal(qr.matrixQR().topRows(rows).template triangularView<Eigen::Upper>());
    const auto motion = [&](const FieldCandidate& candidate) {
        Coefficients c = Coefficients::Zero(values_.cols(), 3);
        for (const FieldCandidate::Term& term : candidate.terms)
            c.row(number.at(term.powers)) += term.factor * frame_.axes.col(term.axis).transpose();
        return c;
    };
    for (const FieldCandidate& candidate : rigid)
        if (!still_) orthogonal.add(motion(candidate));
    for (const FieldCandidate& candidate : candidates) {
        if (size() == count) break;
        Coefficients whole = motion(candidate);
        if (still_) {
            Coefficients left = still_at(*still_, whole);
            if (left.norm() < min_own_share * whole.norm()) continue;  // it was a motion of the whole
            whole = std::move(left);
        }
        const auto own = orthogonal.add(std::move(whole));
        if (!own) continue;
        coefficients_.push_back(*own / (values_ * *own).rowwise().norm().maxCoeff());
        names_.push_back(candidate.name);
    }
}

/// Without the rigid motion that the field does at the point. The functions of first degree are among `powers_`.
DisplacementFields::Coefficients DisplacementFields::still_at(const Vector3d& point, Coefficients motion) const {
    const PointValues here(frame_, powers_, motion, point);
    const Matrix3d gradient = here.by_local * frame_.axes.transpose();
    const Matrix3d spin = 0.5 * (gradient - gradient.transpose());
    Vector3d constant = here.value - spin * point;
    for (std::size_t f = 0; f < powers_.size(); ++f) {
        const auto& [i, j, k] = powers_[f];
        if (i + j + k != 1) continue;
        const int along = i == 1 ? 0 : j == 1 ? 1 : 2;
        const Vector3d axis = frame_.axes.col(along);
        motion.row(static_cast<Eigen::Index>(f)) -= frame_.half[along] * (spin * axis).transpose();
    }
    for (int k = 0; k < 3; ++k) constant += frame_.middle[k] * (spin * frame_.axes.col(k));
    for (std::size_t f = 0; f < powers_.size(); ++f)
        if (powers_[f] == Powers{0, 0, 0}) motion.row(static_cast<Eigen::Index>(f)) -= constant.transpose();
    return motion;
}

/// Bits of rounding do not leave the plane of the cut.
void DisplacementFields::keep_in_plane(const TriMesh& rest, const SymmetryPlane& plane) {
    const double reach = on_plane * frame_.half.maxCoeff();
    for (int v = 0; v < rest.num_vertices(); ++v) {
        if (std::abs(plane.normal.dot(rest.vertices.row(v)) - plane.offset) > reach) continue;
        for (std::size_t f = 0; f < powers_.size(); ++f)
            if (powers_[f][frame_.plane_axis] % 2 == 1) values_(v, static_cast<Eigen::Index>(f)) = 0;
    }
}

DisplacementFields::Coefficients DisplacementFields::combined(const VectorXd& z) const {
    if (z.size() != size()) throw InvalidInput(text("fields: ", z.size(), " values for ", size(), " fields"));
    Coefficients sum = Coefficients::Zero(values_.cols(), 3);
    for (int b = 0; b < size(); ++b)
        if (z[b] != 0) sum += z[b] * coefficients_[static_cast<std::size_t>(b)];
    return sum;
}

Points DisplacementFields::field(int b) const { return values_ * coefficients_[static_cast<std::size_t>(b)]; }

Points DisplacementFields::displacement(const VectorXd& z) const { return values_ * combined(z); }

VectorXd DisplacementFields::gradient(const Points& dJ_dv) const {
    const Coefficients by_function = values_.transpose() * dJ_dv;
    VectorXd gradient(size());
    for (int b = 0; b < size(); ++b)
        gradient[b] = coefficients_[static_cast<std::size_t>(b)].cwiseProduct(by_function).sum();
    return gradient;
}

std::vector<Matrix3d> DisplacementFields::rotations(const VectorXd& z) const {
    std::vector<Matrix3d> turn = local_maps(z);
    for (Matrix3d& F : turn) F = F.determinant() > 0 ? polar_rotation(F) : Matrix3d(Matrix3d::Identity());
    return turn;
}

std::vector<Matrix3d> DisplacementFields::local_maps(const VectorXd& z) const {
    const Coefficients sum = combined(z);
    std::vector<Matrix3d> maps(static_cast<std::size_t>(centroid_.rows()));
    for (Eigen::Index t = 0; t < centroid_.rows(); ++t) {
        const auto [u, by_local] = PointValues(frame_, powers_, sum, centroid_.row(t));
        maps[static_cast<std::size_t>(t)] =
            Matrix3d::Identity() + cut_off_[t] * by_local * frame_.axes.transpose() + u * cut_off_gradient_.row(t);
    }
    return maps;
}

}  // namespace strake
