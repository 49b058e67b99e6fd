#include "casefile/build/prepare_surface.hpp"

#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/geometry.hpp"

namespace strake {
namespace {

double length_in(const std::optional<Length>& length, double diagonal) { return length ? length->in(diagonal) : 0; }

RepairOptions options_of(const RepairEntry& entry, double diagonal) {
    RepairOptions options = entry.options;
    if (entry.all) {
        options = all_repairs(diagonal);
        options.fill = entry.options.fill;
        options.keep_largest = entry.options.keep_largest;
        options.min_area_share = entry.options.min_area_share;
        options.min_triangles = entry.options.min_triangles;
    }
    if (entry.weld) options.weld = entry.weld->in(diagonal);
    if (entry.cracks) options.cracks = entry.cracks->in(diagonal);
    if (entry.joints) options.joints = entry.joints->in(diagonal);
    if (entry.holes) {
        options.holes = entry.holes->in(diagonal);
        options.keep_symmetry_loops = false;
    }
    return options;
}

void repair_start(const RepairEntry& entry, const std::optional<SymmetryPlane>& symmetry, PreparedSurface& surface) {
    RepairOptions options = options_of(entry, box_diagonal(surface.mesh));
    options.symmetry = symmetry;
    RepairResult result = repair(surface.mesh, options);
    std::string counts;
    for (int k = 0; k <= static_cast<int>(RepairKind::isolated); ++k)
        if (const int count = result.count(static_cast<RepairKind>(k)); count > 0)
            counts += text(counts.empty() ? "" : ", ", count, " ", name_of(static_cast<RepairKind>(k)));
    surface.notes.push_back("repair: " + (counts.empty() ? "nothing to repair" : counts));
    for (const std::string& words : result.remaining) surface.warnings.push_back("repair: remaining: " + words);
    surface.repairs_csv = repair_csv(result);
    surface.mesh = std::move(result.mesh);
    surface.source_triangle = std::move(result.source_triangle);
}

void remesh(const RemeshEntry& entry, const std::function<bool()>& stop_wanted, PreparedSurface& surface) {
    RemeshOptions options = entry.options;
    const double diagonal = box_diagonal(surface.mesh);
    options.edge_length = length_in(entry.edge_length, diagonal);
    options.chord_error = length_in(entry.chord_error, diagonal);
    options.shortest_edge = length_in(entry.shortest_edge, diagonal);
    const int before = surface.mesh.num_triangles();
    RemeshResult result =
        remesh(surface.mesh, options, [&](const RemeshRecord&) { return !stop_wanted || !stop_wanted(); });
    if (result.cancelled) throw Interrupted{};
    if (const std::string words = short_edge_words(result); !words.empty()) surface.notes.push_back("remesh: " + words);
    surface.mesh = std::move(result.mesh);
    surface.source_triangle.clear();
    surface.is_remeshed = true;
    surface.notes.push_back(text("remesh: ", before, " triangles replaced by ", surface.mesh.num_triangles(),
                                 " with edge length ", result.edge_length));
    if (result.new_intersections > 0)
        surface.warnings.push_back(text("remesh: ", result.new_intersections, " new pairs of intersecting triangles"));
}

}  // namespace

Snapped snap_open_edges(const SymmetryPlane& plane, double reach, TriMesh& mesh) {
    const Adjacency adjacent = adjacency(mesh);
    Points& x = mesh.vertices;
    std::vector<char> snaps(static_cast<std::size_t>(mesh.num_vertices()), 0);
    const auto away = [&](int v) { return plane.normal.dot(x.row(v)) - plane.offset; };
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        const auto [a, b] = adjacent.edges[e];
        if (adjacent.edge_triangles[e].size() == 1 && std::abs(away(a)) <= reach && std::abs(away(b)) <= reach)
            snaps[static_cast<std::size_t>(a)] = snaps[static_cast<std::size_t>(b)] = 1;
    }
    Snapped done;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const double off = away(v);
        if (!snaps[static_cast<std::size_t>(v)] || off == 0) continue;
        x.row(v) -= off * plane.normal.transpose();
        done.farthest = std::max(done.farthest, std::abs(off));
        ++done.vertices;
    }
    return done;
}

PreparedSurface prepare_surface(const Case& the_case) {
    SurfaceFile file = read_surface(the_case.surface);
    check_coordinates(the_case.surface, file.mesh);
    PreparedSurface surface;
    surface.mesh = std::move(file.mesh);
    surface.format = file.format;
    surface.file_triangles = surface.mesh.num_triangles();
    Diagnostics errors = diagnostics_of(the_case);
    const auto at = [&](const Place& place, const auto& work) {
        try {
            work();
        } catch (const InvalidInput& refused) {
            errors.add(place, refused.what());
        }
        errors.throw_if_any();
    };
    if (the_case.repair)
        at(the_case.repair->place, [&] { repair_start(*the_case.repair, the_case.symmetry, surface); });
    if (the_case.remesh) at(the_case.remesh->place, [&] { remesh(*the_case.remesh, the_case.stop_wanted, surface); });
    surface.is_changed = the_case.repair || the_case.remesh || the_case.symmetry_snap;
    if (the_case.symmetry && the_case.symmetry_snap) {
        const double diagonal = box_diagonal(surface.mesh);
        const Snapped done = snap_open_edges(*the_case.symmetry, the_case.symmetry_snap->in(diagonal), surface.mesh);
        surface.notes.push_back(text("symmetry: ", done.vertices,
                                     " vertices of open edges moved onto the plane, by at ", "most ", done.farthest,
                                     " (", 100 * done.farthest / diagonal, " % of the diagonal)"));
    }
    return surface;
}

}  // namespace strake
