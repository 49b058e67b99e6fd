#include "cli/check_picture.hpp"

#include "core/mesh/geometry.hpp"

#include <fmt/core.h>
#include <Eigen/Geometry>

namespace strake::cli {
namespace {

using Eigen::Vector3d;

constexpr int width = 400, height = 300;
constexpr Colour free_colour{178, 206, 232}, held_colour{150, 150, 150}, attached_colour{240, 228, 66};
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

}  // namespace

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

std::string check_picture(const Case& the_case, const Problem& problem, const std::optional<AxesFacts>& axes) {
    const BodyAxes body = axes ? axes->axes : BodyAxes{};
    const Vector3d x = body.downstream, y = body.right(), z = body.up, side = axes && axes->half < 0 ? Vector3d(-y) : y;
    const Paint paint = paint_of(problem);
    std::vector<Panel> panels;
    for (const auto& [title, from, up] :
         {std::tuple<const char*, Vector3d, Vector3d>{"from ahead and above", -x + 1.1 * side + 0.8 * z, z},
          {"from the left", -y, z},
          {"from above", z, y}}) {
        Panel panel{draw_surface(problem.surface, paint.colour, paint.group, {from, up, 0.2}, width, height), title};
        if (axes) add_axes_arrows(panel, *axes, box_diagonal(problem.surface));
        panels.push_back(std::move(panel));
    }
    const std::string words = !axes            ? "no axes stated, none needed"
                              : body.is_stated ? "axes as stated"
                                               : "axes assumed: state `axes` if the body points elsewhere";
    return svg_picture(fmt::format("{}: {}", the_case.name, words), panels, paint.legend);
}

}  // namespace strake::cli
