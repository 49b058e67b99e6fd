#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/repair/repair.hpp"
#include "core/repair/surface_parts.hpp"

#include <algorithm>

namespace strake::mending {
namespace {

std::string place(const Checkup& c, const std::vector<int>& edges) {
    return text("first at vertices ", c.adjacent.edges[edges[0]][0], "-", c.adjacent.edges[edges[0]][1]);
}

void loops_that_remain(const Checkup& after, const RepairOptions& options, int refused_fills,
                       std::vector<std::string>& list) {
    int symmetry = 0, larger = 0, other = 0;
    double largest = 0;
    for (const BoundaryLoop& loop : after.loops) {
        if (is_meant(options, loop, after.diagonal)) continue;
        largest = std::max(largest, loop.size);
        if (options.holes && loop.size <= *options.holes && !(options.keep_symmetry_loops && loop.symmetry_axis >= 0))
            ++other;
        else if (options.keep_symmetry_loops && loop.symmetry_axis >= 0)
            ++symmetry;
        else
            ++larger;
    }
    if (symmetry > 0) list.push_back(text(symmetry, " open loop(s) kept as cuts of a half model"));
    if (larger > 0)
        list.push_back(
            text(larger, " open loop(s): ",
                 options.holes ? text("larger than the limit; --holes ", 1.001 * largest, " would close the largest")
                               : text("not requested; --holes SIZE closes them, the largest is ", largest, " across")));
    if (refused_fills > 0)
        list.push_back(text(refused_fills,
                            " open loop(s): their fill would pass through the surface or lie back to back with it"));
    if (other > refused_fills)
        list.push_back(text(other - refused_fills,
                            " open loop(s): orientation faults or edges of more than two triangles beside them ",
                            "leave no way around"));
}

}  // namespace

bool is_meant(const RepairOptions& options, const BoundaryLoop& loop, double diagonal) {
    if (!options.symmetry || loop.symmetry_axis < 0) return false;
    const double along = options.symmetry->normal[loop.symmetry_axis];
    return std::abs(along) > 1 - 1e-9 &&
           std::abs(loop.symmetry_at - along * options.symmetry->offset) <= 1e-6 * diagonal;
}

std::vector<std::string> what_remains(const Checkup& after, const RepairOptions& o, int refused_fills) {
    std::vector<std::string> list;
    const TopologyFacts& f = after.facts;
    const auto add = [&](std::size_t count, const char* what, bool asked, const char* option, const std::string& why) {
        if (count > 0)
            list.push_back(
                text(count, " ", what, ": ", asked ? why : text("not requested; ", option, " may repair it")));
    };
    loops_that_remain(after, o, refused_fills, list);
    add(after.crack_vertices.size(), "vertices at cracks", o.cracks.has_value(), "--cracks",
        text("the tolerance is too small, the two sides belong to one triangle, ",
             o.split ? "--split parted them, " : "", "or joined they would leave no orientation"));
    if (!f.orientable)
        list.push_back(
            text("not orientable, like a Moebius strip: no orientation of the triangles makes all neighbours "
                 "agree (",
                 f.misoriented_edges.size(), " edges); cut it open or mend it by hand"));
    else if (!f.misoriented_edges.empty())
        add(f.misoriented_edges.size(), "edges whose triangles disagree", o.orient, "--orient",
            place(after, f.misoriented_edges));
    if (!f.nonmanifold_edges.empty())
        add(f.nonmanifold_edges.size(), "edges of more than two triangles", o.split, "--split",
            text("the parts that meet there are also connected at both ends; ", place(after, f.nonmanifold_edges),
                 "; shell: {nonmanifold: couple} deforms it as it is"));
    add(f.nonmanifold_vertices.size(), "non-manifold vertices", o.split, "--split",
        "their edges have more than two triangles");
    add(f.duplicate_triangles.size(), "duplicate triangles", o.duplicates, "--duplicates", "made by another repair");
    add(f.degenerate_triangles.size(), "triangles of zero area", o.degenerate, "--degenerate",
        text("removing them would join separate parts, first triangle ",
             f.degenerate_triangles.empty() ? 0 : f.degenerate_triangles[0], "; strake remesh may"));
    add(after.inverted_triangles.size(), "triangles folded over", true, "",
        "no repair unfolds them; strake remesh may");
    if (after.pairs)
        add(after.pairs->apart.size() + after.pairs->adjacent.size(), "pairs of triangles intersect", true, "",
            "no repair removes intersections; unite the parts in a modeller, or leave them as separate components");
    return list;
}

}  // namespace strake::mending

namespace strake {

std::string repair_csv(const RepairResult& result) {
    std::string csv = "kind,vertex,triangle,x,y,z,size,triangles,words\n";
    const auto number = [](int i) { return i < 0 ? std::string() : std::to_string(i); };
    for (const RepairItem& item : result.items) {
        csv += name_of(item.kind) + "," + number(item.vertex) + "," + number(item.triangle) + ",";
        for (const double value : {item.at.x(), item.at.y(), item.at.z(), item.size}) {
            formats::append(csv, value);
            csv += ',';
        }
        csv += std::to_string(item.triangles) + ",\"" + item.words + "\"\n";
    }
    return csv;
}

}  // namespace strake
