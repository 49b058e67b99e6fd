#include "casefile/build/surface_check.hpp"

#include "core/mesh/topology.hpp"
#include "objectives/quantity/closed.hpp"

#include <functional>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

namespace strake {
namespace {

constexpr double crack_rel = 1e-5;  ///< of the diagonal: closer open edges are one edge that was not welded

bool is_open(const Adjacency& adjacent, int e) { return adjacent.edge_triangles[e].size() == 1; }

/// For every end of an open edge the smallest vertex number of its cluster of points closer than `reach`.
std::map<int, int> clusters(const StartSurface& start, double reach) {
    std::map<int, int> parent;
    for (int e = 0; e < start.adjacent.num_edges(); ++e)
        if (is_open(start.adjacent, e))
            for (const int v : start.adjacent.edges[e]) parent[v] = v;
    const std::function<int(int)> root = [&](int v) { return parent[v] == v ? v : parent[v] = root(parent[v]); };
    using Cell = std::array<long long, 3>;
    std::map<Cell, std::vector<int>> cells;
    const Eigen::RowVector3d origin = bounding_box(start.mesh).min.transpose();
    const auto cell_of = [&](int v) {
        const Eigen::RowVector3d x = (start.mesh.vertices.row(v) - origin) / reach;
        return Cell{std::llround(std::floor(x[0])), std::llround(std::floor(x[1])), std::llround(std::floor(x[2]))};
    };
    for (const auto& [v, self] : parent) {
        const Cell cell = cell_of(v);
        for (int k = 0; k < 27; ++k) {
            const auto near = cells.find({cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1});
            if (near == cells.end()) continue;
            for (const int w : near->second)
                if ((start.mesh.vertices.row(v) - start.mesh.vertices.row(w)).norm() <= reach) {
                    const int a = root(v), b = root(w);
                    parent[std::max(a, b)] = std::min(a, b);
                }
        }
        // A few members represent a crowd at one place: the search stays linear.
        auto& here = cells[cell];
        if (here.size() < 8) here.push_back(v);
    }
    for (auto& [v, up] : parent) up = root(v);
    return parent;
}

std::string numbers(const std::vector<int>& all) {
    std::string out;
    for (std::size_t k = 0; k < all.size() && k < 5; ++k) out += text(k ? ", " : "", all[k]);
    return all.size() > 5 ? out + ", ..." : out;
}

std::string edge_place(const StartSurface& start, int e) {
    const auto [a, b] = start.adjacent.edges[e];
    const Eigen::RowVector3d x = (start.mesh.vertices.row(a) + start.mesh.vertices.row(b)) / 2;
    return text("vertices ", a, "-", b, ", triangle ", start.adjacent.edge_triangles[e][0], ", at (", x[0], ", ", x[1],
                ", ", x[2], ")");
}

std::string plural(std::size_t count, const std::string& one, const std::string& many) {
    return text(count, " ", count == 1 ? one : many);
}

/// Open edges that are not on the symmetry plane.
std::vector<int> free_edges(const StartSurface& start, const std::optional<SymmetryPlane>& symmetry) {
    std::vector<int> open;
    const auto on_plane = [&](int v) {
        return symmetry &&
               std::abs(symmetry->normal.dot(start.mesh.vertices.row(v)) - symmetry->offset) <= 1e-6 * start.diagonal;
    };
    for (int e = 0; e < start.adjacent.num_edges(); ++e) {
        const auto [a, b] = start.adjacent.edges[e];
        if (is_open(start.adjacent, e) && !(on_plane(a) && on_plane(b))) open.push_back(e);
    }
    return open;
}

class Report {
public:
    explicit Report(const StartSurface& start) : start_(start) {}

    void triangles(const std::vector<int>& bad, const std::string& one, const std::string& many,
                   const std::string& remedy) {
        if (!bad.empty()) add(text(plural(bad.size(), one, many), " (", numbers(bad), ")"), remedy);
    }
    void edges(const std::vector<int>& bad, const std::string& one, const std::string& many,
               const std::string& remedy) {
        if (!bad.empty())
            add(text(plural(bad.size(), one, many), " (first: ", edge_place(start_, bad[0]), ")"), remedy);
    }
    void add(const std::string& what, const std::string& remedy) { lines_ += text("\n  ", what, ": ", remedy); }
    const std::string& lines() const { return lines_; }

private:
    const StartSurface& start_;
    std::string lines_;
};

void report_cracks(const StartSurface& start, Report& report) {
    const std::vector<int> cracks = cracked_edges(start);
    if (cracks.empty()) return;
    int open = 0;
    for (int e = 0; e < start.adjacent.num_edges(); ++e) open += is_open(start.adjacent, e);
    report.edges(cracks, text("of ", open, " open edges lies on another one"),
                 text("of ", open, " open edges lie on other ones"),
                 text("the surface has cracks and would come apart; join them with repair: {cracks: ",
                      crack_rel * start.diagonal, "} in the case, or strake repair --cracks"));
}

/// The line that a half model lacks, where the open edges lie in one plane.
std::string half_hint(const StartSurface& start, const std::vector<int>& open,
                      const std::optional<SymmetryPlane>& symmetry) {
    if (symmetry || open.empty()) return "";
    const std::string remedy = open_remedy(start.mesh, start.adjacent, open);
    return remedy.find("symmetry: {") == std::string::npos ? "" : remedy + "; otherwise ";
}

void report_volume(const StartSurface& start, const SurfaceDemands& demands, const TopologyFacts& facts,
                   Report& report) {
    report.edges(facts.misoriented_edges, "edge with inconsistently oriented triangles",
                 "edges with inconsistently oriented triangles",
                 "volume needs a consistent orientation; add repair: {orient: true}, or do not use volume");
    const std::vector<int> open = free_edges(start, demands.symmetry);
    report.edges(open, text("open edge", demands.symmetry ? " off the symmetry plane" : ""),
                 text("open edges", demands.symmetry ? " off the symmetry plane" : "", " in ",
                      plural(facts.boundary_loops.size(), "boundary loop", "boundary loops")),
                 text("volume needs a closed surface; ", half_hint(start, open, demands.symmetry),
                      "close the holes (repair: {holes: SIZE}), or do not use volume"));
}

}  // namespace

std::vector<int> cracked_edges(const StartSurface& start) {
    if (!(start.diagonal > 0)) return {};
    const std::map<int, int> cluster = clusters(start, crack_rel * start.diagonal);
    std::map<std::array<int, 2>, std::vector<int>> by_ends;
    for (int e = 0; e < start.adjacent.num_edges(); ++e) {
        if (!is_open(start.adjacent, e)) continue;
        const auto [a, b] = start.adjacent.edges[e];
        const int ca = cluster.at(a), cb = cluster.at(b);
        if (ca != cb) by_ends[{std::min(ca, cb), std::max(ca, cb)}].push_back(e);
    }
    std::vector<int> cracked;
    for (const auto& [ends, edges] : by_ends)
        if (edges.size() > 1) cracked.insert(cracked.end(), edges.begin(), edges.end());
    std::sort(cracked.begin(), cracked.end());
    return cracked;
}

void check_surface(const std::filesystem::path& file, const StartSurface& start, const SurfaceDemands& demands) {
    const std::string name = printable(file.string(), 400);
    if (start.mesh.num_triangles() == 0) throw SurfaceRefused(text(name, ": the surface has no triangles"));
    if (!(start.diagonal > 0) || !(start.area.sum() > 0)) throw SurfaceRefused(text(name, ": the surface has no area"));
    if (demands.any) return;
    const TopologyFacts facts = topology(start.mesh, start.adjacent);
    Report report(start);
    report.triangles(
        facts.degenerate_triangles, "triangle of zero area", "triangles of zero area",
        "area below 1e-14 of the diagonal squared, or a repeated vertex; remove them with repair: {degenerate: "
        "true} in the case, or strake repair --degenerate");
    report.triangles(facts.duplicate_triangles, "triangle given twice", "triangles given twice",
                     "remove the copies with repair: {duplicates: true} in the case, or strake repair --duplicates");
    if (!demands.couple_nonmanifold)
        report.edges(facts.nonmanifold_edges, "edge with more than two triangles", "edges with more than two triangles",
                     "add repair: {split: true}, delete inner walls, or add shell: {nonmanifold: couple}");
    report_cracks(start, report);
    if (demands.volume) report_volume(start, demands, facts, report);
    if (!report.lines().empty())
        throw SurfaceRefused(text(name, ": the surface cannot be used as it is", report.lines()));
}

}  // namespace strake
