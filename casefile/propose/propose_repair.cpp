#include "casefile/propose/propose_parts.hpp"
#include "casefile/yaml/diagnostics.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/repair/repair.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace strake::proposing {
namespace {

constexpr double largest_hole = 0.35;  ///< of the diagonal: larger ones are intended openings

class Needs {
public:
    /// @param mesh as it is in the file: lengths of repairs are percentages of its diagonal. Debris leaves it.
    explicit Needs(TriMesh& mesh) : unit_(mesh.num_triangles() > 0 ? box_diagonal(mesh) : 0) {
        const std::optional<Debris> stray = debris(mesh);
        if (!stray) return;
        add(text("components: {min_area: ", stray->min_area_percent, "%}"),
            text(stray->triangles, stray->triangles > 1 ? " triangles in " : " triangle in ", stray->pieces,
                 stray->pieces > 1 ? " stray pieces" : " stray piece", " of ", std::ceil(1e7 * stray->share) / 1e5,
                 " % of the area"));
        options.min_area_share = stray->min_area_percent / 100;
        mesh = repair(mesh, options).mesh;
    }

    void add(const std::string& key, const std::string& why) {
        if (std::find(result.keys.begin(), result.keys.end(), key) != result.keys.end()) return;
        result.keys.push_back(key);
        result.why.push_back(why);
    }
    void orientation(const Checkup& c) {
        const TopologyFacts& f = c.facts;
        if (f.misoriented_edges.empty() && c.inward_components == 0) return;
        add("orient: true", f.misoriented_edges.empty()
                                ? text(c.inward_components, " closed parts face inward")
                                : text("at ", f.misoriented_edges.size(), " edges the orientation changes"));
        options.orient = true;
    }
    void joints(const JointTrial& tried) {
        add(text("joints: ", tried.percent, "%"), joint_words(tried));
        options.joints = tried.percent / 100 * unit_;
        result.has_new_vertices = true;
    }
    void topology(const Checkup& c) {
        const TopologyFacts& f = c.facts;
        if (!f.duplicate_vertices.empty() && !f.boundary_loops.empty()) {
            add("weld: 0", text(f.duplicate_vertices.size(), " vertices coincide with others"));
            options.weld = 0.0;
        }
        if (!f.duplicate_triangles.empty()) {
            add("duplicates: true", text(f.duplicate_triangles.size(), " triangles are duplicated"));
            options.duplicates = true;
        }
        if (!f.degenerate_triangles.empty()) {
            add("degenerate: true", text(f.degenerate_triangles.size(), " triangles have zero area"));
            options.degenerate = true;
        }
        if (!c.crack_vertices.empty()) {
            add("cracks: 1e-3%", text(c.crack_vertices.size(), " open vertices nearly coincide with others"));
            options.cracks = 1e-5 * unit_;
        }
        orientation(c);
        if (!f.nonmanifold_edges.empty()) {
            add("split: true", text(f.nonmanifold_edges.size(), " edges have more than two triangles"));
            options.split = true;
        }
    }
    void holes(const Checkup& c) {
        double largest = 0, smallest_cut = 1;
        int count = 0;
        for (const BoundaryLoop& loop : c.loops) {
            const double size = loop.size / unit_;
            if (loop.symmetry_axis >= 0)
                smallest_cut = std::min(smallest_cut, size);
            else if (loop.size <= largest_hole * c.diagonal)
                largest = std::max(largest, size), ++count;
        }
        const double percent = std::ceil(100 * largest + 0.5);
        if (count == 0 || percent / 100 >= smallest_cut) return;  // it would close the symmetry plane, too
        add(text("holes: ", percent, "%"),
            text(count, " holes up to ", text(std::round(1000 * largest) / 10), "% of the diagonal across"));
        options.holes = percent / 100 * unit_;
    }

    RepairOptions options;
    RepairedSurface result;

private:
    double unit_;
};

/// The body reaches far beyond its openings in this plane, to all four sides: the mouth of a bottle, not a cut.
bool is_mouth(const Checkup& checkup, const BoundaryLoop& cut, const TriMesh& mesh) {
    constexpr double far = 0.5;  // of the openings' extent
    Box opening{Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()),
                Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity())};
    for (const BoundaryLoop& loop : checkup.loops)
        for (const int v : loop.symmetry_axis == cut.symmetry_axis ? loop.vertices : std::vector<int>{}) {
            opening.min = opening.min.cwiseMin(mesh.vertices.row(v).transpose());
            opening.max = opening.max.cwiseMax(mesh.vertices.row(v).transpose());
        }
    for (int k = 0; k < 3; ++k) {
        const double margin = far * (opening.max[k] - opening.min[k]);
        const double low = opening.min[k] - checkup.box.min[k], high = checkup.box.max[k] - opening.max[k];
        if (k != cut.symmetry_axis && std::min(low, high) < margin) return false;
    }
    return true;
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what, const std::string& remedy) {
    throw InputError(text(printable(file.string(), 400), ": ", what, "; ", remedy));
}

}  // namespace

RepairedSurface repaired(const std::filesystem::path& file, TriMesh mesh) {
    if (mesh.num_triangles() == 0) refuse(file, "the surface has no triangles", "give a surface that has some");
    TriMesh before = mesh;
    Needs needs(mesh);
    Checkup found = checkup(mesh);
    if (!(found.diagonal > 0) || !(found.area > 0))
        refuse(file, "the surface has no area", "give a surface, not points or lines");
    needs.topology(found);
    needs.holes(found);
    RepairedSurface& result = needs.result;
    // A repair may expose defects that need another one: then all start over from the original.
    for (std::size_t asked = 0; asked < result.keys.size();) {
        asked = result.keys.size();
        RepairResult done = repair(before, needs.options);
        mesh = std::move(done.mesh);
        found = std::move(done.after);
        needs.topology(found);
    }
    const TopologyFacts& left = found.facts;
    if (!left.degenerate_triangles.empty() || !left.duplicate_triangles.empty())
        refuse(file,
               text(left.degenerate_triangles.size(), " triangles of zero area and ", left.duplicate_triangles.size(),
                    " duplicates remain after repair"),
               "`strake info` shows where; try `strake remesh`");
    result.couple = !left.nonmanifold_edges.empty();
    result.mesh = std::move(mesh);
    result.checkup = std::move(found);
    return result;
}

RepairedSurface as_it_is(TriMesh mesh, bool adds_vertices) {
    TriMesh before = mesh;
    Needs needs(mesh);
    Checkup found = checkup(mesh);
    needs.orientation(found);
    RepairedSurface& result = needs.result;
    const auto repair_again = [&] {
        RepairResult done = repair(before, needs.options);
        mesh = std::move(done.mesh);
        found = std::move(done.after);
    };
    if (!result.keys.empty()) repair_again();
    result.joints = tried_joints(mesh, found.pairs);
    if (result.joints && adds_vertices) {
        needs.joints(*result.joints);
        repair_again();
    }
    result.mesh = std::move(mesh);
    result.checkup = std::move(found);
    return result;
}

std::optional<NearCut> near_cut(const TriMesh& mesh) {
    constexpr double planar = 1e-6, nearly = 1e-4, size_of_cut = 0.2;  // of the diagonal
    const Adjacency adjacent = adjacency(mesh);
    const double diagonal = box_diagonal(mesh);
    std::vector<int> largest;
    double size = size_of_cut * diagonal;
    for (const std::vector<int>& loop : topology(mesh, adjacent).boundary_loops) {
        const Points at = mesh.vertices(loop, Eigen::all);
        const double own = (at.colwise().maxCoeff() - at.colwise().minCoeff()).norm();
        if (own > size) size = own, largest = loop;
    }
    if (largest.empty()) return {};
    const Points border = mesh.vertices(largest, Eigen::all);
    for (int k = 0; k < 3; ++k) {
        const double low = border.col(k).minCoeff(), high = border.col(k).maxCoeff(), middle = 0.5 * (low + high);
        if (high - low > 2 * nearly * diagonal) continue;
        const double at = std::abs(middle) <= nearly * diagonal ? 0 : middle;
        const double deviation = std::max(std::abs(low - at), std::abs(high - at));
        const bool on_one_side = mesh.vertices.col(k).minCoeff() > low - nearly * diagonal ||
                                 mesh.vertices.col(k).maxCoeff() < high + nearly * diagonal;
        if (deviation <= planar * diagonal || deviation > nearly * diagonal || !on_one_side) continue;
        return NearCut{{Eigen::Vector3d::Unit(k), at}, 0.02, deviation};
    }
    return {};
}

std::optional<SymmetryPlane> half_plane(const Checkup& checkup, const TriMesh& mesh) {
    const BoundaryLoop* best = nullptr;
    for (const BoundaryLoop& loop : checkup.loops)
        if (loop.symmetry_axis >= 0 && (!best || loop.size > best->size)) best = &loop;
    if (!best || is_mouth(checkup, *best, mesh)) return std::nullopt;
    return SymmetryPlane{Eigen::Vector3d::Unit(best->symmetry_axis), best->symmetry_at};
}

bool encloses_volume(const RepairedSurface& surface, const std::optional<SymmetryPlane>& plane) {
    const Checkup& c = surface.checkup;
    if (!c.facts.misoriented_edges.empty() || surface.couple) return false;
    for (int e = 0; e < c.adjacent.num_edges(); ++e) {
        if (c.adjacent.edge_triangles[e].size() != 1) continue;
        if (!plane) return false;
        for (const int v : c.adjacent.edges[e])
            if (std::abs(plane->normal.dot(surface.mesh.vertices.row(v)) - plane->offset) > 1e-6 * c.diagonal)
                return false;
    }
    return true;
}

}  // namespace strake::proposing
