#include "casefile/propose/propose_parts.hpp"
#include "core/error.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace strake::proposing {
namespace {

/// Rounded to five digits of `scale`.
double short_number(double value, double scale) {
    const double unit = std::pow(10.0, std::floor(std::log10(std::max(scale, 1e-300))) - 4);
    return std::round(value / unit) * unit;
}

std::string number(double value) {
    std::ostringstream s;
    s.imbue(std::locale::classic());
    s.precision(8);
    s << (value == 0 ? 0.0 : value);
    return s.str();
}

struct Band {
    Eigen::Vector3d normal;  ///< the band is where normal . x >= at
    double at = 0;
};

std::vector<char> inside(const TriMesh& mesh, const Band& band) {
    std::vector<char> held(mesh.num_triangles());
    const Eigen::VectorXd height = mesh.vertices * band.normal;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        held[t] = height[mesh.triangles(t, 0)] >= band.at && height[mesh.triangles(t, 1)] >= band.at &&
                  height[mesh.triangles(t, 2)] >= band.at;
    return held;
}

class Holder {
public:
    explicit Holder(const RepairedSurface& surface)
        : mesh_(surface.mesh),
          checkup_(surface.checkup),
          area_(triangle_areas(surface.mesh)),
          part_(edge_components(surface.mesh, surface.checkup.adjacent)),
          held_(surface.mesh.num_triangles(), 0) {
        constexpr double small = 0.05;  // of the largest part's area: a wheel below a floor, debris
        std::map<int, double> area;
        for (int t = 0; t < mesh_.num_triangles(); ++t) area[part_[t]] += area_[t];
        double largest = 0;
        for (const auto& [part, sum] : area) largest = std::max(largest, sum);
        for (int t = 0; t < mesh_.num_triangles(); ++t)
            if (area[part_[t]] >= small * largest) of_large_parts_.push_back(t);
    }

    /// The thinnest band at the far end of `normal` that holds a hundredth of the area, at least two percent and at
    /// most a third of the extent deep.
    Band band(const Eigen::Vector3d& normal) const {
        const auto [low, high] = reach(normal);
        Band found{normal, 0};
        for (double share = 0.02; share < 0.34; share *= 1.25) {
            found.at = short_number(high - share * (high - low), high - low);
            if (area_in(inside(mesh_, found)) >= 0.01 * area_.sum()) break;
        }
        return found;
    }

    double area_in(const std::vector<char>& held) const {
        double sum = 0;
        for (int t = 0; t < mesh_.num_triangles(); ++t) sum += held[t] ? area_[t] : 0;
        return sum;
    }

    /// Share of the area that is square to `normal` (to `cosine`) at its far end (to `depth` of the extent).
    double flat_share(const Eigen::Vector3d& normal, double cosine, double depth) const {
        const Eigen::VectorXd height = mesh_.vertices * normal;
        const auto [low, high] = reach(normal);
        const double near = high - depth * (high - low);
        double sum = 0;
        for (const int t : of_large_parts_) {
            const Eigen::Vector3d n = area_vector(mesh_, t);
            bool is_end = n.dot(normal) >= cosine * n.norm();
            for (int k = 0; k < 3; ++k) is_end &= height[mesh_.triangles(t, k)] >= near;
            sum += is_end ? area_[t] : 0;
        }
        return sum / area_.sum();
    }

    void hold(const std::string& name, const Band& band, const std::string& why) {
        const std::vector<char> more = inside(mesh_, band);
        for (std::size_t t = 0; t < held_.size(); ++t) held_[t] |= more[t];
        // Normals with one negative component read better reversed.
        const bool turned = band.normal.minCoeff() < -0.5;
        regions.push_back({name,
                           "plane: " + plane_text(turned ? -band.normal : band.normal, turned ? -band.at : band.at) +
                               ", side: " + (turned ? "below" : "above"),
                           why});
    }

    void hold_box(const std::string& name, const Box& box, const std::string& why) {
        for (int t = 0; t < mesh_.num_triangles(); ++t) {
            bool is_in = true;
            for (int k = 0; k < 3; ++k) {
                const Eigen::Vector3d p = mesh_.vertices.row(mesh_.triangles(t, k));
                is_in &= (p.array() >= box.min.array()).all() && (p.array() <= box.max.array()).all();
            }
            held_[t] |= is_in;
        }
        const auto corner = [](const Eigen::Vector3d& p) {
            return text("[", number(p.x()), ", ", number(p.y()), ", ", number(p.z()), "]");
        };
        regions.push_back({name, text("box: [", corner(box.min), ", ", corner(box.max), "]"), why});
    }

    /// Parts that nothing holds yet: what moves at its end towards its host, what does not as a whole. Attached ones
    /// need nothing, and are held where they lie within what is.
    void hold_other_parts(ProposedHolds& out, const std::optional<SymmetryPlane>& mirror) {
        const std::vector<int>& part = part_;
        out.parts = part_roles(mesh_, part, checkup_.diagonal, mirror);
        const auto is_held = [&](int p) {
            for (std::size_t t = 0; t < held_.size(); ++t)
                if (part[t] == p && held_[t]) return true;
            return false;
        };
        constexpr double beside = 0.01;  // of the diagonal
        for (const PartRole& role : out.parts) {
            if (role.role != PartRole::Kind::main && role.role != PartRole::Kind::moves) continue;
            if (!is_held(role.component))
                hold_end(role, part, out);
            else if (role.host >= 0 && role.gap < beside * checkup_.diagonal)
                out.ties_parts = true;  // a band elsewhere does not keep the joint
        }
        for (PartRole& role : out.parts) {
            const bool is_within = role.role == PartRole::Kind::attached && is_held(role.component);
            if (is_within) role.role = PartRole::Kind::held;
            if (role.role == PartRole::Kind::held)
                regions.push_back({role.name, text("component: ", role.component),
                                   is_within ? "a small part where others are held" : "a separate part"});
        }
    }

    double held_share() const { return area_in(held_) / area_.sum(); }
    void forget() {
        std::fill(held_.begin(), held_.end(), 0);
        regions.clear();
    }
    bool holds_anything() const { return std::find(held_.begin(), held_.end(), 1) != held_.end(); }

    std::vector<ProposedRegion> regions;

private:
    static constexpr double no_height = std::numeric_limits<double>::infinity();

    /// Lowest and highest place of the large parts along `normal`.
    std::pair<double, double> reach(const Eigen::Vector3d& normal) const {
        double low = no_height, high = -no_height;
        for (const int t : of_large_parts_)
            for (int k = 0; k < 3; ++k) {
                const double h = normal.dot(mesh_.vertices.row(mesh_.triangles(t, k)));
                low = std::min(low, h), high = std::max(high, h);
            }
        return {low, high};
    }

    /// Distance of the vertices of a part from its host; of the main part from the low end of its longest axis.
    Eigen::VectorXd from_host(const PartRole& role, const std::vector<int>& own, const std::vector<int>& part) const {
        Eigen::VectorXd away = Eigen::VectorXd::Constant(mesh_.num_vertices(), no_height);
        TriMesh host;
        std::vector<int> of_host;
        for (std::size_t t = 0; t < part.size(); ++t)
            if (part[t] == role.host) of_host.push_back(static_cast<int>(t));
        std::optional<ClosestPointTree> tree;
        if (role.host >= 0) {
            host.vertices = mesh_.vertices;
            host.triangles = mesh_.triangles(of_host, Eigen::all);
            tree.emplace(host);
        }
        int axis = 0;
        (checkup_.box.max - checkup_.box.min).maxCoeff(&axis);
        for (const int t : own)
            for (int k = 0; k < 3; ++k) {
                const int v = mesh_.triangles(t, k);
                if (away[v] < no_height) continue;
                away[v] = tree ? tree->find(mesh_.vertices.row(v)).distance
                               : mesh_.vertices(v, axis) - checkup_.box.min[axis];
            }
        return away;
    }

    /// A box around what of the part is nearest to its host, some hundredths of its area; the host is held there, too.
    void hold_end(const PartRole& role, const std::vector<int>& part, ProposedHolds& out) {
        constexpr double enough = 0.02, beside = 0.005;  // of the part's area; of the diagonal
        std::vector<int> own;
        for (std::size_t t = 0; t < part.size(); ++t)
            if (part[t] == role.component) own.push_back(static_cast<int>(t));
        const Eigen::VectorXd away = from_host(role, own, part);
        const auto farthest = [&](int t) {
            return std::max({away[mesh_.triangles(t, 0)], away[mesh_.triangles(t, 1)], away[mesh_.triangles(t, 2)]});
        };
        std::vector<std::pair<double, int>> by_distance;
        for (const int t : own) by_distance.emplace_back(farthest(t), t);
        std::sort(by_distance.begin(), by_distance.end());
        double area = 0, reach = 0;
        for (const auto& [distance, t] : by_distance) {
            if (area >= enough * role.area) break;
            area += area_[t], reach = distance + beside * checkup_.diagonal;
        }
        const auto box_until = [&](double distance) {
            Box box{Eigen::Vector3d::Constant(no_height), Eigen::Vector3d::Constant(-no_height)};
            for (const auto& [away_from_host, t] : by_distance)
                for (int k = 0; k < 3 && away_from_host <= distance; ++k) {
                    box.min = box.min.cwiseMin(mesh_.vertices.row(mesh_.triangles(t, k)).transpose());
                    box.max = box.max.cwiseMax(mesh_.vertices.row(mesh_.triangles(t, k)).transpose());
                }
            return box;
        };
        Box box = box_until(reach);
        const Box whole = box_until(no_height);
        int axis = 0;
        const Eigen::Vector3d extent = whole.max - whole.min;
        const double length = extent.maxCoeff(&axis);
        out.ties_parts |= role.host >= 0 && length > 2 * extent.minCoeff() && (box.max - box.min)[axis] > 0.5 * length;
        const Eigen::Vector3d margin = Eigen::Vector3d::Constant(1e-3 * checkup_.diagonal);
        box.min = (box.min - margin).unaryExpr([&](double x) { return short_number(x, checkup_.diagonal); });
        box.max = (box.max + margin).unaryExpr([&](double x) { return short_number(x, checkup_.diagonal); });
        const std::string host = role.host < 0 ? "" : out.parts[static_cast<std::size_t>(role.host)].name;
        hold_box(role.name + "_root", box,
                 host.empty() ? "its low end on the longest axis" : text("where ", role.name, " is nearest to ", host));
    }

    const TriMesh& mesh_;
    const Checkup& checkup_;
    Eigen::VectorXd area_;
    std::vector<int> part_;  ///< of each triangle
    std::vector<int> of_large_parts_;
    std::vector<char> held_;
};

/// The coordinate direction at whose end most of the area is flat; zero where there is none. A plane counts from a
/// hundredth of the area on; what is only nearly flat, as a belly, has to be more where there is something better.
/// The held part of a symmetric body is symmetric, too.
Eigen::Vector3d flat_end(const Holder& holder, const std::optional<SymmetryPlane>& mirror) {
    const bool has_middle = mirror && axis_letter(mirror->normal);
    Eigen::Vector3d best = Eigen::Vector3d::Zero();
    double best_score = 1;
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0}) {
            const Eigen::Vector3d normal = sign * Eigen::Vector3d::Unit(axis);
            if (mirror && std::abs(normal.dot(mirror->normal)) > 1e-6) continue;
            const double plane = holder.flat_share(normal, 0.9995, 1e-3), near = holder.flat_share(normal, 0.9, 0.02);
            const double score = std::max(plane / 0.01, near / (has_middle ? 0.04 : 0.01));
            if (score > best_score && near < 0.3) best_score = score, best = normal;
        }
    return best;
}

constexpr double max_held = 0.4;  ///< of the area

void hold_middle(Holder& holder, const Checkup& c, const SymmetryPlane& plane) {
    int axis = 0;
    plane.normal.cwiseAbs().maxCoeff(&axis);
    const double margin = 0.05 * c.diagonal, at = plane.offset * (plane.normal[axis] < 0 ? -1 : 1);
    const double extent = c.box.max[axis] - c.box.min[axis];
    Box box{c.box.min - Eigen::Vector3d::Constant(margin), c.box.max + Eigen::Vector3d::Constant(margin)};
    for (int k = 0; k < 3; ++k) {
        box.min[k] = short_number(box.min[k], c.diagonal);
        box.max[k] = short_number(box.max[k], c.diagonal);
    }
    double half = std::max(0.02 * extent, 1.5 * c.quality.edge_mean);
    // Triangles may be longer there than elsewhere: the band has to hold some.
    for (int attempt = 0; attempt < 10 && !holder.holds_anything(); ++attempt, half *= 1.25) {
        box.min[axis] = short_number(at - half, c.diagonal);
        box.max[axis] = short_number(at + half, c.diagonal);
        holder.forget();
        holder.hold_box("middle", box, "the band along the plane of symmetry");
    }
    if (!holder.holds_anything()) holder.forget();
}

}  // namespace

std::string plane_text(const Eigen::Vector3d& normal, double at) {
    return "{normal: [" + number(normal.x()) + ", " + number(normal.y()) + ", " + number(normal.z()) +
           "], at: " + number(at) + "}";
}

char axis_letter(const Eigen::Vector3d& normal) {
    for (int k = 0; k < 3; ++k)
        if (std::abs(std::abs(normal[k]) - 1) < 1e-9) return "xyz"[k];
    return 0;
}

ProposedHolds held_regions(const RepairedSurface& surface, const std::optional<SymmetryPlane>& half,
                           const std::optional<SymmetryPlane>& mirror) {
    ProposedHolds out;
    Eigen::Vector3d& down = out.down;
    Holder holder(surface);
    const Checkup& c = surface.checkup;
    if (half) {
        const double below = (surface.mesh.vertices * half->normal).minCoeff();
        const bool is_above = half->offset - below < 1e-4 * c.diagonal;  // the body is where the normal points
        holder.hold("root", holder.band(is_above ? Eigen::Vector3d(-half->normal) : half->normal),
                    "the band beside the symmetry plane");
    }
    if (!holder.holds_anything()) {
        const Eigen::Vector3d end = flat_end(holder, mirror);
        down = end;
        if (!end.isZero())
            holder.hold("base", holder.band(end), "the flattest end of the body");
        else if (mirror && axis_letter(mirror->normal))
            hold_middle(holder, c, *mirror);
        // The band holds nearly all of a thin body that is symmetric across its thickness.
        if (holder.held_share() > max_held) holder.forget(), down.setZero();
    }
    if (!holder.holds_anything() && !c.loops.empty()) {
        const auto loop = std::max_element(c.loops.begin(), c.loops.end(),
                                           [](const auto& a, const auto& b) { return a.size < b.size; });
        Box box{Eigen::Vector3d::Constant(1e300), Eigen::Vector3d::Constant(-1e300)};
        for (const int v : loop->vertices) {
            box.min = box.min.cwiseMin(surface.mesh.vertices.row(v).transpose());
            box.max = box.max.cwiseMax(surface.mesh.vertices.row(v).transpose());
        }
        const Eigen::Vector3d margin = Eigen::Vector3d::Constant(0.02 * c.diagonal);
        if (loop->size < 0.6 * c.diagonal)
            holder.hold_box("rim", {box.min - margin, box.max + margin}, "around the largest opening");
    }
    if (!holder.holds_anything()) {
        int axis = 0;
        (c.box.max - c.box.min).maxCoeff(&axis);
        const Eigen::Vector3d end = -Eigen::Vector3d::Unit(axis);
        holder.regions.clear();
        holder.hold("end", holder.band(end), text("the end of the longest axis, ", "xyz"[axis]));
    }
    holder.hold_other_parts(out, mirror);
    out.regions = std::move(holder.regions);
    return out;
}

}  // namespace strake::proposing
