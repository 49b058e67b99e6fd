#include "cli/check_picture.hpp"

#include "core/mesh/geometry.hpp"
#include "core/patches/carried.hpp"
#include "core/wrap/wrap_map.hpp"

#include <fmt/core.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace strake::cli {
namespace {

using Eigen::Vector3d;

constexpr int width = 400, height = 300;
constexpr Colour free_colour{178, 206, 232}, held_colour{150, 150, 150}, attached_colour{240, 228, 66},
    region_colour{230, 159, 0};
constexpr Colour air{0, 90, 150}, up_colour{0, 120, 85}, wing_colour{190, 80, 0};

Panel::Arrow arrow(const Drawing& drawing, const Vector3d& from, const Vector3d& to, const Colour& colour,
                   const std::string& words) {
    return {drawing.pixel_of(from), drawing.pixel_of(to), colour, words};
}

/// Colour of each triangle; groups of the same colour get a dark border.
struct Paint {
    std::vector<Colour> colour;
    std::vector<int> group;
    std::vector<LegendRow> legend;

    void add(const std::vector<int>& triangles, const Colour& with, const std::string& words) {
        if (triangles.empty()) return;
        for (const int t : triangles) {
            colour[static_cast<std::size_t>(t)] = with;
            group[static_cast<std::size_t>(t)] = static_cast<int>(legend.size());
        }
        legend.push_back({with, fmt::format("{} ({} triangles)", words, triangles.size())});
    }
};

Paint paint_of(const Problem& problem) {
    const auto m = static_cast<std::size_t>(problem.surface.num_triangles());
    Paint paint{std::vector<Colour>(m, free_colour), std::vector<int>(m, 0), {}};
    std::vector<int> all(m);
    for (std::size_t t = 0; t < m; ++t) all[t] = static_cast<int>(t);
    paint.add(all, free_colour, "surface");
    paint.add(problem.fixed, held_colour, "held");
    for (const AttachedPart& part : problem.attached) paint.add(part.triangles, attached_colour, part.name);
    return paint;
}

constexpr std::size_t max_regions = 24, max_levels = 6;
constexpr int min_named = 150;  ///< pixels of a patch that has its name in the picture

/// A view along a coordinate direction of the body: the direction to the eye, and what is up there.
struct Side {
    const char* words;
    Vector3d from, up;
};

std::vector<Side> sides_of(const BodyAxes& body) {
    const Vector3d x = body.downstream, y = body.right(), z = body.up;
    return {{"from above", z, y},     {"from below", -z, y}, {"from the left", -y, z},
            {"from the right", y, z}, {"from ahead", -x, z}, {"from behind", x, z}};
}

/// From where most of the triangles' area is turned to the eye.
const Side& best_side(const std::vector<Side>& sides, const TriMesh& surface, const std::vector<int>& triangles) {
    const Points normal = triangle_normals(surface);
    const Eigen::VectorXd area = triangle_areas(surface);
    const auto seen = [&](const Side& side) {
        double sum = 0;
        for (const int t : triangles) sum += area[t] * std::max(0.0, normal.row(t).dot(side.from));
        return sum;
    };
    const Side* best = &sides.front();
    double most = -1;
    for (const Side& side : sides)
        if (const double sum = seen(side); sum > most * (1 + 1e-6)) most = sum, best = &side;
    return *best;
}

Panel panel_of(const TriMesh& surface, const std::vector<Colour>& colour, const std::vector<int>& label,
               const Side& side, const std::string& title) {
    Panel panel{draw_surface(surface, colour, label, {side.from, side.up, 0.12}, width, height)};
    panel.title = fmt::format("{}, {}", title, side.words);
    panel.ticks = ticks_of(panel.drawing, bounding_box(surface));
    return panel;
}

Panel region_panel(const TriMesh& surface, const std::vector<Side>& sides, const RegionTriangles& region) {
    const auto m = static_cast<std::size_t>(surface.num_triangles());
    std::vector<Colour> colour(m, free_colour);
    std::vector<int> label(m, 0);
    for (const int t : region.triangles)
        colour[static_cast<std::size_t>(t)] = region_colour, label[static_cast<std::size_t>(t)] = 1;
    return panel_of(surface, colour, label, best_side(sides, surface, region.triangles),
                    fmt::format("{}: {} triangles", region.name, region.triangles.size()));
}

Panel patches_panel(const Problem& problem, const std::vector<Side>& sides, std::size_t number) {
    const PatchLevel& level = problem.tree.levels[number];
    std::vector<int> label = labels_on_surface(problem, level);
    std::vector<Colour> colour;
    for (const int k : label) colour.push_back(patch_colour(k));
    std::vector<std::string> names;
    for (const Patch& patch : level.patches) names.push_back(patch.name);
    for (const int t : problem.fixed)
        colour[static_cast<std::size_t>(t)] = held_colour,
        label[static_cast<std::size_t>(t)] = static_cast<int>(names.size());
    names.emplace_back("held");
    std::vector<int> all(label.size());
    std::iota(all.begin(), all.end(), 0);
    Panel panel = panel_of(problem.surface, colour, label, best_side(sides, problem.surface, all),
                           fmt::format("level {}: {} patches", number, level.patches.size()));
    panel.names = names_in(panel.drawing, label, names, min_named);
    return panel;
}

}  // namespace

std::vector<int> labels_on_surface(const Problem& problem, const PatchLevel& level) {
    return problem.wrap ? carried(level.label, problem.wrap->wrap_triangle()) : level.label;
}

void add_axes_arrows(Panel& panel, const AxesFacts& axes, double diagonal) {
    const Drawing& drawing = panel.drawing;
    const double gap = 0.02 * diagonal, reach = 0.2 * diagonal;
    const Vector3d x = axes.axes.downstream, z = axes.axes.up;
    const Vector3d begin = axes.nose.point - (gap + reach) * x;
    panel.arrows.push_back(arrow(drawing, begin, axes.nose.point - gap * x, air, ""));
    if ((panel.arrows.back().to - panel.arrows.back().from).norm() > 20) {
        const Eigen::Vector2d middle = (panel.arrows.back().to + panel.arrows.back().from) / 2;
        panel.names.push_back({middle[0], middle[1] - 12, "air"});
    }
    panel.arrows.push_back(
        arrow(drawing, axes.top.point + gap * z, axes.top.point + (gap + 0.7 * reach) * z, up_colour, "up"));
    const bool is_left = axes.half < 0;
    const BodyEnd& tip = is_left ? axes.left : axes.right;
    panel.arrows.push_back(arrow(drawing, tip.point + gap * tip.direction,
                                 tip.point + (gap + 0.7 * reach) * tip.direction, wing_colour,
                                 is_left ? "left wing" : "right wing"));
}

std::string check_picture(const Case& the_case, const BuiltProblem& built, const std::optional<AxesFacts>& axes) {
    const Problem& problem = built.problem;
    const BodyAxes body = axes ? axes->axes : BodyAxes{};
    const Vector3d x = body.downstream, y = body.right(), z = body.up, side = axes && axes->half < 0 ? Vector3d(-y) : y;
    const Paint paint = paint_of(problem);
    std::vector<Panel> panels;
    for (const auto& [title, from, up] :
         {std::tuple<const char*, Vector3d, Vector3d>{"from ahead and above", -x + 1.1 * side + 0.8 * z, z},
          {"from the left", -y, z},
          {"from above", z, y}}) {
        Panel panel{draw_surface(problem.surface, paint.colour, paint.group, {from, up, 0.2}, width, height), title};
        panel.ticks = ticks_of(panel.drawing, bounding_box(problem.surface));
        if (axes) add_axes_arrows(panel, *axes, box_diagonal(problem.surface));
        panels.push_back(std::move(panel));
    }
    const std::vector<Side> sides = sides_of(body);
    for (std::size_t k = 0; k < std::min(max_regions, built.regions.size()); ++k)
        panels.push_back(region_panel(problem.surface, sides, built.regions[k]));
    const bool is_search = !problem.objective.empty() || !problem.fit.empty();
    for (std::size_t k = 1; is_search && problem.has_shell && k < std::min(max_levels, problem.tree.levels.size()); ++k)
        panels.push_back(patches_panel(problem, sides, k));
    const std::string words = !axes            ? "no axes stated, none needed"
                              : body.is_stated ? "axes as stated"
                                               : "axes assumed: state `axes` if the body points elsewhere";
    return svg_picture(fmt::format("{}: {}", the_case.name, words), panels, paint.legend, 3);
}

}  // namespace strake::cli
