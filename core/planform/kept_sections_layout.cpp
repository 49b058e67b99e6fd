#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/planform/kept_sections.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

/// Where the knots of kept sections lie, and what each vertex has of them.
namespace strake {
namespace {

using Complex = std::complex<double>;
using Eigen::Vector3d;

constexpr int table_rows = 48;                                 ///< of the table of edges
constexpr double min_gap = 1.0 / 128, earlier_gap = 1.0 / 64;  ///< of the semispan, between knots
constexpr double widest_gap = 0.3;                             ///< likewise, beyond which a wing has too few to be kept
constexpr double largest_return = 50;                          ///< of what edges are off, by which vertices move
constexpr double edge_share = 0.05;                            ///< of the chord: vertices that tell where rows are
constexpr double fixed_reach = 0.25;                           ///< of the root chord
constexpr double body_reach = 0.5;                             ///< likewise
constexpr double plane_margin = 0.02;  ///< of the semispan: triangles that a streamwise plane may come to meet
constexpr double steep_margin = 0.15;  ///< likewise, on wings with winglets
constexpr double same_place = 1e-9;
constexpr double sharp_turn = 0.5;                      ///< cosine between neighbouring rows of the table
constexpr int polynomial_points = 7, many_points = 10;  ///< of a nose
constexpr double min_share = 1e-3;                      ///< of a knot that is left to edges which are fixed
constexpr int nose_samples = 64;                        ///< along the span
constexpr double nose_reach = 0.045;                    ///< of the chord: what shows an edge lies within 4 %
constexpr double nose_fade = 0.2;                       ///< likewise, where nothing of the nose is held

/// 0 at 0, 1 from 1 on, with no slope at either.
double smooth_step(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// Of a nose whose edge is kept as sections show it.
int min_points(KeptRules rules) { return rules == KeptRules::earlier ? many_points : polynomial_points; }

double distance_to(const std::vector<int>& vertices, const Points& positions, const Vector3d& x) {
    double least = std::numeric_limits<double>::infinity();
    for (const int v : vertices) least = std::min(least, (positions.row(v).transpose() - x).squaredNorm());
    return std::sqrt(least);
}

/// Vertices at triangles of both kinds.
std::vector<int> border_between(const TriMesh& mesh, const std::vector<char>& listed) {
    std::vector<char> seen(static_cast<std::size_t>(mesh.num_vertices()), 0);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (const int v : mesh.triangles.row(t))
            seen[static_cast<std::size_t>(v)] |= listed[static_cast<std::size_t>(t)] ? 1 : 2;
    std::vector<int> found;
    for (int v = 0; v < mesh.num_vertices(); ++v)
        if (seen[static_cast<std::size_t>(v)] == 3) found.push_back(v);
    return found;
}

/// Per triangle of a side: the places that planes which may come to meet it have.
std::vector<std::array<double, 2>> reaches(const TriMesh& mesh, const Wing& wing, int side, double reach, double more) {
    std::vector<std::array<double, 2>> all;
    for (const int t : wing.triangles(side)) {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const int v : mesh.triangles.row(t)) {
            const double at = wing.fraction_at(side, reach, mesh.vertices.row(v));
            low = std::min(low, at), high = std::max(high, at);
        }
        all.push_back({low - more, high + more});
    }
    return all;
}

/// 0 on what is fixed, 1 at some distance.
class Distance {
public:
    Distance(const TriMesh& mesh, const std::vector<int>& fixed)
        : mesh_(mesh), is_fixed_(static_cast<std::size_t>(mesh.num_vertices()), 0) {
        std::vector<char> marks(static_cast<std::size_t>(mesh.num_triangles()), 0);
        for (const int t : fixed) {
            marks[static_cast<std::size_t>(t)] = 1;
            for (const int v : mesh.triangles.row(t)) is_fixed_[static_cast<std::size_t>(v)] = 1;
        }
        border_ = border_between(mesh, marks);
    }
    double operator()(int v, double root_chord) const {
        if (is_fixed_[static_cast<std::size_t>(v)]) return 0;
        if (border_.empty()) return 1;
        return smooth_step(distance_to(border_, mesh_.vertices, mesh_.vertices.row(v)) / (fixed_reach * root_chord));
    }

private:
    const TriMesh& mesh_;
    std::vector<char> is_fixed_;  ///< per vertex
    std::vector<int> border_;
};

/// Calls found(v, share) for vertices near a root that shares edges with a body, of the same part and not of the wing.
void each_near_root(const TriMesh& mesh, const std::vector<int>& wing, double reach, const std::vector<char>& placed,
                    const std::function<void(int, double)>& found) {
    const std::vector<int> part = edge_components(mesh, adjacency(mesh));
    std::vector<char> of_wing(static_cast<std::size_t>(mesh.num_triangles()), 0);
    for (const int t : wing) of_wing[static_cast<std::size_t>(t)] = 1;
    const std::vector<int> border = border_between(mesh, of_wing);
    std::vector<char> is_near(placed.size(), 0);  // of the same part
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (const int v : mesh.triangles.row(t))
            is_near[static_cast<std::size_t>(v)] |=
                part[static_cast<std::size_t>(t)] == part[static_cast<std::size_t>(wing.front())];
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        if (!is_near[static_cast<std::size_t>(v)] || placed[static_cast<std::size_t>(v)]) continue;
        const double near = 1 - smooth_step(distance_to(border, mesh.vertices, mesh.vertices.row(v)) / reach);
        if (near > 0) found(v, near);
    }
}

}  // namespace

KeptSections::KeptSections(const TriMesh& start, const std::vector<std::shared_ptr<const Wing>>& wings,
                           const std::vector<int>& fixed, KeptRules rules)
    : start_(start), rules_(rules) {
    // Knots that are closer than what a mesh has there are taken back by each other alone, with amounts that grow from
    // one to the next.
    const double first = rules == KeptRules::earlier ? earlier_gap : min_gap;
    for (double gap = first; gap < widest_gap; gap *= 2) {
        lay_out(wings, fixed, gap);
        if (num_knots_ == 0) return;
        Eigen::VectorXd reach(2 * num_knots_);  // how far a knot moves vertices: less beside what is fixed
        for (int k = 0; k < reach.size(); ++k) reach[k] = Eigen::VectorXd(by_knots_.col(k)).cwiseAbs().maxCoeff();
        const Eigen::MatrixXd back = reach.asDiagonal() * at_start_->by_knots.inverse();
        if (back.allFinite() && back.cwiseAbs().rowwise().sum().maxCoeff() < largest_return) return;
    }
    throw InvalidInput(text("wing '", wings.front()->declaration().name,
                            "': the mesh is too coarse or too irregular along its edges to bring them back"));
}

void KeptSections::lay_out(const std::vector<std::shared_ptr<const Wing>>& wings, const std::vector<int>& fixed,
                           double knot_gap) {
    sides_.clear();
    sections_.clear();
    num_knots_ = 0;
    shares_.assign(static_cast<std::size_t>(num_vertices()), {});
    across_ = Points::Zero(num_vertices(), 3);
    freedom_ = Eigen::VectorXd::Ones(num_vertices());
    holds_noses_ = false;
    at_start_.reset();
    latest_.reset();
    for (const auto& wing : wings)
        for (int s = 0; s < wing->num_sides(); ++s) add_side(wing, s, knot_gap);
    share_centre();
    for (const Side& side : sides_) add_sections(side);
    place_vertices(fixed);
    hold_noses();
    std::vector<Eigen::Triplet<double>> entries;
    for (int v = 0; v < num_vertices(); ++v) {
        const Share& share = shares_[static_cast<std::size_t>(v)];
        for (const Term& term : share.terms)
            for (int c = 0; c < 3; ++c) {
                const double a = share.downstream[c], b = share.up[c];
                entries.emplace_back(3 * v + c, 2 * term.knot, a * term.weight.real() + b * term.weight.imag());
                entries.emplace_back(3 * v + c, 2 * term.knot + 1, b * term.weight.real() - a * term.weight.imag());
            }
    }
    by_knots_.resize(3 * num_vertices(), 2 * num_knots_);
    by_knots_.setFromTriplets(entries.begin(), entries.end());
    drop_fixed_knots();
    at_start_ = tangent_at(start_.vertices, true);
}

void KeptSections::add_side(const std::shared_ptr<const Wing>& wing, int number, double knot_gap) {
    Side side;
    side.wing = wing;
    side.side = number;
    side.reach = wing->reach(start_, number);
    const double last = wing->place(number, 1);
    std::optional<Vector3d> before;
    for (int i = 0; i <= table_rows; ++i) {
        const double place = last * i / table_rows;
        const auto at = wing->edges(start_, start_, number, place, false);
        if (!at) continue;
        if (before && at->normal.dot(*before) < sharp_turn) break;  // around a sharp corner nothing is a section
        before = at->normal;
        side.places.push_back(place);
        side.leading.push_back(at->leading_point);
        side.trailing.push_back(at->trailing_point);
    }
    if (side.places.size() < 2)
        throw InvalidInput(text("wing '", wing->declaration().name, "' has no sections whose edges could be kept"));
    for (const int edge : {0, 1}) add_knots(side, edge, knot_gap);
    side.has_coarse_nose = rules_ == KeptRules::latest && has_coarse_nose(side);
    sides_.push_back(std::move(side));
}

/// At rows of vertices near the edge: between two of them nothing could bring it back.
void KeptSections::add_knots(Side& of, int edge, double gap) {
    std::vector<double> rows;
    Complex chord;
    for (const int v : of.wing->vertices(of.side)) {
        const Vector3d x = start_.vertices.row(v);
        const double place = of.wing->fraction_at(of.side, of.reach, x);
        if (std::abs(fraction(of, place, x, chord) - Complex(edge, 0)) < edge_share) rows.push_back(place);
    }
    std::sort(rows.begin(), rows.end());
    const double last = of.places.back();
    std::vector<double>& knots = of.knots[edge];
    knots = {of.places.front()};
    for (const double row : rows)
        if (row >= knots.back() + gap - same_place && row < last) knots.push_back(row);
    if (last > knots.back() + 0.5 * gap)
        knots.push_back(last);
    else if (knots.size() > 1)
        knots.back() = last;
    for (std::size_t k = 0; k < knots.size(); ++k) of.number[edge].push_back(num_knots_++);
}

/// At rows of vertices there are fewer than between them: where most of all places have few.
bool KeptSections::has_coarse_nose(const Side& of) const {
    int few = 0, seen = 0;
    for (int i = 0; i < nose_samples; ++i) {
        const auto at = of.wing->edges(start_, start_, of.side, of.places.back() * (i + 0.5) / nose_samples, false);
        if (!at) continue;
        ++seen;
        few += at->num_nose_points < many_points && at->nose_turning < nose_corner;
    }
    return 2 * few > seen;
}

/// Both sides of a wing without a body have their first knots in common. Numbers stay as they are: that of the second
/// side moves nothing, and is left out later.
void KeptSections::share_centre() {
    for (std::size_t s = 1; s < sides_.size(); ++s) {
        Side &a = sides_[s - 1], &b = sides_[s];
        if (a.wing != b.wing || a.wing->is_joined(a.side) || a.wing->is_joined(b.side)) continue;
        const double apart = a.wing->root(a.side) + b.wing->root(b.side);
        if (std::abs(apart) > 1e-6 * a.reach) continue;
        for (const int edge : {0, 1}) b.number[edge].front() = a.number[edge].front();
    }
}

void KeptSections::add_sections(const Side& of) {
    const double last = of.places.back(), reach = (of.wing->has_winglet() ? steep_margin : plane_margin) * last;
    const std::vector<int>& triangles = of.wing->triangles(of.side);
    const auto range = reaches(start_, *of.wing, of.side, of.reach, reach);
    const auto section_at = [&](double place) {
        Section section;
        section.wing = of.wing;
        section.side = of.side;
        section.place = place;
        for (std::size_t i = 0; i < triangles.size(); ++i)
            if (range[i][0] <= place && place <= range[i][1]) section.triangles.push_back(triangles[i]);
        return section;
    };
    const bool is_shared = of.side > 0 && of.number[0].front() != of.number[1].front() &&
                           std::any_of(sections_.begin(), sections_.end(),
                                       [&](const Section& other) { return other.leading == of.number[0].front(); });
    std::vector<std::pair<double, Section>> found;
    for (const int edge : {0, 1})
        for (std::size_t k = is_shared ? 1 : 0; k < of.knots[edge].size(); ++k) {
            const double place = of.knots[edge][k];
            auto same = std::find_if(found.begin(), found.end(),
                                     [&](const auto& one) { return std::abs(one.first - place) < same_place; });
            if (same == found.end()) {
                found.emplace_back(place, section_at(place));
                same = found.end() - 1;
            }
            (edge == 0 ? same->second.leading : same->second.trailing) = of.number[edge][k];
        }
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [place, section] : found) {
        const auto at = of.wing->edges(start_, start_, of.side, place, false, &section.triangles);
        if (!at)
            throw InvalidInput(text("wing '", of.wing->declaration().name, "' has no section at ", 100 * place,
                                    " % of its semispan, where its edges have to be kept"));
        section.chord = (at->trailing_point - at->leading_point).norm();
        section.leading_at = {at->leading.x.value, at->leading.z.value};
        section.is_round = !of.has_coarse_nose && at->num_nose_points >= min_points(rules_);
        sections_.push_back(std::move(section));
    }
}

/// Of a point: complex place over the chord, 0 at the leading and 1 at the trailing edge.
std::complex<double> KeptSections::fraction(const Side& of, double place, const Vector3d& x, Complex& chord) const {
    std::size_t k = 1;
    while (k + 1 < of.places.size() && of.places[k] < place) ++k;
    const double t = std::clamp((place - of.places[k - 1]) / (of.places[k] - of.places[k - 1]), 0.0, 1.0);
    const Vector3d lead = of.leading[k - 1] + t * (of.leading[k] - of.leading[k - 1]),
                   trail = of.trailing[k - 1] + t * (of.trailing[k] - of.trailing[k - 1]);
    const Vector3d downstream = of.wing->declaration().downstream, up = of.wing->up_at(of.side, place);
    chord = Complex(downstream.dot(trail - lead), up.dot(trail - lead));
    return Complex(downstream.dot(x - lead), up.dot(x - lead)) / chord;
}

/// @param along, across factors on B and on the square of what S takes out
void KeptSections::place_vertex(int v, const Side& of, double across, double along) {
    Share& share = shares_[static_cast<std::size_t>(v)];
    const Vector3d x = start_.vertices.row(v);
    const double place = of.wing->fraction_at(of.side, of.reach, x);
    share.downstream = of.wing->declaration().downstream;
    share.up = of.wing->up_at(of.side, place);
    across_.row(v) = std::sqrt(across) * share.downstream.cross(share.up);
    const Complex zeta = fraction(of, place, x, share.chord);
    for (const int edge : {0, 1}) {
        const std::vector<double>& knots = of.knots[edge];
        const Complex weight = along * (edge == 0 ? 1.0 - zeta : zeta);
        const double slope = edge == 0 ? -along : along;
        std::size_t k = 1;
        while (k + 1 < knots.size() && knots[k] < place) ++k;
        if (knots.size() == 1) {
            share.terms.push_back({of.number[edge][0], weight, slope});
            continue;
        }
        const double t = std::clamp((place - knots[k - 1]) / (knots[k] - knots[k - 1]), 0.0, 1.0);
        if (t < 1) share.terms.push_back({of.number[edge][k - 1], (1 - t) * weight, (1 - t) * slope});
        if (t > 0) share.terms.push_back({of.number[edge][k], t * weight, t * slope});
    }
}

void KeptSections::place_vertices(const std::vector<int>& fixed) {
    const Distance away(start_, fixed);
    std::vector<char> placed(shares_.size(), 0);
    const auto outboard = [&](const Side& of, int v) {
        return of.wing->span(of.side).dot(start_.vertices.row(v)) - of.wing->root(of.side);
    };
    const auto side_of = [&](const Side& side, int v) {
        const Side* of = &side;
        for (const Side& other : sides_)
            if (other.wing == side.wing && outboard(other, v) > outboard(*of, v)) of = &other;
        return of;
    };
    const auto root_chord = [](const Side& side) { return (side.trailing[0] - side.leading[0]).norm(); };
    for (const Side& side : sides_)
        for (const int v : side.wing->vertices(side.side)) {
            if (std::exchange(placed[static_cast<std::size_t>(v)], 1)) continue;
            const Side* of = side_of(side, v);
            place_vertex(v, *of, 1, away(v, root_chord(*of)));
        }
    for (const Side& side : sides_)
        if (side.wing->is_joined(side.side))
            each_near_root(start_, side.wing->triangles(side.side), body_reach * root_chord(side), placed,
                           [&](int v, double near) {
                               placed[static_cast<std::size_t>(v)] = 1;
                               place_vertex(v, side, near, near * away(v, root_chord(side)));
                           });
}

/// Of vertices with a part in a coarse nose. On a body they keep their motion as far as they do not follow the wing.
void KeptSections::hold_noses() {
    for (const Side& side : sides_) {
        if (!side.has_coarse_nose) continue;
        holds_noses_ = true;
        std::vector<double> zeta(shares_.size(), std::numeric_limits<double>::infinity());
        for (const int v : side.wing->vertices(side.side)) {
            const Vector3d x = start_.vertices.row(v);
            Complex chord;
            zeta[static_cast<std::size_t>(v)] =
                fraction(side, side.wing->fraction_at(side.side, side.reach, x), x, chord).real();
        }
        for (const int v : side.wing->vertices(side.side))
            freedom_[v] = std::min(
                freedom_[v], smooth_step((zeta[static_cast<std::size_t>(v)] - nose_reach) / (nose_fade - nose_reach)));
        for (const int t : side.wing->triangles(side.side)) {
            const auto corner = start_.triangles.row(t);
            if (std::any_of(corner.begin(), corner.end(),
                            [&](int v) { return zeta[static_cast<std::size_t>(v)] < nose_reach; }))
                for (const int v : corner) freedom_[v] = 0;
        }
    }
}

/// Knots of edges that are fixed, and those that are another's: they move nothing.
void KeptSections::drop_fixed_knots() {
    const Eigen::MatrixXd all = Eigen::MatrixXd(tangent_at(start_.vertices, true)->edges * by_knots_);
    std::vector<int> number(static_cast<std::size_t>(num_knots_), -1);
    int count = 0;
    std::vector<char> is_seen(static_cast<std::size_t>(num_knots_), 0);
    for (const Section& section : sections_)
        for (const int knot : {section.leading, section.trailing})
            if (knot >= 0) is_seen[static_cast<std::size_t>(knot)] = 1;
    for (int k = 0; k < num_knots_; ++k)
        if (is_seen[static_cast<std::size_t>(k)] && all.block<2, 2>(2 * k, 2 * k).cwiseAbs().maxCoeff() > min_share)
            number[static_cast<std::size_t>(k)] = count++;
    const auto renumbered = [&](int knot) { return knot < 0 ? -1 : number[static_cast<std::size_t>(knot)]; };
    Eigen::SparseMatrix<double> kept(3 * num_vertices(), 2 * count);
    for (int k = 0; k < num_knots_; ++k)
        for (int c = 0; number[static_cast<std::size_t>(k)] >= 0 && c < 2; ++c)
            kept.col(2 * number[static_cast<std::size_t>(k)] + c) = by_knots_.col(2 * k + c);
    by_knots_ = std::move(kept);
    for (Share& share : shares_) {
        for (Term& term : share.terms) term.knot = renumbered(term.knot);
        std::erase_if(share.terms, [](const Term& term) { return term.knot < 0; });
    }
    for (Section& section : sections_) {
        section.leading = renumbered(section.leading);
        section.trailing = renumbered(section.trailing);
    }
    std::erase_if(sections_, [](const Section& section) { return section.leading < 0 && section.trailing < 0; });
    num_knots_ = count;
    latest_.reset();
}

}  // namespace strake
