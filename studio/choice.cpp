#include "studio/choice.hpp"

#include "casefile/build/region_shapes.hpp"
#include "core/error.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

namespace strake {
namespace {

constexpr const char* here = "chosen-so-far";  ///< no name that a case could have

template <class Shape>
Region with_shape(const Shape& shape) {
    Region region;
    region.shape = shape;
    return region;
}

WingRegion wing_region_of(const WingBox& box) {
    WingRegion region;
    region.of.name = box.wing;
    region.chord = box.chord;
    region.span = box.span;
    region.side = box.side;
    return region;
}

/// As a name in a formula.
std::string in_formula(const std::string& name) {
    return name.find_first_of(" ()") == std::string::npos ? name : "\"" + name + "\"";
}

std::vector<int> numbers_of(const std::vector<char>& marks) {
    std::vector<int> numbers;
    for (std::size_t t = 0; t < marks.size(); ++t)
        if (marks[t]) numbers.push_back(static_cast<int>(t));
    return numbers;
}

std::vector<char> marks_of(const std::vector<int>& triangles, std::size_t count) {
    std::vector<char> marks(count, 0);
    for (const int t : triangles) {
        if (t < 0 || static_cast<std::size_t>(t) >= count)
            throw InvalidInput(text("triangle ", t, " must be in [0, ", count, ")"));
        marks[static_cast<std::size_t>(t)] = 1;
    }
    return marks;
}

/// Evaluates one region of the case's own kinds.
std::vector<char> region_marks(const ChoiceGround& on, Region region) {
    std::vector<Region> regions = on.declared;
    region.name = here;
    regions.push_back(std::move(region));
    const WingSetup wings{on.wings, on.axes, on.symmetry};
    RegionSets sets(regions, on.ground.start, on.ground.tree, &wings);
    return marks_of(sets.triangles(static_cast<int>(regions.size()) - 1),
                    static_cast<std::size_t>(on.ground.start.mesh.num_triangles()));
}

/// Shapes in space may hold nothing; that is no error while they are dragged.
bool may_be_empty(const Region& region) {
    return std::holds_alternative<HalfSpace>(region.shape) || std::holds_alternative<BoxShape>(region.shape);
}

struct Apply {
    const ChoiceGround& on;
    const std::vector<char>& before;
    std::size_t count = static_cast<std::size_t>(on.ground.start.mesh.num_triangles());

    std::vector<char> operator()(const PickedTriangles& picked) const { return marks_of(picked.triangles, count); }
    std::vector<char> operator()(const PickedAll&) const { return std::vector<char>(count, 1); }
    std::vector<char> operator()(const DeclaredRegion& region) const {
        return shape(with_shape(RegionFormula{in_formula(region.name)}));
    }
    std::vector<char> operator()(const GrowChoice&) const { return before; }
    std::vector<char> operator()(const InvertChoice&) const { return before; }
    std::vector<char> operator()(const MirrorChoice&) const { return before; }
    std::vector<char> operator()(const WingBox& box) const {
        if (!box.wing.empty()) return shape(with_shape(wing_region_of(box)));
        if (!on.found_wing) throw InvalidInput("no wing is found on this surface; declare one under planform");
        return on.found_wing->region(on.ground.start.mesh, {box.chord[0], box.chord[1]}, {box.span[0], box.span[1]},
                                     box.side);
    }
    template <class Shape>
    std::vector<char> operator()(const Shape& what) const {
        return shape(with_shape(what));
    }
    std::vector<char> shape(const Region& region) const {
        if (!may_be_empty(region)) return region_marks(on, region);
        const double diagonal = on.ground.start.diagonal;
        if (const auto* box = std::get_if<BoxShape>(&region.shape))
            return marks_of(triangles_in(*box, on.ground.start.mesh, diagonal, false), count);
        return marks_of(triangles_in(std::get<HalfSpace>(region.shape), on.ground.start.mesh, diagonal, false), count);
    }
};

/// By the code of `grow`, from triangles that have no name in the case.
std::vector<char> grown(const ChoiceGround& on, const std::vector<char>& marks, double by) {
    if (std::find(marks.begin(), marks.end(), 1) == marks.end()) return marks;
    return grown_marks(on.ground.start, marks, by);
}

/// @param marks of which the image comes along
std::vector<char> with_image(const TriMesh& mesh, double diagonal, std::vector<char> marks,
                             const SymmetryPlane& plane) {
    constexpr double reach = 1e-3;  ///< diagonals from an image to the surface: what `plane_of_symmetry` lets differ
    const Points centre = triangle_centroids(mesh);
    Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const int t : numbers_of(marks))
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector3d corner = mesh.vertices.row(mesh.triangles(t, k));
            low = low.cwiseMin(corner);
            high = high.cwiseMax(corner);
        }
    const ClosestPointTree tree(mesh);
    const std::vector<char> before = marks;
    for (std::size_t t = 0; t < marks.size(); ++t) {
        const Eigen::Vector3d c = centre.row(static_cast<Eigen::Index>(t));
        const Eigen::Vector3d image = c - 2 * (plane.normal.dot(c) - plane.offset) * plane.normal;
        const Eigen::Array3d room = Eigen::Array3d::Constant(reach * diagonal);
        if (marks[t] || (image.array() < low.array() - room).any() || (image.array() > high.array() + room).any())
            continue;
        const ClosestPoint nearest = tree.find(image);
        if (nearest.distance <= reach * diagonal && before[static_cast<std::size_t>(nearest.triangle)]) marks[t] = 1;
    }
    return marks;
}

// -- Descriptions

RegionText formula(const std::string& name, const std::string& words) { return {name, words, true}; }

/// A formula as YAML, which must not read it as something else.
std::string as_yaml(const std::string& words) {
    const bool is_plain = std::all_of(words.begin(), words.end(), [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-' ||
               c == ' ' || c == '+' || c == '.';
    });
    if (is_plain && !words.empty() && std::isalpha(static_cast<unsigned char>(words[0]))) return words;
    std::string quoted = "'";
    for (const char c : words) quoted += c == '\'' ? "''" : std::string(1, c);
    return quoted + "'";
}

std::string vector_words(const Eigen::Vector3d& v) {
    return "[" + exact_words(v[0]) + ", " + exact_words(v[1]) + ", " + exact_words(v[2]) + "]";
}
std::string plane_words(const std::string& normal, const std::string& at, bool above) {
    return "plane: {normal: " + normal + ", at: " + at + "}, side: " + (above ? "above" : "below");
}

/// What a step is in a case; nothing: it has no words of its own.
struct StepWords {
    std::string operator()(const PatchShape& patch) const { return "patch: " + as_yaml(patch.name); }
    std::string operator()(const SolidShape& solid) const { return "solid: " + as_yaml(solid.name); }
    std::string operator()(const ComponentShape& component) const { return text("component: ", component.number); }
    std::string operator()(const FloodedRegion& flood) const {
        const std::string from = flood.triangle ? text(*flood.triangle) : vector_words(flood.point);
        return "flood: {from: " + from + ", angle: " + exact_words(flood.angle * 180 / std::numbers::pi) + "deg}";
    }
    std::string operator()(const HalfSpace& plane) const {
        return plane_words(vector_words(plane.normal), exact_words(plane.offset), plane.above);
    }
    std::string operator()(const BoxShape& box) const {
        return "box: [" + vector_words(box.min) + ", " + vector_words(box.max) + "]";
    }
    std::string operator()(const WingBox& box) const {
        return box.wing.empty() ? "" : wing_box_words(box);  // the case has no name for the one that was found
    }
    template <class Other>
    std::string operator()(const Other&) const {
        return "";
    }
};

struct Describer {
    const ChoiceGround& on;
    const std::vector<ChoiceStep>& steps;
    const std::vector<char>& marks;
    const std::string& name;
    const TriMesh& mesh = on.ground.start.mesh;
    std::vector<int> wanted = numbers_of(marks);

    bool holds(const Region& region) const {
        try {
            return region_marks(on, region) == marks;
        } catch (const InvalidInput&) {
            return false;
        }
    }
    std::optional<Description> one(const Region& region, const std::string& words, const std::string& kind) const {
        if (!holds(region)) return {};
        return Description{{{name, words, false}}, kind, {}};
    }

    std::optional<Description> whole() const {
        if (wanted.size() != marks.size()) return {};
        return Description{{formula(name, "all")}, "whole surface", {}};
    }

    /// Names whose triangles have all this mark, at most one a triangle, such that together they are all of that mark.
    std::vector<std::string> parts_of(char mark) const {
        std::vector<int> inside(mesh.group_names.size(), 0), all(mesh.group_names.size(), 0);
        for (std::size_t t = 0; t < mesh.group.size(); ++t) {
            ++all[static_cast<std::size_t>(mesh.group[t])];
            if (marks[t] == mark) ++inside[static_cast<std::size_t>(mesh.group[t])];
        }
        std::vector<std::string> names;
        for (std::size_t g = 0; g < all.size(); ++g) {
            if (inside[g] != 0 && inside[g] != all[g]) return {};
            if (inside[g] != 0 && std::find(names.begin(), names.end(), mesh.group_names[g]) == names.end())
                names.push_back(mesh.group_names[g]);
        }
        return names;
    }
    std::vector<std::string> patches_of(char mark) const {
        std::vector<std::string> names;
        const auto& levels = on.ground.tree.levels;
        const bool is_whole = levels.size() < 2 || !gather(mark, 1, -1, names);
        return is_whole ? std::vector<std::string>() : names;
    }
    bool gather(char mark, std::size_t level, int parent, std::vector<std::string>& names) const {
        for (const Patch& patch : on.ground.tree.levels[level].patches) {
            if (parent >= 0 && patch.parent != parent) continue;
            std::size_t inside = 0;
            for (const int t : patch.triangles) inside += marks[static_cast<std::size_t>(t)] == mark ? 1 : 0;
            if (inside == 0) continue;
            if (inside == patch.triangles.size()) {
                names.push_back(patch.name);
                continue;
            }
            if (level + 1 >= on.ground.tree.levels.size() || !gather(mark, level + 1, patch.id, names)) return false;
        }
        return true;
    }
    /// -1: these are not exactly the triangles of one component.
    int component_of(char mark) const {
        const std::vector<int> number = edge_components(mesh, on.ground.start.adjacent);
        int found = -1;
        for (std::size_t t = 0; t < marks.size(); ++t)
            if (marks[t] == mark && found != number[t]) {
                if (found >= 0) return -1;
                found = number[t];
            }
        for (std::size_t t = 0; t < marks.size(); ++t)
            if (marks[t] != mark && number[t] == found) return -1;
        return found;
    }

    std::optional<Description> single() const {
        if (const auto parts = parts_of(1); parts.size() == 1)
            if (auto found = one(with_shape(SolidShape{parts[0]}), StepWords{}(SolidShape{parts[0]}), "part"))
                return found;
        if (const int k = component_of(1); k >= 0)
            if (auto found = one(with_shape(ComponentShape{k}), StepWords{}(ComponentShape{k}), "connected component"))
                return found;
        if (const auto patches = patches_of(1); patches.size() == 1)
            return one(with_shape(PatchShape{patches[0]}), StepWords{}(PatchShape{patches[0]}), "patch");
        return {};
    }

    std::optional<Description> wing_box() const {
        if (steps.size() != 1 || steps[0].combine == Combine::subtract) return {};
        const auto* box = std::get_if<WingBox>(&steps[0].what);
        if (!box || box->wing.empty()) return {};
        return one(with_shape(wing_region_of(*box)), StepWords{}(*box), "part of a wing");
    }

    template <class Shape>
    std::optional<Description> stated(const std::string& kind) const {
        if (steps.size() != 1 || steps[0].combine == Combine::subtract) return {};
        const auto* shape = std::get_if<Shape>(&steps[0].what);
        return shape ? one(with_shape(*shape), StepWords{}(*shape), kind) : std::nullopt;
    }

    /// The extent of a triangle along a coordinate.
    std::pair<double, double> extent(int t, int axis) const {
        const double a = mesh.vertices(mesh.triangles(t, 0), axis), b = mesh.vertices(mesh.triangles(t, 1), axis),
                     c = mesh.vertices(mesh.triangles(t, 2), axis);
        return {std::min({a, b, c}), std::max({a, b, c})};
    }

    /// Where a plane normal to a coordinate may lie so that exactly the marked triangles are on its side: between the
    /// chosen triangle that ends last and the first other one. Nothing: nowhere.
    std::optional<std::pair<double, double>> room_for_plane(int axis, bool above) const {
        constexpr double far = std::numeric_limits<double>::infinity();
        double inner = far, outer = -far;  // along the direction of the side
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            const auto [low, high] = extent(t, axis);
            const double end = above ? low : -high;
            if (marks[static_cast<std::size_t>(t)])
                inner = std::min(inner, end);
            else
                outer = std::max(outer, end);
        }
        if (!(outer < inner)) return {};
        return above ? std::pair{outer, inner} : std::pair{-inner, -outer};
    }
    std::optional<Description> half_space() const {
        for (int axis = 0; axis < 3; ++axis)
            for (const bool above : {true, false}) {
                const auto room = room_for_plane(axis, above);
                if (!room) continue;
                Eigen::Vector3d normal = Eigen::Vector3d::Zero();
                normal[axis] = 1;
                for (const std::string& at : places(room->first, room->second, above)) {
                    const HalfSpace plane{normal, std::stod(at), above};
                    if (auto found = one(with_shape(plane), plane_words(vector_words(normal), at, above), "plane"))
                        return found;
                }
            }
        return {};
    }
    /// A short number away from both ends, then the exact end.
    std::vector<std::string> places(double low, double high, bool is_inner_high) const {
        if (is_inner_high)
            low = std::max(low, high - on.ground.start.diagonal);  // no other triangle: anywhere
        else
            high = std::min(high, low + on.ground.start.diagonal);
        const double room = 0.1 * (high - low);
        return {shortest_between(low + room, high - room), exact_words(is_inner_high ? high : low)};
    }

    std::optional<Description> box() const {
        Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
        for (const int t : wanted)
            for (int axis = 0; axis < 3; ++axis) {
                const auto [from, to] = extent(t, axis);
                low[axis] = std::min(low[axis], from);
                high[axis] = std::max(high[axis], to);
            }
        if (!holds(with_shape(BoxShape{low, high}))) return {};
        // Rounded outward, more and more, as long as it holds the same triangles.
        std::string best = StepWords{}(BoxShape{low, high});
        for (const double share : {1e-6, 1e-5, 1e-4, 1e-3, 1e-2}) {
            const double room = share * on.ground.start.diagonal;
            std::array<std::string, 6> words;
            BoxShape wider{low, high};
            for (int axis = 0; axis < 3; ++axis) {
                words[static_cast<std::size_t>(axis)] = shortest_between(low[axis] - room, low[axis]);
                words[static_cast<std::size_t>(axis) + 3] = shortest_between(high[axis], high[axis] + room);
                wider.min[axis] = std::stod(words[static_cast<std::size_t>(axis)]);
                wider.max[axis] = std::stod(words[static_cast<std::size_t>(axis) + 3]);
            }
            if (!holds(with_shape(wider))) break;
            best = "box: [[" + words[0] + ", " + words[1] + ", " + words[2] + "], [" + words[3] + ", " + words[4] +
                   ", " + words[5] + "]]";
        }
        return Description{{{name, best, false}}, "box", {}};
    }

    std::optional<Description> joined_names(const std::vector<std::string>& names, const std::string& before,
                                            const char* sign, const std::string& kind) const {
        constexpr std::size_t most = 12;
        if (names.empty() || names.size() > most) return {};
        std::string words = before;
        for (const std::string& one : names) words += (words.empty() ? "" : sign) + in_formula(one);
        if (!holds(with_shape(RegionFormula{words}))) return {};
        return Description{{formula(name, as_yaml(words))}, kind, {}};
    }
    std::optional<Description> named() const {
        const auto parts = parts_of(1), patches = patches_of(1), other_parts = parts_of(0), others = patches_of(0);
        std::optional<Description> best;
        std::size_t length = 0;
        const auto offer = [&](const std::vector<std::string>& names, const char* before, const char* sign,
                               const char* kind) {
            if (names.empty() || (best && names.size() + (*before ? 1 : 0) >= length)) return;
            if (auto found = joined_names(names, before, sign, kind)) {
                best = std::move(found);
                length = names.size() + (*before ? 1 : 0);
            }
        };
        offer(parts, "", " + ", "parts");
        offer(patches, "", " + ", "patches");
        offer(other_parts, "all", " - ", "all but parts");
        offer(others, "all", " - ", "all but patches");
        return best;
    }

    /// The steps as regions that are made of each other, as long as each has words of its own.
    struct StepByStep {
        const std::string& name;
        std::vector<RegionText> regions = {};
        std::string region_formula = {};  ///< a formula; empty: nothing yet

        /// What a step is called in a formula; empty: it has no words.
        std::string operand(const ChoiceStep& step, const std::string& helper) {
            if (const auto* region = std::get_if<DeclaredRegion>(&step.what)) return in_formula(region->name);
            if (const auto* patch = std::get_if<PatchShape>(&step.what)) return in_formula(patch->name);
            if (std::holds_alternative<PickedAll>(step.what)) return "all";
            const std::string words = std::visit(StepWords{}, step.what);
            if (words.empty()) return "";
            regions.push_back({helper, words, false});
            return helper;
        }
        bool add(const ChoiceStep& step, const std::string& helper) {
            if (const auto* grow = std::get_if<GrowChoice>(&step.what)) {
                if (region_formula.empty()) return false;
                regions.push_back(
                    {helper, "grow: {of: " + as_yaml(region_formula) + ", by: " + exact_words(grow->by) + "}", false});
                region_formula = helper;
                return true;
            }
            if (std::holds_alternative<MirrorChoice>(step.what)) return false;  // a case has no words for it
            if (std::holds_alternative<InvertChoice>(step.what)) {
                region_formula = region_formula.empty() ? "all" : "all - (" + region_formula + ")";
                return true;
            }
            if (region_formula.empty() && step.combine != Combine::add) return true;  // of nothing nothing is left
            const std::string other = operand(step, helper);
            if (region_formula.empty())
                region_formula = other;
            else if (step.combine == Combine::intersect)
                region_formula = "(" + region_formula + ") & " + other;
            else
                region_formula += (step.combine == Combine::add ? " + " : " - ") + other;
            return !other.empty();
        }
    };
    std::optional<Description> by_steps() const {
        constexpr std::size_t max_steps = 6;
        if (steps.size() > max_steps) return {};
        StepByStep made{name};
        for (std::size_t k = 0; k < steps.size(); ++k)
            if (!made.add(steps[k], name + "_" + std::to_string(k + 1))) return {};
        if (made.region_formula.empty()) return {};
        made.regions.push_back(formula(name, as_yaml(made.region_formula)));
        return Description{std::move(made.regions), "steps", {}};
    }

    Description list(const std::string& file) const {
        const StartSurface& start = on.ground.start;
        if (start.is_remeshed)
            throw InvalidInput(
                "only a list of triangles means exactly these, and after remesh their numbers mean nothing: choose by "
                "patches, planes, boxes or floods");
        Description made{{{name, "triangles: " + as_yaml(file), false}}, "list of triangles", {}};
        for (const int t : wanted) {
            const int number = start.source_triangle.empty() ? t : start.source_triangle[static_cast<std::size_t>(t)];
            if (number < 0)
                throw InvalidInput(
                    text("only a list of triangles means exactly these, and repair made triangle ", t,
                         ", which has no number in the file: choose by patches, planes, boxes or floods"));
            made.numbers.push_back(number);
        }
        std::sort(made.numbers.begin(), made.numbers.end());
        return made;
    }
};

}  // namespace

std::string wing_box_words(const WingBox& box) {
    const auto range = [](const std::array<double, 2>& ends) {
        return "[" + exact_words(ends[0]) + ", " + exact_words(ends[1]) + "]";
    };
    return "of: " + as_yaml(box.wing) + ", chord: " + range(box.chord) + ", span: " + range(box.span) +
           (box.side == 0  ? ""
            : box.side > 0 ? ", side: upper"
                           : ", side: lower");
}

std::string exact_words(double value) {
    std::array<char, 40> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value == 0 ? 0.0 : value).ptr;
    return {digits.data(), end};
}

std::string shortest_between(double low, double high) {
    if (low > high) std::swap(low, high);
    if (low <= 0 && high >= 0) return "0";
    const double size = std::max(std::abs(low), std::abs(high));
    for (int digits = -static_cast<int>(std::floor(std::log10(size))); digits < 320; ++digits) {
        const double unit = std::pow(10.0, -digits);
        if (unit == 0) break;
        double value = low > 0 ? std::ceil(low / unit) * unit : std::floor(high / unit) * unit;
        std::array<char, 40> written{};
        std::snprintf(written.data(), written.size(), "%.*f", std::clamp(digits, 0, 17), value);
        value = std::stod(written.data());
        if (value >= low && value <= high) return exact_words(value);
        if (digits > 17) break;
    }
    return exact_words(low > 0 ? low : high);
}

std::vector<char> chosen(const ChoiceGround& ground, const std::vector<ChoiceStep>& steps) {
    std::vector<char> marks(static_cast<std::size_t>(ground.ground.start.mesh.num_triangles()), 0);
    for (const ChoiceStep& step : steps) {
        if (const auto* grow = std::get_if<GrowChoice>(&step.what)) {
            marks = grown(ground, marks, grow->by);
            continue;
        }
        if (const auto* mirror = std::get_if<MirrorChoice>(&step.what)) {
            marks = with_image(ground.ground.start.mesh, ground.ground.start.diagonal, std::move(marks), mirror->plane);
            continue;
        }
        if (std::holds_alternative<InvertChoice>(step.what)) {
            for (char& mark : marks) mark = mark ? 0 : 1;
            continue;
        }
        const std::vector<char> more = std::visit(Apply{ground, marks}, step.what);
        for (std::size_t t = 0; t < marks.size(); ++t) switch (step.combine) {
                case Combine::add:
                    marks[t] = marks[t] | more[t];
                    break;
                case Combine::subtract:
                    marks[t] = marks[t] & !more[t];
                    break;
                case Combine::intersect:
                    marks[t] = marks[t] & more[t];
                    break;
            }
    }
    return marks;
}

Description described(const ChoiceGround& ground, const std::vector<ChoiceStep>& steps, const std::vector<char>& marks,
                      const std::string& name, const std::string& list_file) {
    const Describer words{ground, steps, marks, name};
    if (words.wanted.empty()) throw InvalidInput("nothing is chosen");
    if (auto found = words.whole()) return *found;
    if (auto found = words.single()) return *found;
    if (auto found = words.stated<HalfSpace>("plane")) return *found;
    if (auto found = words.stated<BoxShape>("box")) return *found;
    if (auto found = words.wing_box()) return *found;
    if (auto found = words.half_space()) return *found;
    if (auto found = words.box()) return *found;
    if (auto found = words.stated<FloodedRegion>("flood")) return *found;
    if (auto found = words.named()) return *found;
    if (auto found = words.by_steps()) return *found;
    return words.list(list_file);
}

}  // namespace strake
