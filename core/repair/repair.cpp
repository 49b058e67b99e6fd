#include "core/repair/repair.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/repair/surface_parts.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace strake {
namespace mending {

Eigen::Vector3d Surface::center(int t) const {
    return (mesh.vertices.row(mesh.triangles(t, 0)) + mesh.vertices.row(mesh.triangles(t, 1)) +
            mesh.vertices.row(mesh.triangles(t, 2))) /
           3;
}

void Surface::remove(const std::vector<char>& is_gone) {
    int kept = 0;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        if (is_gone[t]) continue;
        mesh.triangles.row(kept) = mesh.triangles.row(t);
        source[kept] = source[t];
        if (!mesh.group.empty()) mesh.group[kept] = mesh.group[t];
        ++kept;
    }
    mesh.triangles.conservativeResize(kept, 3);
    source.resize(static_cast<std::size_t>(kept));
    if (!mesh.group.empty()) mesh.group.resize(static_cast<std::size_t>(kept));
}

void Surface::append(const std::vector<std::array<int, 3>>& triangles, const std::vector<int>& from,
                     const std::vector<int>& group) {
    const int before = mesh.num_triangles();
    mesh.triangles.conservativeResize(before + static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t i = 0; i < triangles.size(); ++i)
        for (int k = 0; k < 3; ++k) mesh.triangles(before + static_cast<Eigen::Index>(i), k) = triangles[i][k];
    source.insert(source.end(), from.begin(), from.end());
    mesh.group.insert(mesh.group.end(), group.begin(), group.end());
}

void Surface::append_vertices(const std::vector<Eigen::Vector3d>& points) {
    const int before = mesh.num_vertices();
    mesh.vertices.conservativeResize(before + static_cast<Eigen::Index>(points.size()), 3);
    for (std::size_t i = 0; i < points.size(); ++i)
        mesh.vertices.row(before + static_cast<Eigen::Index>(i)) = points[i];
}

namespace {

/// Removes vertices that lost their last triangle; those unused before only on request.
void leave_out_vertices(Surface& surface, const std::vector<char>& had_triangles, bool isolated) {
    TriMesh& mesh = surface.mesh;
    const std::vector<char> is_used = used_vertices(mesh);
    std::vector<int> number(is_used.size(), -1);
    int kept = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const bool was_isolated = v < surface.input_vertices && !had_triangles[v];
        if (was_isolated && isolated)
            surface.items.push_back(
                {RepairKind::isolated, v, -1, mesh.vertices.row(v), 0, 0, text("vertex ", v, ", in no triangle")});
        if (!is_used[v] && !(was_isolated && !isolated)) continue;
        number[v] = kept;
        mesh.vertices.row(kept++) = mesh.vertices.row(v);
    }
    mesh.vertices.conservativeResize(kept, 3);
    for (int i = 0; i < mesh.triangles.size(); ++i) mesh.triangles.data()[i] = number[mesh.triangles.data()[i]];
}

/// The repairs that remove no part and close nothing larger than a crack.
void connect(Surface& surface, const RepairOptions& options) {
    if (options.weld) weld(surface, *options.weld);
    if (options.duplicates) remove_duplicates(surface);
    if (options.degenerate) remove_degenerate(surface);
    if (options.cracks) close_cracks(surface, *options.cracks);
    if (options.orient) orient(surface);
}

}  // namespace
}  // namespace mending

void validate(const RepairOptions& o) {
    const auto refuse = [](const char* field, double value, const char* limit) {
        throw InvalidInput(text("repair: ", field, " = ", value, " must be ", limit));
    };
    if (o.weld && !(*o.weld >= 0 && std::isfinite(*o.weld))) refuse("weld", *o.weld, "a length >= 0");
    if (o.cracks && !(*o.cracks > 0 && std::isfinite(*o.cracks))) refuse("cracks", *o.cracks, "a length > 0");
    if (o.holes && !(*o.holes > 0)) refuse("holes", *o.holes, "a length > 0");
    if (o.joints && !(*o.joints > 0 && std::isfinite(*o.joints))) refuse("joints", *o.joints, "a length > 0");
    if (o.keep_largest < 0) refuse("keep_largest", o.keep_largest, ">= 0");
    if (!(o.min_area_share >= 0 && o.min_area_share < 1)) refuse("min_area_share", o.min_area_share, "in [0, 1)");
    if (o.min_triangles < 0) refuse("min_triangles", o.min_triangles, ">= 0");
}

RepairOptions all_repairs(double diagonal) {
    RepairOptions o;
    o.weld = 1e-9 * diagonal;
    o.cracks = 1e-5 * diagonal;
    o.holes = 0.1 * diagonal;
    if (!(diagonal > 0)) o.cracks.reset(), o.holes.reset();
    o.duplicates = o.degenerate = o.orient = o.split = o.isolated = o.keep_symmetry_loops = true;
    return o;
}

std::string name_of(RepairKind kind) {
    static constexpr const char* names[] = {"weld",  "duplicate", "degenerate", "crack", "orient",
                                            "split", "component", "hole",       "joint", "isolated"};
    return names[static_cast<int>(kind)];
}

int RepairResult::count(RepairKind kind) const {
    return static_cast<int>(std::count_if(items.begin(), items.end(), [&](const auto& i) { return i.kind == kind; }));
}

RepairResult repair(const TriMesh& mesh, const RepairOptions& options) {
    validate(options);
    if (mesh.num_triangles() == 0) throw InvalidInput("repair: the surface has no triangles");
    RepairResult result;
    result.before = checkup(mesh);
    mending::Surface surface{mesh,
                             std::vector<int>(static_cast<std::size_t>(mesh.num_triangles())),
                             mesh.num_vertices(),
                             result.before.diagonal,
                             {}};
    std::iota(surface.source.begin(), surface.source.end(), 0);
    const std::vector<char> had_triangles = used_vertices(mesh);
    for (int round = 0; round < 5; ++round) {  // one repair may create work for an earlier one
        const std::size_t before = surface.items.size();
        mending::connect(surface, options);
        if (surface.items.size() == before) break;
    }
    if (options.holes) mending::fill_holes(surface, options);  // touching loops are separate holes
    if (options.split) mending::split_nonmanifold(surface);
    if (options.split && options.orient) mending::orient(surface);  // parts that are apart now
    mending::drop_components(surface, options);
    const int refused_fills = options.holes ? mending::fill_holes(surface, options) : 0;
    if (options.degenerate) mending::remove_degenerate(surface);  // fills of loops that touch themselves
    if (options.joints) mending::split_joints(surface, *options.joints);
    if (surface.mesh.num_triangles() == 0) throw InvalidInput("repair: no triangle would be left");
    mending::leave_out_vertices(surface, had_triangles, options.isolated);
    result.mesh = std::move(surface.mesh);
    result.source_triangle = std::move(surface.source);
    result.items = std::move(surface.items);
    result.after = checkup(result.mesh);
    result.remaining = mending::what_remains(result.after, options, refused_fills);
    return result;
}

}  // namespace strake
