#include "core/planform/section_motion.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/parallel.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace strake {
namespace {

using Complex = std::complex<double>;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int per_knot = 5;            ///< amplitudes: c, k
constexpr double widest_gap = 0.08;    ///< of the semispan, between knots
constexpr double least_gap = 0.02;     ///< likewise
constexpr double beyond_tip = 0.3;     ///< likewise: how far s grows
constexpr double seam = 0.05;          ///< of the semispan, on either side, between both sides of a wing
constexpr double smoothing = 1e-8;     ///< of the vertices' weight, on second differences between knots
constexpr double on_plane_rel = 1e-6;  ///< of the semispan: a root that lies in the plane of symmetry
constexpr double held = 1e12;          ///< weight of what is held there, over that of the vertices
constexpr int block = 256;             ///< points at a time

double smooth_step(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

double wendland(double x) {
    if (x >= 1) return 0;
    const double rest = (1 - x) * (1 - x);
    return rest * rest * (4 * x + 1);
}

/// Stations, kinks, root and tip, and others between, so that no gap is wide.
std::vector<double> knot_stations(const TriMesh& start, const Wing& wing) {
    std::vector<double> all{0, 1};
    const auto add = [&](double wanted) {
        if (std::ranges::all_of(all, [&](double s) { return std::abs(s - wanted) >= least_gap; }))
            all.push_back(wanted);
    };
    WingDeclaration plain = wing.declaration();
    plain.stations.clear();
    for (const double s : wing.stations()) add(s);
    const Wing by_kinks(start, plain);
    for (const double s : by_kinks.stations()) add(s);
    std::sort(all.begin(), all.end());
    std::vector<double> filled;
    for (std::size_t k = 0; k + 1 < all.size(); ++k) {
        const int pieces = static_cast<int>(std::ceil((all[k + 1] - all[k]) / widest_gap));
        for (int i = 0; i < pieces; ++i) filled.push_back(all[k] + (all[k + 1] - all[k]) * i / pieces);
    }
    filled.push_back(1);
    return filled;
}

TriMesh part_of(const TriMesh& mesh, const std::vector<char>& marks, char wanted) {
    TriMesh part;
    part.vertices = mesh.vertices;
    part.triangles.resize(std::count(marks.begin(), marks.end(), wanted), 3);
    Eigen::Index row = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (marks[static_cast<std::size_t>(t)] == wanted) part.triangles.row(row++) = mesh.triangles.row(t);
    return part;
}

}  // namespace

SectionMotion::SectionMotion(const TriMesh& start, const std::vector<std::shared_ptr<const Wing>>& wings, double reach,
                             const std::optional<SymmetryPlane>& symmetry)
    : num_vertices_(start.num_vertices()), reach_(reach), symmetry_(symmetry) {
    if (!(reach > 0) || !std::isfinite(reach))
        throw InvalidInput(text("motion of sections: reach = ", reach, " must be > 0 and finite"));
    if (symmetry) {
        const Vector3d middle = start.vertices.colwise().mean();
        side_of_plane_ = symmetry->normal.dot(middle) < symmetry->offset ? -1 : 1;
    }
    for (const auto& wing : wings)
        if (!wing->has_winglet()) add_wing(start, wing);
}

int SectionMotion::size() const {
    return sides_.empty() ? 0 : sides_.back().first + per_knot * static_cast<int>(sides_.back().knots.size());
}

void SectionMotion::add_wing(const TriMesh& start, const std::shared_ptr<const Wing>& wing) {
    const WingDeclaration& declared = wing->declaration();
    MovedWing moved;
    moved.first = static_cast<int>(sides_.size());
    moved.count = wing->num_sides();
    std::vector<char> of_wing(static_cast<std::size_t>(start.num_triangles()), 0);
    for (int s = 0; s < wing->num_sides(); ++s)
        for (const int t : wing->triangles(s)) of_wing[static_cast<std::size_t>(t)] = 1;
    moved.tree = std::make_unique<ClosestPointTree>(part_of(start, of_wing, 1));
    if (std::find(of_wing.begin(), of_wing.end(), 0) != of_wing.end())
        moved.others = std::make_unique<ClosestPointTree>(part_of(start, of_wing, 0));
    const std::vector<double> stations = knot_stations(start, *wing);
    for (int s = 0; s < wing->num_sides(); ++s) {
        Side side;
        side.span = wing->span(s);
        side.downstream = declared.downstream;
        side.up = wing->up_at(s, 0);
        side.root = wing->root(s);
        side.reach = wing->reach(start, s);
        side.first = size();
        side.vertices = wing->vertices(s);
        sides_.push_back(std::move(side));
    }
    for (const double station : stations) {
        std::vector<Wing::PlacedSection> sections;
        try {
            sections = wing->placed_sections(start, station);
        } catch (const InvalidInput&) {
            if (station == 0 || station == 1) throw;
            continue;  // one of those between
        }
        for (int s = 0; s < wing->num_sides(); ++s) {
            const Wing::PlacedSection& section = sections[static_cast<std::size_t>(s)];
            std::vector<Knot>& knots = sides_[static_cast<std::size_t>(moved.first + s)].knots;
            const double place = wing->place(s, station);
            if (!knots.empty() && place < knots.back().place + 1e-6) continue;
            const Vector3d chord = section.trailing_edge - section.leading_edge;
            knots.push_back({place,
                             Complex(chord.dot(declared.downstream),
                                     chord.dot(sides_[static_cast<std::size_t>(moved.first + s)].up)),
                             section.leading_edge + declared.axis * chord});
        }
    }
    for (int s = 0; s < moved.count; ++s) {
        const auto number = static_cast<std::size_t>(moved.first + s);
        if (s > 0)
            sides_[number].first =
                sides_[number - 1].first + per_knot * static_cast<int>(sides_[number - 1].knots.size());
        prepare_fit(sides_[number], moved.first + s, start, wing->triangles(s));
    }
    wings_.push_back(std::move(moved));
}

/// The normal equations, with second differences between knots where vertices are few.
void SectionMotion::prepare_fit(Side& side, int number, const TriMesh& start, const std::vector<int>& triangles) {
    VectorXd all = VectorXd::Zero(start.num_vertices());
    for (const int t : triangles) {
        const double third = area_vector(start, t).norm() / 3;
        for (const int v : start.triangles.row(t)) all[v] += third;
    }
    side.area = all(side.vertices);
    const auto count = static_cast<Eigen::Index>(side.knots.size());
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(per_knot * count, per_knot * count);
    for (std::size_t i = 0; i < side.vertices.size(); ++i) {
        side.spots.push_back(spot_at(number, start.vertices.row(side.vertices[i]), 1));
        const Spot& spot = side.spots.back();
        Eigen::Matrix<double, 3, 2 * per_knot> rows;
        VectorXd row(side.first + normal.rows());
        for (int c = 0; c < 3; ++c) {
            row.setZero();
            add_transposed(spot, Vector3d::Unit(c), row);
            rows.row(c) = row.segment<2 * per_knot>(side.first + per_knot * spot.knot);
        }
        normal.block<2 * per_knot, 2 * per_knot>(per_knot * spot.knot, per_knot * spot.knot) +=
            side.area[static_cast<Eigen::Index>(i)] * rows.transpose() * rows;
    }
    const double weight = side.area.sum();
    for (Eigen::Index k = 1; k + 1 < count; ++k) {
        const auto at = [&](Eigen::Index n) { return side.knots[static_cast<std::size_t>(n)].place; };
        const double r = (at(k) - at(k - 1)) / (at(k + 1) - at(k - 1));
        const std::array<double, 3> difference{1 - r, -1, r};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                for (int a = 0; a < per_knot; ++a)
                    normal(per_knot * (k - 1 + i) + a, per_knot * (k - 1 + j) + a) +=
                        smoothing * weight * difference[static_cast<std::size_t>(i)] *
                        difference[static_cast<std::size_t>(j)];
    }
    normal.diagonal().array() += 1e-14 * weight;
    if (symmetry_ && std::abs(std::abs(symmetry_->normal.dot(side.span)) - 1) < 1e-9 &&
        std::abs(side.root * side.span.dot(symmetry_->normal) - symmetry_->offset) < on_plane_rel * side.reach)
        normal.topLeftCorner<3, 3>() += held * weight * symmetry_->normal * symmetry_->normal.transpose();
    side.inverse = normal.ldlt().solve(Eigen::MatrixXd::Identity(normal.rows(), normal.cols()));
}

/// At a place along the span, from a knot to the next one.
SectionMotion::Spot SectionMotion::spot_between(int number, int knot, double place, double weight,
                                                const Vector3d& x) const {
    const Side& side = sides_[static_cast<std::size_t>(number)];
    const Knot &a = side.knots[static_cast<std::size_t>(knot)], &b = side.knots[static_cast<std::size_t>(knot) + 1];
    Spot spot{number, knot, (place - a.place) / (b.place - a.place), weight, 0};
    const double inside = std::clamp(spot.along, 0.0, 1.0);
    const Vector3d from = x - (a.axis + spot.along * (b.axis - a.axis));
    spot.zeta = Complex(from.dot(side.downstream), from.dot(side.up)) / (a.chord + inside * (b.chord - a.chord));
    return spot;
}

SectionMotion::Spot SectionMotion::spot_at(int number, const Vector3d& x, double weight) const {
    const Side& side = sides_[static_cast<std::size_t>(number)];
    const double first = side.knots.front().place, last = side.knots.back().place;
    const auto limited = [&](double s) {
        if (s <= last) return std::max(s, first);
        return last - beyond_tip * std::expm1(-(s - last) / beyond_tip);
    };
    const int pieces = static_cast<int>(side.knots.size()) - 1;
    const double s = limited(side.outboard(x) / side.reach);
    int k = 0;
    while (k + 1 < pieces && side.knots[static_cast<std::size_t>(k) + 1].place < s) ++k;
    return spot_between(number, k, s, weight, x);
}

double SectionMotion::share_of(const MovedWing& wing, const Vector3d& x) const {
    const double d = wing.tree->find(x).distance, fade = wendland(d / reach_);
    if (fade == 0 || d == 0 || !wing.others) return fade;
    return fade * (1 - smooth_step(d / (d + wing.others->find(x).distance)));
}

void SectionMotion::add_all_spots(const Vector3d& x, std::vector<Spot>& found) const {
    for (const MovedWing& wing : wings_) {
        const double share = share_of(wing, x);
        if (share == 0) continue;
        if (wing.count == 1) {
            found.push_back(spot_at(wing.first, x, share));
            continue;
        }
        const Side &one = sides_[static_cast<std::size_t>(wing.first)],
                   &other = sides_[static_cast<std::size_t>(wing.first) + 1];
        const double t = smooth_step(0.5 + (one.outboard(x) - other.outboard(x)) / (4 * seam * one.reach));
        if (t > 0) found.push_back(spot_at(wing.first, x, share * t));
        if (t < 1) found.push_back(spot_at(wing.first + 1, x, share * (1 - t)));
    }
}

bool SectionMotion::is_image(const Vector3d& x) const {
    return symmetry_ && side_of_plane_ * (symmetry_->normal.dot(x) - symmetry_->offset) < 0;
}

Vector3d SectionMotion::mirrored(const Vector3d& x) const {
    return x - 2 * (symmetry_->normal.dot(x) - symmetry_->offset) * symmetry_->normal;
}

Vector3d SectionMotion::moved(const Spot& spot, const VectorXd& amplitudes) const {
    const Side& side = sides_[static_cast<std::size_t>(spot.side)];
    const double* a = amplitudes.data() + side.first + per_knot * spot.knot;
    const double inside = std::clamp(spot.along, 0.0, 1.0);
    const auto shift = [](const double* at) { return Eigen::Map<const Vector3d>(at); };
    const Complex k = (1 - inside) * Complex(a[3], a[4]) + inside * Complex(a[per_knot + 3], a[per_knot + 4]);
    const Complex by = k * spot.zeta;
    return spot.weight * ((1 - spot.along) * shift(a) + spot.along * shift(a + per_knot) + by.real() * side.downstream +
                          by.imag() * side.up);
}

void SectionMotion::add_transposed(const Spot& spot, const Vector3d& by, VectorXd& amplitudes) const {
    const Side& side = sides_[static_cast<std::size_t>(spot.side)];
    double* a = amplitudes.data() + side.first + per_knot * spot.knot;
    const double inside = std::clamp(spot.along, 0.0, 1.0);
    const Complex k = spot.weight * Complex(by.dot(side.downstream), by.dot(side.up)) * std::conj(spot.zeta);
    for (int c = 0; c < 3; ++c) {
        a[c] += spot.weight * (1 - spot.along) * by[c];
        a[per_knot + c] += spot.weight * spot.along * by[c];
    }
    a[3] += (1 - inside) * k.real();
    a[4] += (1 - inside) * k.imag();
    a[per_knot + 3] += inside * k.real();
    a[per_knot + 4] += inside * k.imag();
}

VectorXd SectionMotion::fitted(const Points& displacement) const {
    VectorXd result = VectorXd::Zero(size());
    for (const Side& side : sides_) {
        VectorXd right = VectorXd::Zero(size());
        for (std::size_t i = 0; i < side.vertices.size(); ++i) {
            const Vector3d u = side.area[static_cast<Eigen::Index>(i)] * displacement.row(side.vertices[i]).transpose();
            add_transposed(side.spots[i], u, right);
        }
        const Eigen::Index count = side.inverse.rows();
        result.segment(side.first, count) = side.inverse * right.segment(side.first, count);
    }
    return result;
}

Points SectionMotion::fitted_transpose(const VectorXd& by_amplitude) const {
    Points result = Points::Zero(num_vertices_, 3);
    VectorXd solved = VectorXd::Zero(size());
    for (const Side& side : sides_) {
        const Eigen::Index count = side.inverse.rows();
        solved.segment(side.first, count) = side.inverse.transpose() * by_amplitude.segment(side.first, count);
        for (std::size_t i = 0; i < side.vertices.size(); ++i)
            result.row(side.vertices[i]) += side.area[static_cast<Eigen::Index>(i)] * moved(side.spots[i], solved);
    }
    return result;
}

/// The motion at points, with their spots; those of mirror images are mirrored.
class SectionMotion::At : public SpaceMotion::Field {
public:
    At(const SectionMotion& motion, const Points& points)
        : motion_(motion), first_(static_cast<std::size_t>(points.rows()) + 1, 0), is_image_(first_.size() - 1, 0) {
        const int count = static_cast<int>(points.rows());
        std::vector<std::vector<Spot>> found(static_cast<std::size_t>((count + block - 1) / block));
        for_blocks(count, block, [&](int begin, int end) {
            auto& own = found[static_cast<std::size_t>(begin / block)];
            for (int p = begin; p < end; ++p) {
                const auto i = static_cast<std::size_t>(p);
                const std::size_t before = own.size();
                Vector3d x = points.row(p);
                is_image_[i] = motion.is_image(x);
                if (is_image_[i]) x = motion.mirrored(x);
                motion.add_all_spots(x, own);
                first_[i + 1] = static_cast<int>(own.size() - before);
            }
        });
        for (std::size_t p = 0; p + 1 < first_.size(); ++p) first_[p + 1] += first_[p];
        spots_.reserve(static_cast<std::size_t>(first_.back()));
        for (const auto& own : found) spots_.insert(spots_.end(), own.begin(), own.end());
    }

    Points displacement(const VectorXd& amplitudes) const override {
        Points result = Points::Zero(static_cast<Eigen::Index>(is_image_.size()), 3);
        for (std::size_t p = 0; p < is_image_.size(); ++p) {
            Vector3d u = Vector3d::Zero();
            for (int s = first_[p]; s < first_[p + 1]; ++s)
                u += motion_.moved(spots_[static_cast<std::size_t>(s)], amplitudes);
            result.row(static_cast<Eigen::Index>(p)) = turned(p, u);
        }
        return result;
    }

    VectorXd transpose(const Points& by_displacement) const override {
        VectorXd result = VectorXd::Zero(motion_.size());
        for (std::size_t p = 0; p < is_image_.size(); ++p) {
            const Vector3d by = turned(p, by_displacement.row(static_cast<Eigen::Index>(p)));
            for (int s = first_[p]; s < first_[p + 1]; ++s)
                motion_.add_transposed(spots_[static_cast<std::size_t>(s)], by, result);
        }
        return result;
    }

private:
    Vector3d turned(std::size_t p, const Vector3d& u) const {
        if (!is_image_[p]) return u;
        const Vector3d& n = motion_.symmetry_->normal;
        return u - 2 * u.dot(n) * n;
    }

    const SectionMotion& motion_;
    std::vector<int> first_;
    std::vector<char> is_image_;
    std::vector<Spot> spots_;
};

std::unique_ptr<const SpaceMotion::Field> SectionMotion::at(const Points& points) const {
    return std::make_unique<At>(*this, points);
}

}  // namespace strake
