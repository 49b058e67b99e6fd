#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/repair/repair.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>

/// Defects in plain text.
namespace strake {
namespace {

std::string first_few(std::size_t count, const auto& item) {
    std::string list;
    for (std::size_t i = 0; i < std::min<std::size_t>(count, 5); ++i) list += (i ? ", " : "") + item(i);
    return count > 5 ? list + ", ..." : list;
}

std::string first_few(const std::vector<int>& ids) {
    return first_few(ids.size(), [&](std::size_t i) { return std::to_string(ids[i]); });
}

std::string first_edges(const Checkup& c, const std::vector<int>& edges) {
    return first_few(edges.size(), [&](std::size_t i) {
        return text(c.adjacent.edges[edges[i]][0], "-", c.adjacent.edges[edges[i]][1]);
    });
}

std::string first_pairs(const TriMesh& mesh, const std::vector<std::array<int, 2>>& pairs) {
    return first_few(pairs.size(), [&](std::size_t i) {
        const Eigen::RowVector3d x = mesh.vertices.row(mesh.triangles(pairs[i][0], 0));
        return text(pairs[i][0], " and ", pairs[i][1],
                    i == 0 ? text(" near (", x[0], ", ", x[1], ", ", x[2], ")") : "");
    });
}

/// Whether both lie in one plane, to round-off: they overlap instead of crossing.
bool are_in_one_plane(const TriMesh& mesh, const std::array<int, 2>& pair, double diagonal) {
    constexpr double flat = 1e-9;  // of the diagonal
    const auto corner = [&](int t, int k) -> Eigen::RowVector3d { return mesh.vertices.row(mesh.triangles(t, k)); };
    for (const auto& [t, other] : {std::pair{pair[0], pair[1]}, std::pair{pair[1], pair[0]}}) {
        const Eigen::RowVector3d at = corner(t, 0), normal = (corner(t, 1) - at).cross(corner(t, 2) - at).normalized();
        for (int k = 0; k < 3; ++k)
            if (std::abs(normal.dot(corner(other, k) - at)) > flat * diagonal) return false;
    }
    return true;
}

/// Crossing pairs and overlapping pairs.
std::array<std::vector<std::array<int, 2>>, 2> by_kind(const TriMesh& mesh, const Checkup& c) {
    std::array<std::vector<std::array<int, 2>>, 2> kinds;
    if (c.pairs)
        for (const auto& pair : c.pairs->apart) kinds[are_in_one_plane(mesh, pair, c.diagonal) ? 1 : 0].push_back(pair);
    return kinds;
}

std::string first_loops(const Checkup& c) {
    return first_few(c.loops.size(), [&](std::size_t i) {
        const BoundaryLoop& loop = c.loops[i];
        std::string words = text(loop.vertices.size(), " vertices from ", loop.vertices.front(), ", length ",
                                 loop.length, loop.is_planar ? ", flat" : "");
        if (loop.symmetry_axis >= 0)
            words += text(", in the plane ", "xyz"[loop.symmetry_axis], " = ", loop.symmetry_at);
        return words;
    });
}

bool has_holes(const Checkup& c) {
    return std::any_of(c.loops.begin(), c.loops.end(), [](const auto& loop) { return loop.symmetry_axis < 0; });
}

}  // namespace

std::vector<std::string> defects_in_words(const TriMesh& mesh, const Checkup& c) {
    std::vector<std::string> list;
    const auto add = [&](std::size_t count, const char* what, const std::string& ids) {
        if (count > 0) list.push_back(text(count, " ", what, ": ", ids));
    };
    const TopologyFacts& f = c.facts;
    add(f.boundary_loops.size(), "open boundary loop(s)", first_loops(c));
    if (!c.crack_vertices.empty())
        list.push_back(text("cracks: ", c.crack_vertices.size(), " boundary vertices lie within 1e-5 diagonal of ",
                            "another or of an open edge that is not theirs, vertices: ", first_few(c.crack_vertices)));
    add(f.nonmanifold_edges.size(), "non-manifold edge(s), more than two triangles, vertices",
        first_edges(c, f.nonmanifold_edges));
    add(f.nonmanifold_vertices.size(), "non-manifold vertex(es), triangles in more than one fan, vertices",
        first_few(f.nonmanifold_vertices));
    add(f.misoriented_edges.size(), "edge(s) whose two triangles disagree in orientation, vertices",
        first_edges(c, f.misoriented_edges));
    if (!f.orientable) list.push_back("not orientable: turning triangles cannot make them agree");
    if (f.closed && c.volume < 0) list.push_back("oriented inward: the enclosed volume is negative");
    if (c.inward_components > 0 && !(f.closed && c.volume < 0))
        list.push_back(text(c.inward_components, " closed component(s) oriented inward: voids, or inside out"));
    add(f.duplicate_triangles.size(), "duplicate triangle(s), same vertices as an earlier one, triangles",
        first_few(f.duplicate_triangles));
    add(f.degenerate_triangles.size(), "degenerate triangle(s), area below 1e-14 diagonal^2, triangles",
        first_few(f.degenerate_triangles));
    add(c.inverted_triangles.size(), "inverted triangle(s), folded over onto their neighbours, triangles",
        first_few(c.inverted_triangles));
    add(f.isolated_vertices.size(), "isolated vertex(es), in no triangle, vertices", first_few(f.isolated_vertices));
    add(f.duplicate_vertices.size(), "duplicate vertex(es), at the place of an earlier one, vertices",
        first_few(f.duplicate_vertices));
    if (c.pairs) {
        const auto [through, on] = by_kind(mesh, c);
        add(through.size(), "pair(s) of triangles intersect (they pass through each other, or touch), triangles",
            first_pairs(mesh, through));
        add(on.size(),
            "pair(s) of triangles overlap in one plane (bodies that touch, or a face that is there twice), "
            "triangles",
            first_pairs(mesh, on));
        add(c.pairs->adjacent.size(),
            "pair(s) of neighbouring triangles are folded onto each other or cross, triangles",
            first_pairs(mesh, c.pairs->adjacent));
    } else {
        list.push_back(text("self-intersections were not checked: a vertex has ", c.quality.max_valence, " triangles"));
    }
    return list;
}

namespace {

using Counts = std::vector<std::pair<const char*, std::size_t>>;

/// Defects by kind, always in this order.
Counts counts_of(const Checkup& c) {
    const TopologyFacts& f = c.facts;
    const auto cuts = std::count_if(c.loops.begin(), c.loops.end(), [](const auto& l) { return l.symmetry_axis >= 0; });
    return {{"open boundary loops", c.loops.size() - static_cast<std::size_t>(cuts)},
            {"crack vertices", c.crack_vertices.size()},
            {"non-manifold edges", f.nonmanifold_edges.size()},
            {"non-manifold vertices", f.nonmanifold_vertices.size()},
            {"edges that disagree in orientation", f.misoriented_edges.size()},
            {"components oriented inward", static_cast<std::size_t>(c.inward_components)},
            {"duplicate triangles", f.duplicate_triangles.size()},
            {"degenerate triangles", f.degenerate_triangles.size()},
            {"inverted triangles", c.inverted_triangles.size()},
            {"isolated vertices", f.isolated_vertices.size()},
            {"duplicate vertices", f.duplicate_vertices.size()},
            {"pairs of triangles that intersect", c.pairs ? c.pairs->apart.size() : 0},
            {"pairs of neighbours that are folded", c.pairs ? c.pairs->adjacent.size() : 0},
            {"surfaces of one side", f.orientable ? 0u : 1u}};
}

/// Repairs as options of the command, tried on copies of the surface.
class Trials {
public:
    Trials(const TriMesh& mesh, const Checkup& before) : mesh_(mesh), before_(counts_of(before)), after_(before_) {}

    void add(bool helps, const std::string& option, std::function<void(RepairOptions&)> set) {
        if (helps) candidates_.push_back({option, std::move(set)});
    }

    /// All of them where they make nothing worse together; else each that, with those before it, makes nothing worse
    /// and something better. @return the command with what it leaves; empty: none helps
    std::string proposal() {
        if (candidates_.empty()) return "";
        if (!take(candidates_)) take_some();
        if (words_.empty()) return "";
        std::string left;
        for (std::size_t i = 0; i < after_.size(); ++i)
            if (after_[i].second < before_[i].second)
                left +=
                    text(left.empty() ? "" : ", ", after_[i].second, " of ", before_[i].second, " ", after_[i].first);
        return text("strake repair SURFACE --out FILE", words_, " leaves ", left, " (tried on a copy)");
    }

private:
    struct Candidate {
        std::string option;
        std::function<void(RepairOptions&)> set;
    };

    void take_some() {
        constexpr int large = 100'000;  // triangles from which each trial takes seconds
        std::vector<Candidate> kept;
        for (const Candidate& one : candidates_) {
            kept.push_back(one);
            if (mesh_.num_triangles() < large && !take(kept)) kept.pop_back();
        }
        // There the last ones, which close and separate, are left out one after the other.
        for (int trial = 0; mesh_.num_triangles() >= large && trial < 3 && kept.size() > 1; ++trial) {
            kept.pop_back();
            if (take(kept)) return;
        }
    }

    bool take(const std::vector<Candidate>& chosen) {
        RepairOptions options;
        std::string words;
        for (const Candidate& one : chosen) one.set(options), words += " " + one.option;
        try {
            const Counts counts = counts_of(repair(mesh_, options).after);
            bool helps = false;
            for (std::size_t i = 0; i < counts.size(); ++i) {
                if (counts[i].second > before_[i].second) return false;
                helps |= counts[i].second < after_[i].second;
            }
            if (!helps) return false;
            after_ = counts;
            words_ = words;
            return true;
        } catch (const InvalidInput&) {  // nothing would be left
            return false;
        }
    }

    const TriMesh& mesh_;
    Counts before_, after_;
    std::string words_;
    std::vector<Candidate> candidates_;
};

std::string repair_advice(const TriMesh& mesh, const Checkup& c) {
    const TopologyFacts& f = c.facts;
    Trials trials(mesh, c);
    trials.add(!f.duplicate_vertices.empty(), "--weld 0", [](RepairOptions& o) { o.weld = 0; });
    trials.add(!f.duplicate_triangles.empty(), "--duplicates", [](RepairOptions& o) { o.duplicates = true; });
    trials.add(!f.degenerate_triangles.empty(), "--degenerate", [](RepairOptions& o) { o.degenerate = true; });
    if (c.diagonal > 0)
        trials.add(!c.crack_vertices.empty(), "--cracks 1e-3%",
                   [&](RepairOptions& o) { o.cracks = 1e-5 * c.diagonal; });
    trials.add((!f.misoriented_edges.empty() && f.orientable) || c.inward_components > 0, "--orient",
               [](RepairOptions& o) { o.orient = true; });
    trials.add(!f.nonmanifold_edges.empty() || !f.nonmanifold_vertices.empty(), "--split",
               [](RepairOptions& o) { o.split = true; });
    if (has_holes(c) && c.diagonal > 0 && f.orientable) {  // a fill of a one-sided surface would pass through it
        double largest = 0;
        for (const BoundaryLoop& loop : c.loops)
            if (loop.symmetry_axis < 0) largest = std::max(largest, loop.size);
        const double percent = std::max(1.0, std::ceil(100 * 1.001 * largest / c.diagonal));
        trials.add(true, text("--holes ", percent, "%"),
                   [&c, percent](RepairOptions& o) { o.holes = percent / 100 * c.diagonal; });
    }
    trials.add(!f.isolated_vertices.empty(), "--isolated", [](RepairOptions& o) { o.isolated = true; });
    return trials.proposal();
}

}  // namespace

std::optional<SymmetryPlane> cut_of_half(const TriMesh& mesh, const Adjacency& adjacent,
                                         const std::vector<BoundaryLoop>& loops) {
    const double diagonal = box_diagonal(mesh);
    const BoundaryLoop* cut = nullptr;
    for (const BoundaryLoop& loop : loops) {
        if (loop.symmetry_axis < 0) continue;
        if (cut && (cut->symmetry_axis != loop.symmetry_axis ||
                    std::abs(cut->symmetry_at - loop.symmetry_at) > 1e-6 * diagonal))
            return {};  // open at two ends
        cut = &loop;
    }
    if (!cut) return {};
    std::vector<char> is_at(static_cast<std::size_t>(mesh.num_vertices()));
    for (const int v : cut->vertices) is_at[v] = 1;
    double along = 0, length = 0;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        const auto [a, b] = adjacent.edges[e];
        if (adjacent.edge_triangles[e].size() != 1 || !is_at[a] || !is_at[b]) continue;
        const double side = (mesh.vertices.row(a) - mesh.vertices.row(b)).norm();
        const Eigen::Vector3d normal = area_vector(mesh, adjacent.edge_triangles[e][0]).normalized();
        along += side * std::abs(normal[cut->symmetry_axis]);
        length += side;
    }
    constexpr double creased = 0.5;  // sine of 30 degrees
    if (along > creased * length) return {};
    return SymmetryPlane{Eigen::Vector3d::Unit(cut->symmetry_axis), cut->symmetry_at};
}

std::string half_words(const SymmetryPlane& plane) {
    int axis = 0;
    plane.normal.cwiseAbs().maxCoeff(&axis);
    return text("half a body? Then add to the case symmetry: {plane: ", "xyz"[axis], ", at: ", plane.offset, "}");
}

std::vector<std::string> advice(const TriMesh& mesh, const Checkup& c) {
    const TopologyFacts& f = c.facts;
    std::vector<std::string> list;
    if (const std::string words = repair_advice(mesh, c); !words.empty()) list.push_back(words);
    if (const auto plane = cut_of_half(mesh, c.adjacent, c.loops)) list.push_back(half_words(*plane));
    if (!f.orientable)
        list.push_back(
            "no repair makes a surface of one side orientable: cut it across, or use it as it is, without volume");
    const auto [through, on] = by_kind(mesh, c);
    if (!through.empty())
        list.push_back("intersections stay: unite the parts in a modeller, or use them as separate components");
    if (!on.empty())
        list.push_back(
            "triangles that lie on one another stay: delete one of the two faces, or unite the parts in a modeller");
    else if (through.empty() && ((c.pairs && !c.pairs->adjacent.empty()) || !c.inverted_triangles.empty()))
        list.push_back("folds stay: strake remesh may smooth them away");
    return list;
}

DefectFields defect_fields(const TriMesh& mesh, const Checkup& c) {
    const auto marks = [](std::size_t size, const std::vector<int>& which) {
        std::vector<int> mark(size);
        for (const int i : which) mark[i] = 1;
        return mark;
    };
    const auto n = static_cast<std::size_t>(c.vertices), m = static_cast<std::size_t>(c.triangles);
    std::vector<int> boundary(n), nonmanifold_edge(n), misoriented(m), beside_nonmanifold(m), intersecting(m);
    for (std::size_t i = 0; i < c.loops.size(); ++i)
        for (const int v : c.loops[i].vertices) boundary[v] = static_cast<int>(i) + 1;
    for (const int e : c.facts.nonmanifold_edges) {
        for (const int v : c.adjacent.edges[e]) nonmanifold_edge[v] = 1;
        for (const int t : c.adjacent.edge_triangles[e]) beside_nonmanifold[t] = 1;
    }
    for (const int e : c.facts.misoriented_edges)
        for (const int t : c.adjacent.edge_triangles[e]) misoriented[t] = 1;
    if (c.pairs)
        for (const auto* pairs : {&c.pairs->apart, &c.pairs->adjacent})
            for (const auto& pair : *pairs)
                for (const int t : pair) intersecting[t] = 1;
    DefectFields fields;
    fields.points = {{"boundary_loop", boundary},
                     {"crack", marks(n, c.crack_vertices)},
                     {"nonmanifold_edge", nonmanifold_edge},
                     {"nonmanifold_vertex", marks(n, c.facts.nonmanifold_vertices)},
                     {"isolated", marks(n, c.facts.isolated_vertices)},
                     {"duplicate_vertex", marks(n, c.facts.duplicate_vertices)}};
    fields.cells = {{"component", edge_components(mesh, c.adjacent)},
                    {"nonmanifold_edge", beside_nonmanifold},
                    {"misoriented", misoriented},
                    {"duplicate", marks(m, c.facts.duplicate_triangles)},
                    {"degenerate", marks(m, c.facts.degenerate_triangles)},
                    {"inverted", marks(m, c.inverted_triangles)},
                    {"self_intersection", intersecting}};
    return fields;
}

}  // namespace strake
