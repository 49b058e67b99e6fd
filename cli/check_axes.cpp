#include "cli/check_axes.hpp"

#include "core/error.hpp"

#include <fmt/core.h>
#include <Eigen/Geometry>
#include <cmath>

namespace strake::cli {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

/// The vertex of a triangle that is farthest along `direction`; the first of several.
BodyEnd end_along(const Vector3d& direction, const TriMesh& surface) {
    BodyEnd end{direction};
    double farthest = -std::numeric_limits<double>::infinity();
    for (int t = 0; t < surface.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            const int v = surface.triangles(t, k);
            const double at = direction.dot(surface.vertices.row(v));
            if (at < farthest || (at == farthest && v > end.vertex)) continue;
            farthest = at;
            end.vertex = v;
            end.point = surface.vertices.row(v);
        }
    return end;
}

/// 0 x, 1 y, 2 z; -1: none of them.
int coordinate_of(const Vector3d& direction) {
    for (int k = 0; k < 3; ++k)
        if (std::abs(std::abs(direction[k]) - 1) < 1e-12) return k;
    return -1;
}

std::string point_words(const Vector3d& p) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p[0] + 0.0, p[1] + 0.0, p[2] + 0.0);
}

/// "+x" or "(0.8, 0, 0.6)".
std::string direction_words(const Vector3d& d) {
    const int k = coordinate_of(d);
    return k < 0 ? point_words(d) : fmt::format("{}{}", d[k] < 0 ? '-' : '+', "xyz"[k]);
}

/// "x = -1.2, vertex 17".
std::string place_words(const BodyEnd& end) {
    const int k = coordinate_of(end.direction);
    return fmt::format("{}, vertex {}",
                       k < 0 ? point_words(end.point) : fmt::format("{} = {:.6g}", "xyz"[k], end.point[k] + 0.0),
                       end.vertex);
}

Json json_of(const Vector3d& v) { return {v[0] + 0.0, v[1] + 0.0, v[2] + 0.0}; }
Json json_of(const BodyEnd& end) { return {{"vertex", end.vertex}, {"point", json_of(end.point)}}; }

/// The half that is modelled, and what is odd about axes of which neither lies along the plane.
void look_at_plane(const SymmetryPlane& plane, const TriMesh& surface, AxesFacts& facts) {
    facts.is_half_model = true;
    const Vector3d right = facts.axes.right();
    if (std::abs(right.dot(plane.normal)) > 1 - 1e-6) {
        double mean = 0;
        for (int t = 0; t < surface.num_triangles(); ++t)
            for (int k = 0; k < 3; ++k)
                mean += plane.normal.dot(surface.vertices.row(surface.triangles(t, k))) - plane.offset;
        facts.half = mean * right.dot(plane.normal) > 0 ? 1 : -1;
    } else if (!facts.users.empty()) {
        facts.warning = fmt::format(
            "axes: the right wing points along {}, but the symmetry plane has the normal {}; downstream {} and up {} "
            "should both lie in the plane",
            direction_words(right), direction_words(plane.normal), direction_words(facts.axes.downstream),
            direction_words(facts.axes.up));
    }
}

}  // namespace

std::optional<AxesFacts> axes_facts(const Case& the_case, const TriMesh& surface) {
    const std::optional<BodyAxes> axes = body_axes(the_case);
    if (!axes || surface.num_triangles() == 0) return {};
    AxesFacts facts{*axes};
    for (const QuantityEntry& quantity : the_case.quantities)
        if (const auto* made = std::get_if<BuiltInEntry>(&quantity.what); made && made->axes)
            facts.users.push_back(quantity.name);
    const Vector3d x = facts.axes.downstream;
    facts.nose = end_along(-x, surface);
    facts.tail = end_along(x, surface);
    facts.right = end_along(facts.axes.right(), surface);
    facts.left = end_along(-facts.axes.right(), surface);
    facts.top = end_along(facts.axes.up, surface);
    facts.whole_coefficients = the_case.aero.whole_coefficients;
    if (the_case.symmetry) look_at_plane(*the_case.symmetry, surface, facts);
    return facts;
}

void print_axes(const AxesFacts& facts) {
    const BodyAxes& axes = facts.axes;
    fmt::print("axes        downstream {}, up {}, right wing {}{}\n", direction_words(axes.downstream),
               direction_words(axes.up), direction_words(axes.right()),
               axes.is_stated ? "" : "; assumed: state `axes` if the body points elsewhere");
    fmt::print("            -->  air meets the nose at {}; it leaves the tail at {}\n", place_words(facts.nose),
               place_words(facts.tail));
    if (facts.half < 0)
        fmt::print("            <--  this is the left half: left wing tip at {}\n", place_words(facts.left));
    else
        fmt::print("            ==>  right wing tip at {}{}\n", place_words(facts.right),
                   facts.half > 0 ? "; this is the right half" : "");
    fmt::print("             ^   top at {}\n", place_words(facts.top));
    if (facts.is_half_model && !facts.users.empty())
        fmt::print("forces      coefficients of the {} (symmetry.coefficients: {})\n",
                   facts.whole_coefficients ? "whole body" : "half that is modelled",
                   facts.whole_coefficients ? "whole" : "half");
}

Json axes_json(const std::optional<AxesFacts>& facts) {
    if (!facts) return nullptr;
    Json j{{"downstream", json_of(facts->axes.downstream)},
           {"up", json_of(facts->axes.up)},
           {"right", json_of(facts->axes.right())},
           {"stated", facts->axes.is_stated},
           {"used_by", facts->users},
           {"nose", json_of(facts->nose)},
           {"tail", json_of(facts->tail)},
           {"right_wing", json_of(facts->right)},
           {"left_wing", json_of(facts->left)},
           {"top", json_of(facts->top)},
           {"half", facts->half > 0   ? Json("right")
                    : facts->half < 0 ? Json("left")
                                      : Json(nullptr)}};
    j["coefficients"] = facts->is_half_model ? Json(facts->whole_coefficients ? "whole" : "half") : Json(nullptr);
    return j;
}

}  // namespace strake::cli
