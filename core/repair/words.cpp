#include "core/error.hpp"
#include "core/repair/checkup.hpp"

#include <Eigen/Geometry>
#include <algorithm>

/// What was found, in words for people.
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

/// Both in one plane, to round-off: they lie on one another and do not pass through each other.
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

/// Those that pass through each other, and those that lie on one another.
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
            words += text(", in the plane ", "xyz"[loop.symmetry_axis], " = ", loop.symmetry_at, ": a symmetry plane?");
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
        list.push_back(
            text("self-intersections were not looked for: a vertex has ", c.quality.max_valence, " triangles"));
    }
    return list;
}

std::vector<std::string> advice(const TriMesh& mesh, const Checkup& c) {
    const TopologyFacts& f = c.facts;
    std::string options;
    int kinds = 0;
    const auto add = [&](bool helps, const std::string& option) {
        if (!helps) return;
        options += " " + option;
        ++kinds;
    };
    add(!f.duplicate_vertices.empty(), "--weld 0");
    add(!f.duplicate_triangles.empty(), "--duplicates");
    add(!f.degenerate_triangles.empty(), "--degenerate");
    add(!c.crack_vertices.empty(), "--cracks 1e-3%");
    add((!f.misoriented_edges.empty() && f.orientable) || c.inward_components > 0, "--orient");
    add(!f.nonmanifold_edges.empty() || !f.nonmanifold_vertices.empty(), "--split");
    if (has_holes(c) && c.diagonal > 0 && f.orientable) {  // what closes a surface of one side passes through it
        double largest = 0;
        for (const BoundaryLoop& loop : c.loops)
            if (loop.symmetry_axis < 0) largest = std::max(largest, loop.size);
        add(true, text("--holes ", std::max(1.0, std::ceil(100 * 1.001 * largest / c.diagonal)), "%"));
    }
    add(!f.isolated_vertices.empty(), "--isolated");
    std::vector<std::string> list;
    if (kinds > 0)
        list.push_back(text("strake repair SURFACE --out FILE", options, " would mend ", kinds,
                            kinds == 1 ? " kind of defect" : " kinds of defects"));
    for (const BoundaryLoop& loop : c.loops)
        if (loop.symmetry_axis >= 0) {
            list.push_back(text("half a body? then state in the case symmetry: {plane: ", "xyz"[loop.symmetry_axis],
                                ", at: ", loop.symmetry_at, "}"));
            break;
        }
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
