#include "core/fields/displacement_fields.hpp"

#include "core/error.hpp"
#include "core/fields/function_sum.hpp"
#include "core/fields/function_values.hpp"
#include "core/fields/wing_motions.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "core/parallel.hpp"

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

/// A motion of which less than this is not done by those before it is left out: scaled up, it would be noise.
constexpr double min_own_share = 1e-3;
constexpr int max_number = 600;
constexpr int max_ramps = 4;        ///< a product of more leaves next to nothing between them
constexpr double same_area = 1e-6;  ///< mirror images agree but for rounding
constexpr double on_plane = 1e-6;   ///< of the largest half extent: such vertices lie on the plane of the cut

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

/// A connected held part, and in the whole of a half model its mirror image.
struct HeldPart {
    std::vector<int> triangles;
    double area = 0;         ///< in the whole, of one of the two
    bool has_image = false;  ///< apart from it: a part that touches the plane is one with its image
    int count() const { return has_image ? 2 : 1; }
};

std::vector<HeldPart> held_parts(const TriMesh& rest, const std::vector<int>& held,
                                 const std::optional<SymmetryPlane>& cut) {
    const VectorXd area = triangle_areas(rest);
    const double reach =
        on_plane * 0.5 * (rest.vertices.colwise().maxCoeff() - rest.vertices.colwise().minCoeff()).maxCoeff();
    std::vector<HeldPart> parts;
    for (std::vector<int>& triangles : connected(rest, held)) {
        HeldPart part{std::move(triangles), 0, cut.has_value()};
        for (const int t : part.triangles) {
            part.area += area[t];
            for (int k = 0; cut && k < 3; ++k)
                part.has_image &=
                    std::abs(cut->normal.dot(rest.vertices.row(rest.triangles(t, k))) - cut->offset) > reach;
        }
        if (cut && !part.has_image) part.area *= 2;
        parts.push_back(std::move(part));
    }
    return parts;
}

/// The largest parts stay as they are, as long as they are few; the others become one. Parts of the same size go
/// together, so that a half model does what the whole does.
std::vector<HeldPart> with_small_ones_joined(std::vector<HeldPart> parts) {
    std::stable_sort(parts.begin(), parts.end(), [](const HeldPart& a, const HeldPart& b) { return a.area > b.area; });
    std::size_t own = 0;
    for (int count = 0; own < parts.size();) {
        std::size_t end = own;
        for (; end < parts.size() && parts[end].area > (1 - same_area) * parts[own].area; ++end)
            count += parts[end].count();
        if (count > max_ramps) break;
        own = end;
    }
    if (own == parts.size()) return parts;
    HeldPart joined;  // of it and its image the part itself is the nearer one everywhere in the half
    for (std::size_t p = own; p < parts.size(); ++p)
        joined.triangles.insert(joined.triangles.end(), parts[p].triangles.begin(), parts[p].triangles.end());
    parts.resize(own);
    parts.push_back(std::move(joined));
    return parts;
}

/// Multiplies the cut-off by the ramp of one part: its distance over the largest one of a vertex.
class Ramp {
public:
    Ramp(const TriMesh& rest, const HeldPart& part, const std::optional<SymmetryPlane>& cut, bool is_smooth)
        : rest_(rest),
          closest_(part_of(rest, part.triangles)),
          cut_(part.has_image ? cut : std::nullopt),
          is_smooth_(is_smooth),
          distance_(rest.num_vertices()) {
        for (Eigen::Index v = 0; v < distance_.size(); ++v) distance_[v] = closest_.find(rest.vertices.row(v)).distance;
        for (const int t : part.triangles)
            for (int k = 0; k < 3; ++k) distance_[rest.triangles(t, k)] = 0;
        largest_ = distance_.maxCoeff();
        if (!cut_) return;
        of_image_.resize(distance_.size());
        for (Eigen::Index v = 0; v < distance_.size(); ++v)
            of_image_[v] = closest_.find(mirrored(rest.vertices.row(v))).distance;
        largest_ = std::max(largest_, of_image_.maxCoeff());
    }

    void multiply(CutOff& cut, const Points& centroid) const {
        if (!(largest_ > 0)) throw InvalidInput("fields: all of the surface is held");
        multiply_at_vertices(cut, distance_);
        if (cut_) multiply_at_vertices(cut, of_image_);
        for (Eigen::Index t = 0; t < rest_.num_triangles(); ++t) {
            const Vector3d x = centroid.row(t);
            multiply_at(cut, t, x, false);
            if (cut_) multiply_at(cut, t, x, true);
        }
    }

private:
    Vector3d mirrored(const Vector3d& x) const { return x - 2 * (cut_->normal.dot(x) - cut_->offset) * cut_->normal; }
    void multiply_at_vertices(CutOff& cut, const VectorXd& distance) const {
        const Eigen::ArrayXd ramps = distance.array() / largest_;
        cut.at_vertices.array() *= is_smooth_ ? Eigen::ArrayXd(ramps.square()) : ramps;
    }
    void multiply_at(CutOff& cut, Eigen::Index t, const Vector3d& x, bool of_image) const {
        const Vector3d at = of_image ? mirrored(x) : x;
        const ClosestPoint found = closest_.find(at);
        const double linear = found.distance / largest_;
        const double ramp = is_smooth_ ? linear * linear : linear;
        Vector3d slope = Vector3d::Zero();
        if (found.distance > 0)
            slope = (is_smooth_ ? 2 * linear : 1) * (at - found.point) / (found.distance * largest_);
        if (of_image) slope -= 2 * cut_->normal.dot(slope) * cut_->normal;
        cut.gradient.row(t) = ramp * cut.gradient.row(t) + cut.at_centroids[t] * slope.transpose();
        cut.at_centroids[t] *= ramp;
    }

    const TriMesh& rest_;
    ClosestPointTree closest_;
    std::optional<SymmetryPlane> cut_;  ///< the part has an image of its own behind it
    bool is_smooth_;
    VectorXd distance_, of_image_;
    double largest_ = 0;
};

CutOff cut_off(const TriMesh& rest, const Points& centroid, const FieldConditions& conditions) {
    const Eigen::Index n = rest.num_vertices(), m = rest.num_triangles();
    CutOff cut{VectorXd::Ones(n), VectorXd::Ones(m), Points::Zero(m, 3)};
    for (const HeldPart& part : with_small_ones_joined(held_parts(rest, conditions.held, conditions.cut)))
        Ramp(rest, part, conditions.cut, conditions.smooth_border).multiply(cut, centroid);
    // The centroid of a held triangle is at no distance but for rounding, which has any direction.
    for (const int t : conditions.held) cut.at_centroids[t] = 0, cut.gradient.row(t).setZero();
    return cut;
}

/// The point that a field of this symmetry can leave alone: on the plane, and on the axis.
Vector3d symmetric_point(Vector3d x, const std::optional<SymmetryPlane>& plane, const std::optional<ShapeKind>& kind) {
    if (kind && kind->type != ShapeKind::Type::extruded)
        x = kind->through + (x - kind->through).dot(kind->axis) * kind->axis;
    if (plane) x -= (plane->normal.dot(x) - plane->offset) * plane->normal;
    return x;
}

/// Takes motions one after the other, without what those before them do. Columns are 3 functions long: the mean product
/// over the surface of two motions is that of R times their coefficients.
class Orthogonalization {
public:
    explicit Orthogonalization(MatrixXd triangle) : triangle_(std::move(triangle)) {}

    /// What is left of the motion, of length one; none where next to nothing is. Most of a long list is not: what that
    /// costs are products with what is known, not with the triangle.
    std::optional<Coefficients> add(Coefficients motion) {
        Coefficients product = product_of(motion);
        const double length = product.norm();
        if (!(length > 0)) return {};
        motion /= length;
        product /= length;
        for (int pass = 0; pass < 2; ++pass) {
            std::vector<double> shares;
            for (const auto& [known, known_product] : known_) {
                shares.push_back(known_product.cwiseProduct(product).sum());
                product -= shares.back() * known_product;
            }
            if (product.norm() < min_own_share) return {};
            for (std::size_t k = 0; k < known_.size(); ++k) motion -= shares[k] * known_[k].first;
            product = product_of(motion);  // without what rounding has gathered
        }
        const double own = product.norm();
        motion /= own;
        product /= own;
        known_.emplace_back(motion, product);
        return motion;
    }

private:
    /// The triangle times the motion, by the functions that it has.
    Coefficients product_of(const Coefficients& motion) const {
        Coefficients product = Coefficients::Zero(triangle_.rows(), 3);
        for (Eigen::Index f = 0; f < motion.rows(); ++f)
            if (!motion.row(f).isZero(0)) product.noalias() += triangle_.col(f) * motion.row(f);
        return product;
    }

    MatrixXd triangle_;
    std::vector<std::pair<Coefficients, Coefficients>> known_;
};

void check(const TriMesh& rest, const FieldConditions& conditions, const FieldOptions& options) {
    if (options.number < 1 || options.number > max_number)
        throw InvalidInput(text("fields: number = ", options.number, " must be in [1, ", max_number, "]"));
    if (options.wing && (options.axis || options.along != AlongAxis::polynomials || conditions.kind))
        throw InvalidInput("fields of a wing have no axis, no splines along it and keep no kind of shape");
    const std::vector<std::string>& motions = options.wing ? wing_motions() : field_motions();
    for (const std::string& motion : options.motions)
        if (std::ranges::find(motions, motion) == motions.end()) {
            std::string all;
            for (const std::string& known : motions) all += (all.empty() ? "" : ", ") + known;
            throw InvalidInput(text("fields: motion '", motion, "' is none of ", all));
        }
    if (conditions.cut && conditions.mirror)
        throw InvalidInput("fields: a half model has no mirror image to tie to it");
    for (const int t : conditions.held)
        if (t < 0 || t >= rest.num_triangles())
            throw InvalidInput(text("fields: held triangle ", t, " must be in [0, ", rest.num_triangles(), ")"));
}

std::vector<FieldCandidate> listed(const FunctionSpace& space, bool is_symmetric, int count,
                                   const FieldConditions& conditions, const FieldOptions& options) {
    if (space.wing) return wing_candidates(*space.wing, is_symmetric, options.keeps_planform, count, options.motions);
    return field_candidates(space.frame, is_symmetric, count, conditions.kind, options.motions,
                            space.along == AlongAxis::splines ? max_spline_number : max_polynomial_degree);
}

/// By the functions of the space.
std::vector<FieldCandidate> rigid_motions_in(const FunctionSpace& space, bool is_symmetric,
                                             const std::optional<ShapeKind>& kind) {
    std::vector<FieldCandidate> rigid = rigid_candidates(space.frame, is_symmetric, kind);
    if (!space.wing) return rigid;
    for (FieldCandidate& candidate : rigid)
        for (FieldCandidate::Term& term : candidate.terms)
            if (const auto linear = std::ranges::find(term.powers, 1); linear != term.powers.end())
                term.powers = space.linear(static_cast<int>(linear - term.powers.begin()));
    return rigid;
}

}  // namespace

const std::vector<std::string>& field_motions() {
    static const std::vector<std::string> motions{"move", "scale", "twist", "tilt", "shear", "out", "around"};
    return motions;
}

DisplacementFields::DisplacementFields(const TriMesh& surface, const FieldConditions& conditions,
                                       const FieldOptions& options)
    : products_as_before_(options.products_as_before) {
    space_.along = options.along;
    space_.wing = options.wing;
    check(surface, conditions, options);
    const TriMesh rest = with_loose_vertices_joined(surface);
    const std::optional<SymmetryPlane>& plane = conditions.cut ? conditions.cut : conditions.mirror;
    space_.frame = options.wing ? wing_frame(rest, options.wing->lines(), plane, conditions.cut.has_value())
                                : field_frame(rest, plane, conditions.cut.has_value(), options.axis, conditions.kind,
                                              options.axis_by_extent_alone);
    centroid_ = triangle_centroids(rest);
    CutOff cut = cut_off(rest, centroid_, conditions);
    cut_off_ = std::move(cut.at_centroids);
    cut_off_gradient_ = std::move(cut.gradient);
    if (conditions.still && conditions.held.empty())
        still_ = symmetric_point(*conditions.still, plane, conditions.kind);
    std::vector<FieldCandidate> rigid;
    if (conditions.held.empty() && !conditions.keeps_rigid_motions)
        rigid = rigid_motions_in(space_, plane.has_value(), conditions.kind);
    int before = -1;  // twice as many that add nothing: the vertices have no more
    for (int tried = 2 * options.number + 20;; tried *= 2) {
        const std::vector<FieldCandidate> candidates = listed(space_, plane.has_value(), tried, conditions, options);
        const bool are_all = static_cast<int>(candidates.size()) < tried || tried > 8 * max_number;
        choose(rest, cut.at_vertices, rigid, candidates, options.number);
        if (size() == options.number || are_all || size() == before) break;
        before = size();
    }
    if (names_.empty()) throw InvalidInput("fields: nothing is left that could move");
    if (conditions.cut) keep_in_plane(rest, *conditions.cut);
    const std::vector<char> used = used_vertices(rest);
    for (Eigen::Index v = 0; v < values_.rows(); ++v)
        if (!used[static_cast<std::size_t>(v)]) values_.row(v).setZero();
}

void DisplacementFields::choose(const TriMesh& rest, const VectorXd& cut, const std::vector<FieldCandidate>& rigid,
                                const std::vector<FieldCandidate>& candidates, int count) {
    space_.powers.clear();
    coefficients_.clear();
    names_.clear();
    std::map<Powers, int> number;
    const auto list = [&](const FieldCandidate& candidate) {
        for (const FieldCandidate::Term& term : candidate.terms)
            if (number.emplace(term.powers, static_cast<int>(space_.powers.size())).second)
                space_.powers.push_back(term.powers);
    };
    std::for_each(rigid.begin(), rigid.end(), list);
    std::for_each(candidates.begin(), candidates.end(), list);
    const auto count_of_functions = static_cast<Eigen::Index>(space_.powers.size());
    values_.resize(0, 0);  // before others take its place
    FunctionValues at_vertices{LocalFunctions(space_), rest.vertices, space_.powers, cut};
    Orthogonalization orthogonal(ValuesQR(at_vertices, vertex_areas(rest)).triangle());
    const auto motion = [&](const FieldCandidate& candidate) {
        Coefficients c = Coefficients::Zero(count_of_functions, 3);
        for (const FieldCandidate::Term& term : candidate.terms)
            c.row(number.at(term.powers)) += term.factor * space_.frame.axes.col(term.axis).transpose();
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
        coefficients_.push_back(*own);
        names_.push_back(candidate.name);
    }
    keep_used(at_vertices);
}

/// Keeps the values of functions that a field has, and scales the fields.
void DisplacementFields::keep_used(FunctionValues& at_vertices) {
    std::vector<char> is_used(space_.powers.size(), products_as_before_);
    for (const Coefficients& own : coefficients_)
        for (const std::size_t f : used_functions(own)) is_used[f] = 1;
    columns_.clear();
    for (std::size_t f = 0; f < is_used.size(); ++f)
        if (is_used[f]) columns_.push_back(static_cast<int>(f));
    const Eigen::Index rows = at_vertices.x.rows();
    values_.resize(rows, static_cast<Eigen::Index>(columns_.size()));
    LargestMotions largest(coefficients_);
    MatrixXd block;
    for (Eigen::Index row = 0; row < rows; row += vertices_at_once) {
        block.resize(std::min(vertices_at_once, rows - row), static_cast<Eigen::Index>(space_.powers.size()));
        at_vertices.fill(row, block);
        largest.add(block);
        for (std::size_t c = 0; c < columns_.size(); ++c)
            values_.col(static_cast<Eigen::Index>(c)).segment(row, block.rows()) = block.col(columns_[c]);
    }
    const VectorXd lengths = largest.result();
    for (int b = 0; b < size(); ++b) coefficients_[static_cast<std::size_t>(b)] /= lengths[b];
}

/// Without the rigid motion that the field does at the point. The functions of first degree are among `space_.powers`.
DisplacementFields::Coefficients DisplacementFields::still_at(const Vector3d& point, Coefficients motion) const {
    Vector3d value;
    Matrix3d by_local;
    FunctionSum(space_, motion).at(point, value, by_local);
    const Matrix3d gradient = by_local * space_.frame.axes.transpose();
    const Matrix3d spin = 0.5 * (gradient - gradient.transpose());
    Vector3d constant = value - spin * point;
    for (std::size_t f = 0; f < space_.powers.size(); ++f) {
        const int along = space_.linear_axis(space_.powers[f]);
        if (along < 0) continue;
        const Vector3d axis = space_.frame.axes.col(along);
        motion.row(static_cast<Eigen::Index>(f)) -= space_.frame.half[along] * (spin * axis).transpose();
    }
    for (int k = 0; k < 3; ++k) constant += space_.frame.middle[k] * (spin * space_.frame.axes.col(k));
    for (std::size_t f = 0; f < space_.powers.size(); ++f)
        if (space_.powers[f] == Powers{0, 0, 0}) motion.row(static_cast<Eigen::Index>(f)) -= constant.transpose();
    return motion;
}

/// Bits of rounding do not leave the plane of the cut.
void DisplacementFields::keep_in_plane(const TriMesh& rest, const SymmetryPlane& plane) {
    const double reach = on_plane * space_.frame.half.maxCoeff();
    for (int v = 0; v < rest.num_vertices(); ++v) {
        if (std::abs(plane.normal.dot(rest.vertices.row(v)) - plane.offset) > reach) continue;
        for (std::size_t c = 0; c < columns_.size(); ++c)
            if (space_.is_odd(space_.powers[static_cast<std::size_t>(columns_[c])]))
                values_(v, static_cast<Eigen::Index>(c)) = 0;
    }
}

DisplacementFields::Coefficients DisplacementFields::combined(const VectorXd& z) const {
    if (z.size() != size()) throw InvalidInput(text("fields: ", z.size(), " values for ", size(), " fields"));
    Coefficients sum = Coefficients::Zero(static_cast<Eigen::Index>(space_.powers.size()), 3);
    for (int b = 0; b < size(); ++b)
        if (z[b] != 0) sum += z[b] * coefficients_[static_cast<std::size_t>(b)];
    return sum;
}

/// By Newton's iteration X <- (X + X^-T) / 2.
Matrix3d polar_rotation(const Matrix3d& F) {
    Matrix3d X = F;
    for (int i = 0; i < 30; ++i) {
        const Matrix3d next = 0.5 * (X + X.inverse().transpose());
        const double change = (next - X).norm();
        X = next;
        if (change < 1e-7) break;  // the error is about its square
    }
    return X;
}

Points DisplacementFields::field(int b) const {
    const Coefficients& own = coefficients_[static_cast<std::size_t>(b)];
    if (products_as_before_) return values_ * own;
    return thin_product(values_, own(columns_, Eigen::all));
}

Points DisplacementFields::displacement(const VectorXd& z) const {
    return thin_product(values_, combined(z)(columns_, Eigen::all));
}

VectorXd DisplacementFields::gradient(const Points& dJ_dv) const {
    return gradient_by(thin_transposed_product(values_, dJ_dv));
}

VectorXd DisplacementFields::gradient(int vertex, const Vector3d& dJ_dv) const {
    return gradient_by(values_.row(vertex).transpose() * dJ_dv.transpose());
}

/// @param by_kept by the functions that a field has
VectorXd DisplacementFields::gradient_by(const Coefficients& by_kept) const {
    Coefficients by_function = Coefficients::Zero(static_cast<Eigen::Index>(space_.powers.size()), 3);
    by_function(columns_, Eigen::all) = by_kept;
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
    const FunctionSum all(space_, combined(z));
    std::vector<Matrix3d> maps(static_cast<std::size_t>(centroid_.rows()));
    for_blocks(static_cast<int>(centroid_.rows()), 4096, [&](int begin, int end) {
        FunctionSum sum = all;  // it remembers its last point
        Vector3d u;
        Matrix3d by_local;
        for (Eigen::Index t = begin; t < end; ++t) {
            sum.at(centroid_.row(t), u, by_local);
            maps[static_cast<std::size_t>(t)] = Matrix3d::Identity() +
                                                cut_off_[t] * by_local * space_.frame.axes.transpose() +
                                                u * cut_off_gradient_.row(t);
        }
    });
    return maps;
}

VectorXd DisplacementFields::map_gradient(int triangle, const Matrix3d& dJ_dF) const {
    if (triangle < 0 || triangle >= centroid_.rows())
        throw InvalidInput(text("fields: triangle ", triangle, " is not in [0, ", centroid_.rows(), ")"));
    LocalFunctions functions(space_);
    functions.set(centroid_.row(triangle));
    const Vector3d by_value = dJ_dF * cut_off_gradient_.row(triangle).transpose();
    const Matrix3d by_slope = cut_off_[triangle] * dJ_dF * space_.frame.axes;
    Coefficients by_function(static_cast<Eigen::Index>(space_.powers.size()), 3);
    for (std::size_t f = 0; f < space_.powers.size(); ++f) {
        Vector3d own = functions.value(space_.powers[f]) * by_value;
        for (int k = 0; k < 3; ++k) own += functions.slope(space_.powers[f], k) * by_slope.col(k);
        by_function.row(static_cast<Eigen::Index>(f)) = own.transpose();
    }
    VectorXd gradient(size());
    for (int b = 0; b < size(); ++b)
        gradient[b] = coefficients_[static_cast<std::size_t>(b)].cwiseProduct(by_function).sum();
    return gradient;
}

}  // namespace strake
