#include "core/planform/find_wings.hpp"

#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace strake {
namespace {

using Eigen::Vector3d;

constexpr int num_steps = 160;           ///< over the whole extent
constexpr double max_thickness = 0.30;   ///< of the chord, of one section
constexpr double mean_thickness = 0.22;  ///< of the chord, of the wing
constexpr double plate_share = 0.75;     ///< thickness at 5 % or 95 % of the chord over the largest: not a plate
constexpr double max_change = 0.30;      ///< of the chord from one section to the next
constexpr double min_aspect_ratio = 1.0;
constexpr double max_camber = 0.12;  ///< of the chord: blades of turbines have more
constexpr double tip_share = 0.04;   ///< of half the extent: roundings are passed over
constexpr double late_share = 0.2;   ///< of the extent: a winglet, which planes normal to the span cut along
constexpr double max_twist = 0.5;    ///< radians
constexpr double end_rel = 1e-4;     ///< of the extent: open edges in the plane of symmetry
constexpr double hung_share = 0.15;  ///< of the exposed semispan: closed parts that are shorter hang on the wing
constexpr int min_sections = 12;

struct Ways {
    Vector3d span, downstream, up;
};

struct Range {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    void add(double x) { low = std::min(low, x), high = std::max(high, x); }
    double size() const { return high - low; }
    double overlap(const Range& other) const { return std::min(high, other.high) - std::max(low, other.low); }
};

/// An outline and its extents.
struct Loop {
    Outline outline;
    Range x, z;
};

/// One section that was followed.
struct Followed {
    double at = 0, chord = 0, thickness = 0;
    double front = 0, rear = 0;  ///< thickness at 5 % and 95 % of the chord
    Range x, z;
};

class Follower {
public:
    Follower(const TriMesh& mesh, const Ways& ways) : mesh_(mesh), ways_(ways) {
        const auto along = [&](int v) { return ways.span.dot(mesh.vertices.row(v)); };
        for (const int v : mesh.triangles.reshaped()) extent_.add(along(v));
        for (int t = 0; extent_.size() > 0 && t < mesh.num_triangles(); ++t) {
            Range y;
            for (const int v : mesh.triangles.row(t)) y.add(along(v));
            for (std::size_t k = slab(y.low); k <= slab(y.high); ++k) slabs_[k].push_back(t);
        }
    }
    const Range& extent() const { return extent_; }

    /// Sections from the tip on the positive or negative side inwards, up to the last that belongs to the wing.
    /// @param is_late from where enough of them follow each other; else from the tip itself
    std::vector<Followed> follow(int sign, bool is_late = false) const {
        const double tip = sign > 0 ? extent_.high : -extent_.low, step = extent_.size() / num_steps;
        const double first = tip - 0.5 * tip_share * extent_.size(), last = tip - late_share * extent_.size();
        std::vector<Followed> found;
        for (double from = first; found.size() < min_sections && from > (is_late ? last : first - step); from -= step) {
            found.clear();
            for (double at = from; at > tip - extent_.size() + 0.5 * step; at -= step) {
                const auto next = section(sign, at, found.empty() ? nullptr : &found.back());
                if (!next) break;
                found.push_back(*next);
            }
        }
        refine_root(sign, step, found);
        return found;
    }

private:
    std::size_t slab(double y) const {
        const double k = std::floor((y - extent_.low) / extent_.size() * num_steps);
        return static_cast<std::size_t>(std::clamp(k, 0.0, num_steps - 1.0));
    }
    std::vector<Loop> loops(int sign, double at) const {
        const SectionFrame frame{sign * ways_.span, ways_.downstream, ways_.up, at};
        std::vector<Loop> found;
        for (Outline& outline : cut(mesh_, slabs_[slab(sign * at)], frame, {false, 2e-3 * extent_.size()})) {
            Loop loop{std::move(outline), {}, {}};
            for (const PlanePoint& p : loop.outline.points) loop.x.add(p.x.value), loop.z.add(p.z.value);
            found.push_back(std::move(loop));
        }
        return found;
    }
    /// The main outline (the longest at the tip, then the one that overlaps its predecessor most), and elements before
    /// and behind it.
    static std::vector<Loop> airfoil_of(std::vector<Loop> all, const Followed* before) {
        std::size_t main = 0;
        double best = -std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < all.size(); ++i) {
            double score = all[i].x.size();
            if (before) {
                const double off = std::max(0.0, -all[i].z.overlap(before->z));
                score = all[i].x.overlap(before->x) - 3 * off;
            }
            if (score > best) best = score, main = i;
        }
        std::vector<Loop> chosen{all[main]};
        Range x = all[main].x, z = all[main].z;
        for (bool grows = true; grows;) {
            grows = false;
            for (std::size_t i = 0; i < all.size(); ++i) {
                const Loop& other = all[i];
                const bool is_in = std::any_of(chosen.begin(), chosen.end(), [&](const Loop& c) {
                    return c.x.low == other.x.low && c.z.low == other.z.low;
                });
                if (is_in || other.x.size() <= 0) continue;
                const double overlap = x.overlap(other.x), near_z = z.overlap(other.z);
                if (overlap < -0.08 * x.size() || overlap > 0.4 * other.x.size() || near_z < -0.08 * x.size()) continue;
                chosen.push_back(other);
                x.add(other.x.low), x.add(other.x.high), z.add(other.z.low), z.add(other.z.high);
                grows = true;
            }
        }
        return chosen;
    }
    /// All elements together, or the main one alone where they make no airfoil (a flap far down).
    std::optional<Followed> section(int sign, double at, const Followed* before) const {
        std::vector<Loop> all = loops(sign, at);
        if (all.empty()) return {};
        std::vector<Loop> chosen = airfoil_of(std::move(all), before);
        auto found = measured(at, chosen, before);
        if (!found && chosen.size() > 1) found = measured(at, {chosen.front()}, before);
        return found;
    }
    static std::optional<Followed> measured(double at, const std::vector<Loop>& chosen, const Followed* before) {
        std::vector<Outline> outlines;
        Followed found;
        found.at = at;
        for (const Loop& loop : chosen) {
            found.x.add(loop.x.low), found.x.add(loop.x.high), found.z.add(loop.z.low), found.z.add(loop.z.high);
            outlines.push_back(loop.outline);
        }
        if (before && !(found.x.overlap(before->x) > 0.4 * before->x.size())) return {};
        const auto airfoil = Airfoil::from(std::move(outlines));
        if (!airfoil || std::abs(airfoil->twist().value) > max_twist) return {};
        found.chord = airfoil->chord().value;
        found.thickness = airfoil->max_thickness().value;
        if (!(found.thickness > 1e-3 && found.thickness < max_thickness)) return {};
        if (before && std::abs(found.chord - before->chord) > max_change * before->chord) return {};
        try {
            found.front = airfoil->thickness(0.05).value / found.chord;
            found.rear = airfoil->thickness(0.95).value / found.chord;
        } catch (const InvalidInput&) {
            return {};
        }
        if (std::min(found.front, found.rear) > plate_share * found.thickness) return {};
        return found;
    }
    /// The border to a body, by bisection.
    void refine_root(int sign, double step, std::vector<Followed>& found) const {
        if (found.size() < 2) return;
        for (int k = 0; k < 6; ++k) {
            step /= 2;
            if (const auto next = section(sign, found.back().at - step, &found.back())) found.push_back(*next);
        }
    }

    const TriMesh& mesh_;
    Ways ways_;
    Range extent_;
    std::array<std::vector<int>, num_steps> slabs_;  ///< triangles that reach into each slab along the span
};

/// Whether the triangle lies in one of the sections.
bool is_in(const TriMesh& mesh, int t, const Ways& ways, int sign, const std::vector<Followed>& sections) {
    Range y, x, z;
    for (const int v : mesh.triangles.row(t)) {
        const Vector3d p = mesh.vertices.row(v);
        y.add(sign * ways.span.dot(p)), x.add(ways.downstream.dot(p)), z.add(ways.up.dot(p));
    }
    for (std::size_t k = 0; k < sections.size(); k += 8) {
        const Followed& at = sections[k];
        const double slack = 1e-6 * at.x.size();
        const bool is_cut = at.at >= y.low && at.at <= y.high;
        if (is_cut && x.low >= at.x.low - slack && x.high <= at.x.high + slack && z.overlap(at.z) >= 0) return true;
    }
    return false;
}

/// Marks the triangles beyond `root` that are connected to the sections. Those that cross the root's plane belong to
/// the wing where they are cut within its section there: a coarse mesh has no row of vertices along the joint.
class Flood {
public:
    Flood(const TriMesh& mesh, const Adjacency& adjacent, const Ways& ways, bool with_crossing,
          std::vector<char>& marks)
        : mesh_(mesh), adjacent_(adjacent), ways_(ways), with_crossing_(with_crossing), marks_(marks) {}

    void run(int sign, double root, const std::vector<Followed>& sections) {
        std::vector<char> beyond(static_cast<std::size_t>(mesh_.num_triangles()), 0);
        std::vector<int> seeds;
        for (int t = 0; t < mesh_.num_triangles(); ++t) {
            const auto i = static_cast<std::size_t>(t);
            double low = std::numeric_limits<double>::infinity();
            for (const int v : mesh_.triangles.row(t)) low = std::min(low, sign * at(v, ways_.span));
            beyond[i] = low >= root || (with_crossing_ && is_cut_in(t, sign, root, sections.back()));
            if (beyond[i] && is_in(mesh_, t, ways_, sign, sections)) seeds.push_back(t);
        }
        const double reach = sections.front().at - root;
        std::vector<int> hung;
        for (const int t : seeds) {
            if (marks_[static_cast<std::size_t>(t)]) continue;
            const std::vector<int> piece = connected(t, beyond);
            if (is_hung(piece, reach)) hung.insert(hung.end(), piece.begin(), piece.end());
        }
        for (const int t : hung) marks_[static_cast<std::size_t>(t)] = 0;
    }

private:
    double at(int v, const Vector3d& way) const { return way.dot(mesh_.vertices.row(v)); }

    bool is_cut_in(int t, int sign, double root, const Followed& section) const {
        Range x, z;
        for (int k = 0; k < 3; ++k) {
            const int a = mesh_.triangles(t, k), b = mesh_.triangles(t, (k + 1) % 3);
            const double from = sign * at(a, ways_.span) - root, to = sign * at(b, ways_.span) - root;
            if ((from < 0) == (to < 0)) continue;
            const auto cut = [&](const Vector3d& way) { return (to * at(a, way) - from * at(b, way)) / (to - from); };
            x.add(cut(ways_.downstream)), z.add(cut(ways_.up));
        }
        const double slack = 1e-3 * section.x.size();
        return x.size() >= 0 && x.low >= section.x.low - slack && x.high <= section.x.high + slack &&
               z.low >= section.z.low - slack && z.high <= section.z.high + slack;
    }
    std::vector<int> connected(int seed, const std::vector<char>& beyond) {
        std::vector<int> piece{seed};
        marks_[static_cast<std::size_t>(seed)] = 1;
        for (std::size_t i = 0; i < piece.size(); ++i)
            for (int k = 0; k < 3; ++k) {
                const auto beside = adjacent_.edge_triangles[adjacent_.triangle_edges(piece[i], k)];
                if (beside.size() > 2) continue;  // a wake hangs at an edge of three
                for (const int other : beside) {
                    const auto o = static_cast<std::size_t>(other);
                    if (marks_[o] || !beyond[o]) continue;
                    marks_[o] = 1;
                    piece.push_back(other);
                }
            }
        return piece;
    }
    /// A short closed part of its own: a nacelle or a tank.
    bool is_hung(const std::vector<int>& piece, double reach) const {
        Range y;
        for (const int t : piece) {
            for (const int v : mesh_.triangles.row(t)) y.add(at(v, ways_.span));
            for (int k = 0; k < 3; ++k) {
                const auto beside = adjacent_.edge_triangles[adjacent_.triangle_edges(t, k)];
                if (beside.size() != 2) return false;
                for (const int other : beside)
                    if (!marks_[static_cast<std::size_t>(other)]) return false;
            }
        }
        return y.size() < hung_share * reach;
    }

    const TriMesh& mesh_;
    const Adjacency& adjacent_;
    const Ways& ways_;
    bool with_crossing_;
    std::vector<char>& marks_;
};

struct Candidate {
    FoundWing wing;
    double area = 0;
    double root_off = 0;       ///< beside a body
    bool begins_open = false;  ///< followed from where half a body is open, up to what may be a winglet
};

bool is_enough(const std::vector<Followed>& sections) {
    if (sections.size() < min_sections) return false;
    double mean = 0;
    for (const Followed& at : sections) mean += at.thickness / static_cast<double>(sections.size());
    return mean < mean_thickness;
}

/// The nose is the blunter end.
bool is_reversed(const std::vector<Followed>& sections) {
    double front = 0, rear = 0;
    for (const Followed& at : sections) front += at.front, rear += at.rear;
    return front < rear;
}

/// Coordinate (along the side's own way) where the wing ends at a body; the other end of the surface without one.
double root_of(const Follower& follower, int sign, const std::vector<Followed>& side, bool has_both) {
    const Range& extent = follower.extent();
    const double end = sign > 0 ? extent.low : -extent.high, last = side.back().at;
    const double middle = sign * 0.5 * (extent.low + extent.high);
    if (last - end < 0.02 * extent.size()) return end;                 // all of it
    if (has_both && last < middle + 0.01 * extent.size()) return end;  // both sides meet
    return last;
}

/// The marked triangles; none where all are.
std::vector<int> listed(const std::vector<char>& marks) {
    std::vector<int> found;
    for (std::size_t t = 0; t < marks.size(); ++t)
        if (marks[t]) found.push_back(static_cast<int>(t));
    if (found.size() == marks.size()) found.clear();
    return found;
}

/// Measures it; false where it has not the proportions of a wing. Where a surface has open edges, stations at a gap in
/// the outline are left out.
/// @param is_late it has to have a winglet, where the sections were not followed from its tip
bool is_wing(const TriMesh& mesh, bool is_open, bool is_late, std::size_t num_sections, Candidate& found) {
    try {
        const Wing wing(mesh, found.wing.declaration);
        if (is_late && !wing.has_winglet()) return false;
        const WingFacts facts = wing.facts(mesh);
        found.area = facts.area.value;
        found.wing.why = text(num_sections, " thin sections in a row, aspect ratio ",
                              std::round(100 * facts.aspect_ratio.value) / 100);
        const auto is_flat = [&](double at) {
            const auto airfoils = wing.sections(mesh, at);
            return std::abs(airfoils.front().max_camber().value) <= max_camber;
        };
        if (!(facts.aspect_ratio.value > min_aspect_ratio && is_flat(0.5))) return false;
        std::vector<double> measured;
        for (const double at : wing.stations()) try {
                if (std::abs(wing.station(mesh, at).camber.value) > max_camber) return false;
                measured.push_back(at);
            } catch (const InvalidInput&) {
                if (!is_open) return false;
            }
        if (measured.size() < 2 || 2 * measured.size() < wing.stations().size()) return false;
        if (measured.size() < wing.stations().size()) found.wing.declaration.stations = measured;
        return true;
    } catch (const InvalidInput&) {
        return false;
    }
}

/// The plane at an end of the extent where the surface is open: it is half a body. Of a wing alone its root.
std::optional<SymmetryPlane> open_end(const TriMesh& mesh, const Adjacency& adjacent, const Vector3d& span,
                                      const Range& extent) {
    std::array<int, 2> open{};
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (adjacent.edge_triangles[e].size() != 1) continue;
        const auto [a, b] = adjacent.edges[static_cast<std::size_t>(e)];
        const double ya = span.dot(mesh.vertices.row(a)), yb = span.dot(mesh.vertices.row(b));
        open[0] += std::max(ya, yb) <= extent.low + end_rel * extent.size();
        open[1] += std::min(ya, yb) >= extent.high - end_rel * extent.size();
    }
    if ((open[0] > 2) == (open[1] > 2)) return {};
    return SymmetryPlane{span, open[0] > 2 ? extent.low : extent.high};
}

/// How far the root that triangles make is from where the sections end at the body.
double root_off(const TriMesh& mesh, const FoundWing& found, const Vector3d& outboard) {
    const Wing wing(mesh, found.declaration);
    double off = std::numeric_limits<double>::infinity();
    for (int side = 0; side < wing.num_sides(); ++side)
        if (wing.span(side).dot(outboard) > 0) off = std::abs(wing.root(side) - found.root);
    return off;
}

bool has_open_edges(const Adjacency& adjacent) {
    for (int e = 0; e < adjacent.num_edges(); ++e)
        if (adjacent.edge_triangles[e].size() == 1) return true;
    return false;
}

/// What was followed from both tips.
struct Trace {
    const TriMesh& mesh;
    const Adjacency& adjacent;
    const WingSearch& search;
    const Ways& ways;
    const Follower& follower;
    const std::array<std::vector<Followed>, 2>& sides;
    bool is_late;
};

/// Nothing where it makes no wing. @param with_crossing as of `Flood`
std::optional<Candidate> marked(const Trace& of, bool with_crossing) {
    Candidate found;
    std::vector<char> marks(static_cast<std::size_t>(of.mesh.num_triangles()), 0);
    const bool has_both = !of.sides[0].empty() && !of.sides[1].empty();
    int last = 0;
    for (const int sign : {-1, 1}) {
        const auto& side = of.sides[sign > 0 ? 0 : 1];
        if (side.empty()) continue;
        const double end = sign > 0 ? of.follower.extent().low : -of.follower.extent().high;
        const double root = root_of(of.follower, sign, side, has_both);
        if (root > end) found.wing.has_body = true, found.wing.root = root;
        Flood(of.mesh, of.adjacent, of.ways, with_crossing, marks).run(sign, root, side);
        last = sign;
    }
    WingDeclaration& declared = found.wing.declaration;
    declared.span = of.ways.span, declared.downstream = of.ways.downstream, declared.up = of.ways.up;
    declared.symmetry = of.search.symmetry;
    if (!declared.symmetry && found.wing.has_body)
        declared.symmetry = open_end(of.mesh, of.adjacent, of.ways.span, of.follower.extent());
    const Range& extent = of.follower.extent();
    found.begins_open = declared.symmetry && !has_both &&
                        std::abs(declared.symmetry->offset * declared.symmetry->normal.dot(of.ways.span) -
                                 (last > 0 ? extent.high : extent.low)) <= end_rel * extent.size();
    declared.triangles = listed(marks);
    const std::size_t count = of.sides[0].size() + of.sides[1].size();
    if (!is_wing(of.mesh, has_open_edges(of.adjacent), of.is_late, count, found)) return {};
    if (found.wing.has_body) found.root_off = root_off(of.mesh, found.wing, last * of.ways.span);
    return found;
}

/// @param is_late as of `Follower::follow`, on both sides
std::optional<Candidate> candidate(const TriMesh& mesh, const Adjacency& adjacent, const WingSearch& search, Ways ways,
                                   bool is_late = false) {
    const Follower follower(mesh, ways);
    if (!(follower.extent().size() > 0)) return {};
    std::array<std::vector<Followed>, 2> sides{follower.follow(1, is_late), follower.follow(-1, is_late)};
    for (auto& side : sides)
        if (!is_enough(side)) side.clear();
    // The root's end of half a body may begin like a tip.
    const std::size_t few = sides[0].size() < sides[1].size() ? 0 : 1;
    if (sides[few].size() < sides[1 - few].size() / 2) sides[few].clear();
    if (sides[0].empty() && sides[1].empty()) return {};
    if (!search.downstream && is_reversed(sides[0].empty() ? sides[1] : sides[0])) {
        ways.downstream = -ways.downstream;
        return candidate(mesh, adjacent, {ways.downstream, ways.up, search.symmetry}, ways, is_late);
    }
    std::optional<Candidate> best = marked({mesh, adjacent, search, ways, follower, sides, is_late}, false);
    if (!best || !best->wing.has_body) return best;
    std::optional<Candidate> other = marked({mesh, adjacent, search, ways, follower, sides, is_late}, true);
    return other && other->root_off < best->root_off ? other : best;
}

}  // namespace

std::optional<FoundWing> find_wing(const TriMesh& mesh, const WingSearch& search) {
    const Adjacency adjacent = adjacency(mesh);
    std::vector<Ways> tried;
    if (search.downstream && search.up) {
        tried.push_back({search.up->cross(*search.downstream), *search.downstream, *search.up});
    } else {
        const std::array<Vector3d, 3> axes{Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
        for (const int span : {1, 2, 0})
            for (const int along : {0, 1, 2})
                if (along != span)
                    tried.push_back({axes[static_cast<std::size_t>(span)], axes[static_cast<std::size_t>(along)],
                                     axes[static_cast<std::size_t>(3 - span - along)]});
    }
    std::optional<Candidate> best;
    for (const Ways& ways : tried) {
        auto one = candidate(mesh, adjacent, search, ways);
        if (!one || one->begins_open)
            if (auto late = candidate(mesh, adjacent, search, ways, true)) one = std::move(late);
        if (one && (!best || one->area > best->area)) best = std::move(one);
    }
    if (!best) return {};
    return std::move(best->wing);
}

}  // namespace strake
