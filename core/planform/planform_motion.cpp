#include "core/planform/planform_motion.hpp"

#include "core/error.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace strake {
namespace {

using Complex = std::complex<double>;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double map_step = 1e-6;  ///< of the semispan

/// Changes of a section between two nodes.
struct Between {
    Complex factor;
    double thickness, kept, camber;
};

}  // namespace

const std::vector<std::string>& planform_changes() {
    static const std::vector<std::string> words{"span", "sweep", "dihedral", "chord",  "twist", "thickness",
                                                "aft",  "up",    "camber",   "length", "width", "height"};
    return words;
}

void PlanformMotion::check_size(const VectorXd& z) const {
    if (z.size() != size() || !z.allFinite())
        throw InvalidInput(text("planform: ", z.size(), " values for ", size(), " variables, all of them finite"));
}

PlanformMotion::Changes PlanformMotion::zero(int wing) const {
    const std::size_t count = wings_[static_cast<std::size_t>(wing)].nodes.size();
    const std::vector<double> none(count);
    return {std::vector<Complex>(count), none, none, none, none, none};
}

PlanformMotion::Changes PlanformMotion::changes_of(int wing, const VectorXd& z) const {
    const MovedWing& moved = wings_[static_cast<std::size_t>(wing)];
    Changes now = zero(wing);
    const auto count = static_cast<Eigen::Index>(moved.nodes.size());
    VectorXd chord = VectorXd::Zero(count), twist = chord;
    for (int j = 0; j < size(); ++j) {
        const Variable& v = variables_[static_cast<std::size_t>(j)];
        if (v.wing != wing || z[j] == 0) continue;
        const VectorXd& shares = shares_[static_cast<std::size_t>(j)];
        const double angle = angles_[static_cast<std::size_t>(j)];
        const VectorXd change = (has_panels(v.change) ? std::tan(angle + z[j]) - std::tan(angle) : z[j]) * shares;
        const auto add_to = [&](std::vector<double>& all) { Eigen::Map<VectorXd>(all.data(), count) += change; };
        switch (v.change) {
            case PlanformChange::span:
                now.stretch = 0.5 * z[j] * moved.span / moved.reach.front();
                break;
            case PlanformChange::sweep:
                if (shares.size() > 0)
                    add_to(now.aft);
                else
                    now.sweep = std::tan(angle + z[j]) - std::tan(angle);
                break;
            case PlanformChange::dihedral:
                if (shares.size() > 0)
                    add_to(now.rise);
                else
                    now.dihedral = std::tan(angle + z[j]) - std::tan(angle);
                break;
            case PlanformChange::chord:
                chord += change;
                break;
            case PlanformChange::twist:
                twist += change;
                break;
            case PlanformChange::thickness:
                add_to(now.thickness);
                break;
            case PlanformChange::camber:
                add_to(now.camber);
                break;
            case PlanformChange::length:
            case PlanformChange::width:
            case PlanformChange::height:
                break;  // of bodies
            case PlanformChange::aft:
                now.shift_aft = z[j] * moved.mean_chord;
                break;
            case PlanformChange::up:
                now.shift_up = z[j] * moved.mean_chord;
                break;
        }
    }
    for (Eigen::Index n = 0; n < count; ++n) {
        const auto k = static_cast<std::size_t>(n);
        const double half = std::sin(0.5 * twist[n]);
        const Complex turn_less_1(-2 * half * half, -std::sin(twist[n]));  // exp(-i twist) - 1 without cancellation
        now.factor[k] = chord[n] + (1 + chord[n]) * turn_less_1;
        if (moved.keeps_thickness) now.kept[k] = -chord[n] / (1 + chord[n]);
    }
    return now;
}

std::vector<PlanformMotion::Changes> PlanformMotion::changes(const VectorXd& z) const {
    check_size(z);
    std::vector<Changes> all;
    for (int w = 0; w < static_cast<int>(wings_.size()); ++w) all.push_back(changes_of(w, z));
    return all;
}

PlanformMotion::Changes PlanformMotion::rates(const Changes& now, int j, const VectorXd& z) const {
    const Variable& v = variables_[static_cast<std::size_t>(j)];
    const MovedWing& moved = wings_[static_cast<std::size_t>(v.wing)];
    const VectorXd& shares = shares_[static_cast<std::size_t>(j)];
    Changes rate = zero(v.wing);
    const double cosine = std::cos(angles_[static_cast<std::size_t>(j)] + z[j]), slope = 1 / (cosine * cosine);
    if (v.change == PlanformChange::span) rate.stretch = 0.5 * moved.span / moved.reach.front();
    if (v.change == PlanformChange::aft) rate.shift_aft = moved.mean_chord;
    if (v.change == PlanformChange::up) rate.shift_up = moved.mean_chord;
    if (v.change == PlanformChange::sweep && shares.size() == 0) rate.sweep = slope;
    if (v.change == PlanformChange::dihedral && shares.size() == 0) rate.dihedral = slope;
    for (Eigen::Index n = 0; n < shares.size(); ++n) {
        const auto k = static_cast<std::size_t>(n);
        const Complex factor = 1.0 + now.factor[k];
        if (v.change == PlanformChange::chord) {
            rate.factor[k] = shares[n] * factor / std::abs(factor);
            if (moved.keeps_thickness) rate.kept[k] = -shares[n] / std::norm(factor);
        }
        if (v.change == PlanformChange::twist) rate.factor[k] = shares[n] * Complex(0, -1) * factor;
        if (v.change == PlanformChange::thickness) rate.thickness[k] = shares[n];
        if (v.change == PlanformChange::camber) rate.camber[k] = shares[n];
        if (v.change == PlanformChange::sweep) rate.aft[k] = slope * shares[n];
        if (v.change == PlanformChange::dihedral) rate.rise[k] = slope * shares[n];
    }
    return rate;
}

Vector3d PlanformMotion::in_space(const Place& at, const Vector3d& axis, Complex section) const {
    const Wing& wing = *wings_[static_cast<std::size_t>(at.wing)].wing;
    return axis[0] * wing.span(at.side) + (axis[1] + section.real()) * wing.declaration().downstream +
           axis[2] * wing.declaration().up + section.imag() * at.up;
}

Vector3d PlanformMotion::moved(const Place& at, const Changes& by) const { return moved_rate(at, {}, by); }

Vector3d PlanformMotion::moved_rate(const Place& at, const Changes& by, const Changes& rate) const {
    const auto& nodes = wings_[static_cast<std::size_t>(at.wing)].nodes;
    const Complex first = at.first, second = 1.0 - first;
    const auto between = [&](const Changes& of) -> Between {
        if (of.factor.empty()) return {};
        const auto linear = [&](const std::vector<double>& all) {
            return blend(all[at.node], all[at.node + 1], at.turned);
        };
        return {first * of.factor[at.node] + second * of.factor[at.node + 1], linear(of.thickness), linear(of.kept),
                linear(of.camber)};
    };
    const bool is_whole = by.factor.empty();  // the motion itself, not a rate of it
    const Between now = between(is_whole ? rate : by), change = between(rate);
    // q (1 + t (1 - b)) - 1 without the difference of nearly equal numbers
    const double thick = now.kept + (1 + now.kept) * now.thickness * at.kept;
    const double thick_rate = change.kept * (1 + now.thickness * at.kept) + (1 + now.kept) * change.thickness * at.kept;
    // The same at the nose, where b is zero.
    const double at_nose = now.kept + (1 + now.kept) * now.thickness,
                 at_nose_rate = change.kept * (1 + now.thickness) + (1 + now.kept) * change.thickness;
    const auto shape = [&](double thickness, double by_nose, double camber) {
        return Complex(0, thickness * at.height + camber * at.bump) - by_nose * at.lead_by_thickness -
               camber * at.lead_by_camber;
    };
    const Complex h = shape(thick, at_nose, now.camber), h_rate = shape(thick_rate, at_nose_rate, change.camber);
    const Complex section = is_whole ? now.factor * at.zeta + (1.0 + now.factor) * h
                                     : change.factor * (at.zeta + h) + (1.0 + now.factor) * h_rate;
    const double stretch = is_whole ? rate.stretch : by.stretch;
    Vector3d axis = rate.stretch * at.arm;
    const auto sheared = [&](const Changes& of, double slope, const std::vector<double>& panels) {
        if (of.factor.empty()) return 0.0;
        const double straight = slope * at.arm[0] + blend(panels[at.node], panels[at.node + 1], at.straight);
        if (at.off_corner == 0) return straight;
        const auto slope_from = [&](std::size_t k) {
            return (panels[k + 1] - panels[k]) / (nodes[k + 1].place - nodes[k].place);
        };
        if (at.corner > 0) return straight + at.off_corner * (slope_from(at.corner) - slope_from(at.corner - 1));
        // Inboard of the root nothing moves, and nothing does on what its plane cuts.
        const double reach = wings_[static_cast<std::size_t>(at.wing)].reach[static_cast<std::size_t>(at.side)];
        return straight + 2 * at.off_corner * (slope_from(0) + slope * reach);
    };
    axis[1] += sheared(rate, rate.sweep, rate.aft) * (1 + stretch);
    axis[2] += sheared(rate, rate.dihedral, rate.rise) * (1 + stretch);
    axis[1] += rate.shift_aft;
    axis[2] += rate.shift_up;
    if (!is_whole) {
        axis[1] += sheared(by, by.sweep, by.aft) * rate.stretch;
        axis[2] += sheared(by, by.dihedral, by.rise) * rate.stretch;
    }
    return in_space(at, axis, section * at.e);
}

Points PlanformMotion::displacement(const VectorXd& z) const {
    const std::vector<Changes> now = changes(z);
    Points result = Points::Zero(start_.rows(), 3);
    for (std::size_t i = 0; i < places_.size(); ++i)
        result.row(vertices_[i]) = moved(places_[i], now[static_cast<std::size_t>(places_[i].wing)]);
    for (int j = 0; j < size(); ++j)
        if (const Points* field = body_field(j); field && z[j] != 0) result += z[j] * *field;
    return result;
}

Points PlanformMotion::derivative(const VectorXd& z, int j) const { return rate(z, VectorXd::Unit(size(), j)); }

Points PlanformMotion::rate(const VectorXd& z, const VectorXd& dz) const {
    const std::vector<Changes> now = changes(z);
    check_size(dz);
    Points result = Points::Zero(start_.rows(), 3);
    for (int j = 0; j < size(); ++j) {
        if (dz[j] == 0) continue;
        if (const Points* field = body_field(j)) {
            result += dz[j] * *field;
            continue;
        }
        const int wing = variables_[static_cast<std::size_t>(j)].wing;
        const Changes& of = now[static_cast<std::size_t>(wing)];
        const Changes by = rates(of, j, z);
        for (std::size_t i = 0; i < places_.size(); ++i)
            if (places_[i].wing == wing) result.row(vertices_[i]) += dz[j] * moved_rate(places_[i], of, by);
    }
    return result;
}

VectorXd PlanformMotion::gradient(const VectorXd& z, const Points& dJ_dv) const {
    const std::vector<Changes> now = changes(z);
    VectorXd result = VectorXd::Zero(size());
    for (int j = 0; j < size(); ++j) {
        if (const Points* field = body_field(j)) {
            result[j] = field->cwiseProduct(dJ_dv).sum();
            continue;
        }
        const int wing = variables_[static_cast<std::size_t>(j)].wing;
        const Changes& of = now[static_cast<std::size_t>(wing)];
        const Changes by = rates(of, j, z);
        for (std::size_t i = 0; i < places_.size(); ++i)
            if (places_[i].wing == wing) result[j] += dJ_dv.row(vertices_[i]).dot(moved_rate(places_[i], of, by));
    }
    return result;
}

Eigen::Matrix3d PlanformMotion::slope_at(int wing, int side, const Vector3d& x, const Changes& now) const {
    const double h = map_step * wings_[static_cast<std::size_t>(wing)].reach.front();
    Eigen::Matrix3d slope;
    for (int c = 0; c < 3; ++c) {
        std::array<Vector3d, 2> ends{Vector3d::Zero(), Vector3d::Zero()};
        for (const int sign : {-1, 1}) {
            const Place at = place_at(wing, side, x + sign * h * Vector3d::Unit(c));
            if (at.wing >= 0) ends[sign > 0] = moved(at, now);
        }
        slope.col(c) = (ends[1] - ends[0]) / (2 * h);
    }
    return slope;
}

std::vector<Eigen::Matrix3d> PlanformMotion::local_maps(const VectorXd& z) const {
    const std::vector<Changes> now = changes(z);
    std::vector<Eigen::Matrix3d> maps(static_cast<std::size_t>(triangles_.rows()), Eigen::Matrix3d::Identity());
    for (std::size_t w = 0; w < wings_.size(); ++w) {
        const Wing& wing = *wings_[w].wing;
        for (int s = 0; s < wing.num_sides(); ++s)
            for (const int t : wing.triangles(s)) {
                Vector3d x = Vector3d::Zero();
                for (const int v : triangles_.row(t)) x += start_.row(v).transpose() / 3;
                const auto outboard = [&](int side) { return wing.span(side).dot(x) - wing.root(side); };
                if (wing.num_sides() > 1 && outboard(1 - s) > outboard(s)) continue;
                maps[static_cast<std::size_t>(t)] += slope_at(static_cast<int>(w), s, x, now[w]);
            }
    }
    add_body_maps(z, maps);
    return maps;
}

}  // namespace strake
