#include "casefile/propose/propose_parts.hpp"
#include "core/error.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/space/mirror.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

namespace strake::proposing {
namespace {

constexpr double carries_area = 0.05;   ///< of the largest part's area: smaller parts change nothing by moving
constexpr double floats_near = 0.05;    ///< of the diagonal
constexpr double is_far = 0.2;          ///< of the diagonal
constexpr double same_place = 0.01;     ///< of the diagonal, between a part and a mirror image
constexpr std::size_t max_parts = 200;  ///< more are debris, whose roles nobody looks at
constexpr int max_looked_at = 20000;    ///< triangles whose distance is measured, spread over the numbering

/// Letters, digits and underscores in lower case; empty where it does not begin with a letter, or where regions of this
/// name are proposed for other things.
std::string plain_name(const std::string& name) {
    std::string out;
    for (const char c : name.substr(0, 40))
        out += std::isalnum(static_cast<unsigned char>(c)) != 0
                   ? static_cast<char>(std::tolower(static_cast<unsigned char>(c)))
                   : '_';
    for (const char* other : {"all", "end", "base", "root", "middle", "rim"})
        if (out == other) return "";
    return !out.empty() && std::isalpha(static_cast<unsigned char>(out[0])) != 0 ? out : std::string();
}

bool has_word(const std::string& name, std::initializer_list<const char*> words) {
    return std::any_of(words.begin(), words.end(),
                       [&](const char* word) { return name.find(word) != std::string::npos; });
}
/// What holds a model, or stands beside it.
bool is_support(const std::string& name) {
    return has_word(name, {"sting", "support", "strut_", "ground", "floor", "tunnel", "fixed", "mount"});
}
/// What hangs on another part and keeps its shape.
bool is_hung(const std::string& name) {
    return has_word(name, {"nacelle", "engine", "pylon", "store", "tank", "missile", "wheel", "gear", "propeller",
                           "spinner", "antenna", "pitot"});
}

class Roles {
public:
    Roles(const TriMesh& mesh, const std::vector<int>& component) : mesh_(mesh), component_(component) {
        const int count = component.empty() ? 0 : *std::max_element(component.begin(), component.end()) + 1;
        parts.resize(static_cast<std::size_t>(count));
        for (int p = 0; p < count; ++p) parts[static_cast<std::size_t>(p)].component = p;
        const Eigen::VectorXd area = triangle_areas(mesh);
        const Points at = triangle_centroids(mesh);
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            PartRole& part = of(t);
            part.area += area[t];
            part.centroid += area[t] * at.row(t).transpose();
        }
        for (PartRole& part : parts) part.centroid /= std::max(part.area, 1e-300);
        set_names();
    }

    /// @pre there are parts; of debris the largest is the main part.
    void set_roles(double diagonal) {
        const auto larger = [](const PartRole& a, const PartRole& b) { return a.area < b.area; };
        const auto main = std::max_element(parts.begin(), parts.end(), larger);
        main->role = PartRole::Kind::main;
        for (PartRole& part : parts) {
            if (&part == &*main || parts.size() > max_parts) continue;
            const bool has_area = part.area >= carries_area * main->area;
            part.role = is_support(part.name)             ? PartRole::Kind::held
                        : has_area && !is_hung(part.name) ? PartRole::Kind::moves
                                                          : PartRole::Kind::attached;
        }
        for (PartRole& host : parts)
            if (host.role == PartRole::Kind::main || host.role == PartRole::Kind::moves) measure_from(host);
        for (PartRole& part : parts)
            if (part.role == PartRole::Kind::attached && (part.host < 0 || part.gap > floats_near * diagonal))
                part.role = PartRole::Kind::held;
        for (PartRole& part : parts)  // cut off from what moves
            if (part.role == PartRole::Kind::moves && part.gap > is_far * diagonal && part.area < 0.5 * main->area)
                part.role = PartRole::Kind::held;
    }

    /// A part and its mirror image have one role: that of the one that moves more.
    void pair(const SymmetryPlane& plane, double diagonal) {
        const Eigen::Matrix3d turn = reflection(plane);
        for (PartRole& a : parts)
            for (PartRole& b : parts) {
                const Eigen::Vector3d image = turn * a.centroid + 2 * plane.offset * plane.normal;
                if (&a == &b || (image - b.centroid).norm() > same_place * diagonal ||
                    std::abs(a.area - b.area) > 0.02 * a.area)
                    continue;
                a.image = b.component, b.image = a.component;
                if (a.role != PartRole::Kind::main && b.role != PartRole::Kind::main)
                    a.role = b.role = std::min(a.role, b.role);
            }
    }

    std::vector<PartRole> parts;

private:
    PartRole& of(int t) { return parts[static_cast<std::size_t>(component_[static_cast<std::size_t>(t)])]; }

    /// That of the file where it names this part and no other.
    void set_names() {
        std::vector<std::set<int>> groups(parts.size());
        std::map<int, int> components_of_group;
        for (int t = 0; t < mesh_.num_triangles() && !mesh_.group.empty(); ++t)
            groups[static_cast<std::size_t>(component_[static_cast<std::size_t>(t)])].insert(
                mesh_.group[static_cast<std::size_t>(t)]);
        for (const std::set<int>& of_part : groups)
            for (const int g : of_part) ++components_of_group[g];
        std::set<std::string> taken;
        for (PartRole& part : parts) {
            const std::set<int>& own = groups[static_cast<std::size_t>(part.component)];
            if (own.size() == 1 && components_of_group[*own.begin()] == 1)
                part.name = plain_name(mesh_.group_names[static_cast<std::size_t>(*own.begin())]);
            const bool is_free = !taken.contains(part.name) && !taken.contains(part.name + "_root");
            part.is_named = !part.name.empty() && is_free;
            taken.insert({part.name, part.name + "_root"});
            if (!part.is_named) part.name = text("part_", part.component);
        }
    }

    /// Distances of the other parts from this one; the nearest is their host.
    void measure_from(const PartRole& host) {
        std::vector<int> own;
        for (int t = 0; t < mesh_.num_triangles(); ++t)
            if (component_[static_cast<std::size_t>(t)] == host.component) own.push_back(t);
        TriMesh surface;
        surface.vertices = mesh_.vertices;
        surface.triangles = mesh_.triangles(own, Eigen::all);
        const ClosestPointTree tree(surface);
        const int step = 1 + mesh_.num_triangles() / max_looked_at;
        for (int t = 0; t < mesh_.num_triangles(); t += step) {
            PartRole& part = of(t);
            if (part.component == host.component || part.role == PartRole::Kind::main) continue;
            for (int k = 0; k < 3; ++k) {
                const double away = tree.find(mesh_.vertices.row(mesh_.triangles(t, k))).distance;
                if (part.host < 0 || away < part.gap) part.gap = away, part.host = host.component;
            }
        }
    }

    const TriMesh& mesh_;
    const std::vector<int>& component_;
};

}  // namespace

std::vector<PartRole> part_roles(const TriMesh& mesh, const std::vector<int>& component, double diagonal,
                                 const std::optional<SymmetryPlane>& mirror) {
    Roles roles(mesh, component);
    if (roles.parts.empty()) return {};
    roles.set_roles(diagonal);
    if (mirror) roles.pair(*mirror, diagonal);
    return roles.parts;
}

}  // namespace strake::proposing
