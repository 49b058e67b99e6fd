#include "casefile/build/prepare_surface.hpp"
#include "casefile/build/problem_builder.hpp"
#include "casefile/build/surface_check.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/triangle_box.hpp"
#include "core/patches/automatic.hpp"
#include "core/patches/carried.hpp"
#include "core/patches/mirrored.hpp"
#include "core/patches/segmentation.hpp"
#include "core/repair/checkup.hpp"
#include "optimize/run/stored_design.hpp"
#include "optimize/space/mirror.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace strake {
namespace {

/// The key that moves a cut onto the plane, where it is near. @param off of the edge nearest to the plane, diagonals.
std::string snap_remedy(double off) {
    constexpr double near = 1e-2;
    if (!(off <= near)) return "";
    const double percent = std::pow(10, std::ceil(std::log10(200 * off)));
    return text("; the nearest one is ", 100 * off, " % of the diagonal away: symmetry: {snap: ", percent,
                "%} moves open edges so near to the plane onto it");
}

}  // namespace

void ProblemBuilder::read_start() {
    PreparedSurface prepared = prepare_surface(case_);
    out_.format = prepared.format;
    out_.is_prepared = prepared.is_changed;
    out_.repairs_csv = std::move(prepared.repairs_csv);
    out_.notes = std::move(prepared.notes);
    for (std::string& words : prepared.warnings) out_.warnings.push_back(std::move(words));
    start_.mesh = std::move(prepared.mesh);
    start_.file_triangles = prepared.file_triangles;
    start_.is_remeshed = prepared.is_remeshed;
    start_.source_triangle = std::move(prepared.source_triangle);
    start_.adjacent = adjacency(start_.mesh);
    start_.area = triangle_areas(start_.mesh);
    start_.diagonal = box_diagonal(start_.mesh);
    check_symmetry_plane();
    errors_.throw_if_any();
    SurfaceDemands demands{!case_.has_shell || case_.wrap, case_.couple_nonmanifold, false, case_.symmetry};
    if (purpose_ != Purpose::deform)
        for (const QuantityEntry& quantity : case_.quantities)
            demands.volume |= std::holds_alternative<VolumeEntry>(quantity.what);
    check_surface(case_.surface, start_, demands);
    if (case_.symmetry || purpose_ == Purpose::deform) return;
    const auto loops = topology(start_.mesh, start_.adjacent).boundary_loops;
    if (loops.empty()) return;
    const auto plane = cut_of_half(start_.mesh, start_.adjacent, measured_loops(start_.mesh, start_.adjacent, loops));
    if (plane) out_.notes.push_back(half_words(*plane));
}

/// A half model ends on the plane, with open edges.
void ProblemBuilder::check_symmetry_plane() {
    if (!case_.symmetry) return;
    const SymmetryPlane& plane = *case_.symmetry;
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest, nearest = lowest;
    for (int e = 0; e < start_.adjacent.num_edges(); ++e) {
        if (start_.adjacent.edge_triangles[e].size() != 1) continue;
        const auto [a, b] = start_.adjacent.edges[e];
        const double one = plane.normal.dot(start_.mesh.vertices.row(a)) - plane.offset,
                     other = plane.normal.dot(start_.mesh.vertices.row(b)) - plane.offset;
        if (std::max(std::abs(one), std::abs(other)) <= 1e-6 * start_.diagonal) return;
        lowest = std::min({lowest, one, other});
        highest = std::max({highest, one, other});
        nearest = std::min(nearest, std::max(std::abs(one), std::abs(other)));
    }
    const Eigen::Vector3d& n = plane.normal;
    const std::string shown = text("symmetry: no open edge on the symmetry plane with normal (", n[0], ", ", n[1], ", ",
                                   n[2], ") at ", plane.offset, " (both ends within 1e-6 of the diagonal)");
    if (highest < lowest)
        errors_.add(case_.symmetry_place, shown + ": the surface is closed; remove symmetry for a full model");
    else
        errors_.add(case_.symmetry_place,
                    text(shown, ": the open edges of the half lie between ", plane.offset + lowest, " and ",
                         plane.offset + highest, " along that normal", snap_remedy(nearest / start_.diagonal)));
}

const std::optional<SymmetryPlane>& ProblemBuilder::start_plane() {
    if (!plane_) plane_ = plane_of_symmetry(start_.mesh);
    return *plane_;
}

Split ProblemBuilder::split() {
    const SplitEntry& entry = case_.parameters.split;
    if (entry.kind == SplitEntry::Kind::largest) return SplitLargest{entry.largest};
    if (entry.kind != SplitEntry::Kind::containing) return SplitAll{};  // by sensitivity: the run chooses among all
    SplitContaining containing;
    const ClosestPointTree closest(elastic().mesh);
    for (const auto& [what, place] : entry.containing) {
        const int* number = std::get_if<int>(&what);
        const int t = number ? *number : closest.find(std::get<NearPoint>(what).point).triangle;
        if (number && t < start_.mesh.num_triangles())
            containing.triangles.push_back(wrap_ ? wrap_triangle_[static_cast<std::size_t>(t)] : t);
        else if (!number)
            containing.triangles.push_back(t);
        else
            errors_.add(place, text("parameters.split.containing: triangle ", t, " must be below ",
                                    start_.mesh.num_triangles()));
    }
    return containing;
}

/// Before the tree is used: regions may name its patches.
void ProblemBuilder::read_stored() {
    if (!case_.start_from || purpose_ == Purpose::deform) return;
    const std::string shown = text("optimize.start_from = ", printable(case_.start_from->string(), 400), ": ");
    const std::filesystem::path file = *case_.start_from / "levels" / "best.design";
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) {
        const bool is_folder = std::filesystem::is_directory(*case_.start_from, ignored);
        errors_.add(case_.start_place, shown + (is_folder ? "no design is stored there (levels/best.design): not the "
                                                            "folder of a run, or of one that found no design"
                                                          : "there is no such folder"));
        return;
    }
    try {
        auto design = std::make_shared<StoredDesign>(read_design(file));
        check_surface(*design, start_.mesh);
        check_elastic(*design, elastic().mesh.num_triangles());
        stored_ = std::move(design);
        if (!has_levels_of(out_.problem.tree, *stored_)) {
            out_.problem.tree = stored_->tree;
            if (wrap_) start_tree_ = carried(stored_->tree, wrap_triangle_, start_.mesh);
        }
    } catch (const InputError& refused) {
        errors_.add(case_.start_place, text("optimize.start_from: ", refused.what()));
    } catch (const InvalidInput& refused) {
        errors_.add(case_.start_place, shown + refused.what());
    }
}

/// Fields need no patches: on level 1 there is again the whole.
PatchHierarchy ProblemBuilder::whole_surface() const {
    Patch all;
    all.name = "all";
    all.triangles.resize(static_cast<std::size_t>(start_.mesh.num_triangles()));
    std::iota(all.triangles.begin(), all.triangles.end(), 0);
    all.area = start_.area.sum();
    PatchLevel level;
    level.label.assign(all.triangles.size(), 0);
    level.patches.push_back(std::move(all));
    PatchLevel next = level;
    next.patches[0].parent = 0;
    return {{std::move(level), std::move(next)}};
}

void ProblemBuilder::build_tree() {
    if (purpose_ == Purpose::deform && !needs_patches(case_, start_.mesh)) return;
    const ParameterEntry& p = case_.parameters;
    PatchHierarchy& tree = out_.problem.tree;
    if (!case_.has_shell && p.levels_deg.empty() && !p.patches_are_stated && !wants_patches_ &&
        !needs_patches(case_, start_.mesh)) {
        tree = whole_surface();
        return;
    }
    if (!p.levels_deg.empty()) {
        tree = segment(elastic().mesh, elastic().adjacent, p.levels_deg,
                       {p.sharp_angle_deg, p.min_patch_percent, split()});
    } else {
        AutomaticLevels automatic;
        if (!p.patches_per_level.empty()) automatic.patches_per_level = p.patches_per_level;
        automatic.sharp_angle_deg = p.sharp_angle_deg;
        automatic.split = split();
        tree = segment_automatically(elastic().mesh, elastic().adjacent, automatic);
    }
    if (p.mirror)
        if (const auto plane = wrap_ ? plane_of_symmetry(wrap_->mesh)
                                     : start_plane())  // without one `set_parameters` reports an error
            tree = mirrored(tree, elastic().mesh, elastic().adjacent, *plane);
    if (wrap_) start_tree_ = carried(tree, wrap_triangle_, start_.mesh);
}

void ProblemBuilder::evaluate_regions() {
    const WingSetup setup{case_.planform, case_.aero.axes.value_or(BodyAxes{}), case_.symmetry};
    RegionSets sets(case_.regions, start_, tree_on_surface(), &setup);
    for (const WingEntry& entry : case_.planform)
        at(entry.place, text("planform.", entry.name, ": "), [&] {
            wings_[entry.name] = sets.wing(entry.name);
            out_.wings.push_back(wings_[entry.name]);
        });
    for (const FuselageEntry& entry : case_.bodies)
        at(entry.place, text("planform.", entry.name, ": "), [&] {
            FuselageDeclaration declared{entry.name, {}, entry.length, setup.axes.up, case_.symmetry};
            if (!entry.stations.empty()) declared.stations = entry.stations;
            const std::vector<char> marks = entry.on ? sets.marks_of(entry.on->name) : std::vector<char>();
            for (std::size_t t = 0; t < marks.size(); ++t)
                if (marks[t]) declared.triangles.push_back(static_cast<int>(t));
            if (entry.on && declared.triangles.empty())
                throw InvalidInput(text("'", printable(entry.on->name), "' holds no triangles"));
            bodies_[entry.name] = std::make_shared<const Fuselage>(start_.mesh, declared);
            out_.bodies.push_back(bodies_[entry.name]);
        });
    for (std::size_t k = 0; k < case_.regions.size(); ++k)
        at(case_.regions[k].shape_place, "", [&] {
            const Region& region = case_.regions[k];
            RegionTriangles found;
            found.name = region.name;
            found.triangles = sets.triangles(static_cast<int>(k));
            for (const int t : found.triangles) found.area += start_.area[t];
            found.box = triangle_box(start_.mesh, found.triangles);
            region_index_[region.name] = static_cast<int>(out_.regions.size());
            out_.regions.push_back(std::move(found));
        });
}

}  // namespace strake
