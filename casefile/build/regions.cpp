#include "casefile/build/regions.hpp"

#include "casefile/build/make_wing.hpp"
#include "casefile/build/region_formula.hpp"
#include "casefile/build/region_shapes.hpp"
#include "casefile/schema/scalars.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"

#include <algorithm>
#include <fstream>
#include <numeric>
#include <queue>
#include <set>

namespace strake {
namespace {

constexpr double border_rel = 1e-9;       ///< of the diagonal: points on the border are inside
constexpr std::size_t max_made_of = 500;  ///< regions one from another: far below what the stack bears

template <class Inside>
std::vector<int> triangles_with(const TriMesh& mesh, bool touches, const Inside& inside) {
    std::vector<char> vertex(mesh.num_vertices());
    for (int v = 0; v < mesh.num_vertices(); ++v) vertex[v] = inside(mesh.vertices.row(v).transpose());
    std::vector<int> found;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const int count = vertex[mesh.triangles(t, 0)] + vertex[mesh.triangles(t, 1)] + vertex[mesh.triangles(t, 2)];
        if (count == 3 || (touches && count > 0)) found.push_back(t);
    }
    return found;
}

std::vector<int> numbers_of(const std::vector<char>& marks) {
    std::vector<int> numbers;
    for (std::size_t t = 0; t < marks.size(); ++t)
        if (marks[t]) numbers.push_back(static_cast<int>(t));
    return numbers;
}

/// Marked triangles and those whose three vertices are no farther from them along edges than `reach`.
std::vector<char> outward(const StartSurface& start, const std::vector<char>& marks, double reach) {
    constexpr double far = std::numeric_limits<double>::infinity();
    const TriMesh& mesh = start.mesh;
    std::vector<std::vector<std::pair<int, double>>> next(mesh.num_vertices());
    for (const auto& [a, b] : start.adjacent.edges) {
        const double length = (mesh.vertices.row(a) - mesh.vertices.row(b)).norm();
        next[a].emplace_back(b, length);
        next[b].emplace_back(a, length);
    }
    std::vector<double> distance(mesh.num_vertices(), far);
    using Visit = std::pair<double, int>;
    std::priority_queue<Visit, std::vector<Visit>, std::greater<>> queue;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; marks[t] && k < 3; ++k)
            if (distance[mesh.triangles(t, k)] > 0)
                queue.emplace(distance[mesh.triangles(t, k)] = 0, mesh.triangles(t, k));
    while (!queue.empty()) {
        const auto [length_to, v] = queue.top();
        queue.pop();
        if (length_to > distance[v]) continue;
        for (const auto& [other, length] : next[v])
            if (length_to + length < distance[other]) queue.emplace(distance[other] = length_to + length, other);
    }
    const double limit = reach + border_rel * start.diagonal;
    std::vector<char> all = marks;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        all[t] |= distance[mesh.triangles(t, 0)] <= limit && distance[mesh.triangles(t, 1)] <= limit &&
                  distance[mesh.triangles(t, 2)] <= limit;
    return all;
}

std::vector<char> inverted(std::vector<char> marks) {
    for (char& mark : marks) mark = !mark;
    return marks;
}

/// Number in the surface in memory of a triangle of the file.
int triangle_of_file(const StartSurface& start, int number) {
    if (start.is_remeshed)
        throw InvalidInput(
            "triangle numbers of the surface file are not valid after remesh; give a point in place of the number");
    const int count = start.source_triangle.empty() ? start.mesh.num_triangles() : start.file_triangles;
    if (number >= count) throw InvalidInput(text("triangle ", number, " must be in [0, ", count, ")"));
    if (start.source_triangle.empty()) return number;
    const auto found = std::find(start.source_triangle.begin(), start.source_triangle.end(), number);
    if (found == start.source_triangle.end())
        throw InvalidInput(text("repair removed triangle ", number, "; give a point in place of the number"));
    return static_cast<int>(found - start.source_triangle.begin());
}

std::string box_text(const TriMesh& mesh) {
    const Box box = bounding_box(mesh);
    return text("[[", box.min[0], ", ", box.min[1], ", ", box.min[2], "], [", box.max[0], ", ", box.max[1], ", ",
                box.max[2], "]]");
}

/// Numbers, one a line; blank lines are passed over.
std::vector<int> read_triangle_numbers(const std::filesystem::path& file, int num_triangles) {
    std::ifstream in(file);
    if (!in) throw InvalidInput(text(printable(file.string(), 300), ": cannot be read"));
    std::set<int> numbers;
    std::string line;
    for (int k = 1; std::getline(in, line); ++k) {
        const std::size_t first = line.find_first_not_of(" \t\r"), last = line.find_last_not_of(" \t\r");
        if (first == std::string::npos) continue;
        Value value;
        value.text = line.substr(first, last - first + 1);
        const std::string where = text(printable(file.string(), 300), ":", k, ": ");
        const std::string error = convert_scalar(value, Type::integer, Key{}, {});
        if (!error.empty()) throw InvalidInput(text(where, "'", printable(value.text, 40), "' ", error));
        if (value.number < 0 || value.number >= num_triangles)
            throw InvalidInput(text(where, "triangle ", value.text, " must be in [0, ", num_triangles, ")"));
        if (!numbers.insert(static_cast<int>(value.number)).second)
            throw InvalidInput(text(where, "triangle ", value.text, " is listed twice"));
    }
    return {numbers.begin(), numbers.end()};
}

}  // namespace

std::vector<char> grown_marks(const StartSurface& start, const std::vector<char>& marks, double by) {
    return by >= 0 ? outward(start, marks, by) : inverted(outward(start, inverted(marks), -by));
}

struct RegionSets::Evaluate {
    RegionSets& sets;
    bool touches;
    const StartSurface& start = sets.start_;
    const PatchHierarchy& tree = sets.tree_;

    std::vector<int> operator()(const RegionFormula& made) const { return numbers_of(sets.marks_of(made.formula)); }
    std::vector<int> operator()(const GrownRegion& made) const {
        const double by = made.by.in(start.diagonal);
        const std::vector<char> of = sets.marks_of(made.of.name);
        return numbers_of(grown_marks(start, of, by));
    }
    std::vector<int> operator()(const FloodedRegion& made) const {
        const int first = made.triangle ? triangle_of_file(start, *made.triangle)
                                        : ClosestPointTree(start.mesh).find(made.point).triangle;
        const Points normal = triangle_normals(start.mesh);
        std::vector<char> reached(start.mesh.num_triangles(), 0);
        std::vector<int> open{first};
        reached[first] = 1;
        while (!open.empty()) {
            const int t = open.back();
            open.pop_back();
            for (int k = 0; k < 3; ++k) {
                const int e = start.adjacent.triangle_edges(t, k);
                if (!start.adjacent.is_regular(e)) continue;
                for (const int other : start.adjacent.edge_triangles[e])
                    if (!reached[other] && dihedral(normal.row(t), normal.row(other)) <= made.angle + 1e-9) {
                        reached[other] = 1;
                        open.push_back(other);
                    }
            }
        }
        return numbers_of(reached);
    }
    std::vector<int> operator()(const NearRegion& made) const {
        const std::vector<int> of = numbers_of(sets.marks_of(made.of.name));
        if (of.empty()) return {};
        TriMesh part = start.mesh;
        part.triangles.resize(static_cast<Eigen::Index>(of.size()), 3);
        for (std::size_t i = 0; i < of.size(); ++i)
            part.triangles.row(static_cast<Eigen::Index>(i)) = start.mesh.triangles.row(of[i]);
        part.group.clear();
        const ClosestPointTree closest(part);
        const double reach = made.within.in(start.diagonal) + border_rel * start.diagonal;
        return triangles_with(start.mesh, touches,
                              [&](const Eigen::Vector3d& x) { return closest.find(x).distance <= reach; });
    }
    std::vector<int> operator()(const FacingDirection& facing) const {
        const Points normal = triangle_normals(start.mesh);
        std::vector<int> triangles;
        for (int t = 0; t < start.mesh.num_triangles(); ++t)
            if (!normal.row(t).isZero(0) && dihedral(normal.row(t), facing.direction) < facing.within - 1e-9)
                triangles.push_back(t);
        return triangles;
    }
    std::vector<int> operator()(const WingRegion& part) const {
        return wing_region(*sets.wing(part.of.name), part, start.mesh);
    }
    std::vector<int> operator()(const BoxShape& box) const {
        return triangles_in(box, start.mesh, start.diagonal, touches);
    }
    std::vector<int> operator()(const SphereShape& sphere) const {
        return triangles_in(sphere, start.mesh, start.diagonal, touches);
    }
    std::vector<int> operator()(const HalfSpace& plane) const {
        return triangles_in(plane, start.mesh, start.diagonal, touches);
    }
    std::vector<int> operator()(const SolidShape& solid) const {
        const auto& names = start.mesh.group_names;
        const auto found = std::find(names.begin(), names.end(), solid.name);
        if (start.mesh.group.empty()) throw InvalidInput("the surface file names no parts");
        if (found == names.end()) {
            const std::string near = nearest(solid.name, names);
            std::vector<std::string> shown;
            for (std::size_t k = 0; k < names.size() && k < 10; ++k) shown.push_back(printable(names[k], 40));
            throw InvalidInput(text("the surface has no solid '", printable(solid.name), "'; ",
                                    near.empty() ? "" : text("did you mean '", printable(near), "'? "), "solids: ",
                                    joined(shown), names.size() > 10 ? text(", ... (", names.size(), ")") : ""));
        }
        // Parts of the same name all belong to it.
        std::vector<int> triangles;
        for (int t = 0; t < start.mesh.num_triangles(); ++t)
            if (names[start.mesh.group[t]] == solid.name) triangles.push_back(t);
        return triangles;
    }
    std::vector<int> operator()(const ComponentShape& component) const {
        const std::vector<int> number = edge_components(start.mesh, start.adjacent);
        const int count = number.empty() ? 0 : 1 + *std::max_element(number.begin(), number.end());
        if (component.number >= count)
            throw InvalidInput(text("component ", component.number, " must be below ", count,
                                    ", the number of connected pieces of the surface"));
        std::vector<int> triangles;
        for (int t = 0; t < start.mesh.num_triangles(); ++t)
            if (number[t] == component.number) triangles.push_back(t);
        return triangles;
    }
    std::vector<int> operator()(const PatchShape& patch) const {
        const PatchPlace place = find_patch(tree, patch.name);
        return tree.levels[place.level].patches[place.id].triangles;
    }
    std::vector<int> operator()(const TriangleFile& list) const {
        if (start.is_remeshed)
            throw InvalidInput(
                "triangle numbers of the surface file are not valid after remesh; remesh beforehand, or use "
                "another shape");
        if (start.source_triangle.empty()) return read_triangle_numbers(list.file, start.mesh.num_triangles());
        std::vector<char> is_listed(static_cast<std::size_t>(start.file_triangles));
        for (const int t : read_triangle_numbers(list.file, start.file_triangles)) is_listed[t] = 1;
        std::vector<int> triangles;
        for (int t = 0; t < start.mesh.num_triangles(); ++t)
            if (const int source = start.source_triangle[t]; source >= 0 && is_listed[source]) triangles.push_back(t);
        return triangles;
    }
};

void RegionSets::refuse_circle(int k) const {
    std::string words;
    for (auto at = std::find(path_.begin(), path_.end(), k); at != path_.end(); ++at)
        words += printable(regions_[*at].name) + " -> ";
    throw InvalidInput(text("region '", regions_[k].name, "' is made of itself: ", words, regions_[k].name));
}

const std::vector<int>& RegionSets::triangles(int k) {
    Known& known = known_[k];
    const Region& region = regions_[k];
    if (known.state == Known::State::known) return known.triangles;
    if (known.state == Known::State::open) refuse_circle(k);
    if (known.state == Known::State::refused)
        throw InvalidInput(text("region '", region.name, "' has an error of its own"));
    if (path_.size() >= max_made_of)
        throw InvalidInput(text("region '", regions_[path_.front()].name, "' is made of more than ", max_made_of,
                                " regions, one from another; name its parts directly"));
    known.state = Known::State::open;
    path_.push_back(k);
    try {
        known.triangles = std::visit(Evaluate{*this, region.touches}, region.shape);
    } catch (...) {
        known.state = Known::State::refused;
        path_.pop_back();
        throw;
    }
    path_.pop_back();
    known.state = Known::State::known;
    if (!known.triangles.empty()) return known.triangles;
    known.state = Known::State::refused;
    throw InvalidInput(text("region '", region.name, "' holds no triangle", emptiness_words(region)));
}

std::shared_ptr<const Wing> RegionSets::wing(const std::string& name) {
    if (const auto known = measured_.find(name); known != measured_.end()) {
        if (!known->second) throw InvalidInput(text("wing '", name, "' has an error of its own"));
        return known->second;
    }
    std::vector<std::string> names;
    for (const WingEntry& entry : wings_ ? wings_->entries : std::vector<WingEntry>()) {
        names.push_back(entry.name);
        if (entry.name != name) continue;
        try {
            std::vector<int> triangles;
            if (entry.on) {
                triangles = numbers_of(marks_of(entry.on->name));
                if (triangles.empty()) throw InvalidInput(text("'", printable(entry.on->name), "' holds no triangles"));
            }
            return measured_[name] = make_wing(entry, *wings_, start_.mesh, std::move(triangles));
        } catch (...) {
            measured_[name] = nullptr;
            throw;
        }
    }
    throw InvalidInput(text("wing '", printable(name), "' is not declared under planform",
                            names.empty() ? "" : text("; wings: ", joined(names))));
}

/// Why a region holds nothing, and what would.
std::string RegionSets::emptiness_words(const Region& region) const {
    std::optional<RegionShape> shape;
    if (const auto* box = std::get_if<BoxShape>(&region.shape)) shape = *box;
    if (const auto* sphere = std::get_if<SphereShape>(&region.shape)) shape = *sphere;
    if (const auto* plane = std::get_if<HalfSpace>(&region.shape)) shape = *plane;
    if (!shape) return "";
    return text(region.touches ? ", nor does one touch it: " : ": a triangle is inside when its three vertices are; ",
                miss_words(*shape, start_.mesh, start_.diagonal, region.touches), "; the surface's box is ",
                box_text(start_.mesh));
}

std::vector<char> RegionSets::marks_of(const std::string& formula) {
    return evaluate_formula(formula, [this](const std::string& name) { return marks_named(name); });
}

/// Regions come before `all`, parts of the file and patches.
std::vector<char> RegionSets::marks_named(const std::string& name) {
    std::vector<char> marks(start_.mesh.num_triangles(), 0);
    const auto mark = [&](const std::vector<int>& triangles) {
        for (const int t : triangles) marks[t] = 1;
        return marks;
    };
    for (std::size_t k = 0; k < regions_.size(); ++k)
        if (regions_[k].name == name) return mark(triangles(static_cast<int>(k)));
    if (name == "all") return inverted(std::move(marks));
    const auto& parts = start_.mesh.group_names;
    if (!start_.mesh.group.empty() && std::find(parts.begin(), parts.end(), name) != parts.end())
        return mark(Evaluate{*this, false}(SolidShape{name}));
    try {
        return mark(Evaluate{*this, false}(PatchShape{name}));
    } catch (const InvalidInput&) {
        std::vector<std::string> names{"all"};
        for (const Region& region : regions_) names.push_back(region.name);
        if (!start_.mesh.group.empty()) names.insert(names.end(), parts.begin(), parts.end());
        const std::string near = nearest(name, names);
        const bool lacks_blanks = name.find_first_of("+-&") != std::string::npos;
        throw InvalidInput(text("'", printable(name), "' is no region, part of the surface file or patch",
                                near.empty() ? "" : text("; did you mean '", printable(near), "'?"),
                                near.empty() && lacks_blanks ? "; put blanks around +, - and &" : ""));
    }
}

bool needs_patches(const Case& the_case, const TriMesh& mesh) {
    const std::vector<Region>& regions = the_case.regions;
    std::set<std::string> known{"all"};
    for (const Region& region : regions) known.insert(region.name);
    if (!mesh.group.empty()) known.insert(mesh.group_names.begin(), mesh.group_names.end());
    const auto names_patch = [&](const std::string& formula) {
        try {
            const std::vector<std::string> names = names_in_formula(formula);
            return std::any_of(names.begin(), names.end(), [&](const std::string& name) { return !known.count(name); });
        } catch (const InvalidInput&) {
            return false;  // reported where it is evaluated
        }
    };
    const auto is_on_patch = [&](const auto& entry) { return entry.on && names_patch(entry.on->name); };
    if (std::ranges::any_of(the_case.planform, is_on_patch) || std::ranges::any_of(the_case.bodies, is_on_patch))
        return true;
    return std::any_of(regions.begin(), regions.end(), [&](const Region& region) {
        std::string formula;
        if (const auto* made = std::get_if<RegionFormula>(&region.shape)) formula = made->formula;
        if (const auto* made = std::get_if<GrownRegion>(&region.shape)) formula = made->of.name;
        if (const auto* made = std::get_if<NearRegion>(&region.shape)) formula = made->of.name;
        return formula.empty() ? std::holds_alternative<PatchShape>(region.shape) : names_patch(formula);
    });
}

}  // namespace strake
