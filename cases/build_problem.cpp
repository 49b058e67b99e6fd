#include "cases/build_problem.hpp"

#include "cases/surface_check.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/external/external.hpp"
#include "objectives/measures.hpp"
#include "objectives/target_shape.hpp"
#include "optimize/shell_setup.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace strake {
namespace {

const char* name_of(SurfaceFormat format) {
    switch (format) {
        case SurfaceFormat::stl_binary:
            return "stl";
        case SurfaceFormat::stl_ascii:
            return "stl-ascii";
        case SurfaceFormat::obj:
            return "obj";
        case SurfaceFormat::ply_ascii:
            return "ply-ascii";
        case SurfaceFormat::ply_binary:
            return "ply";
        case SurfaceFormat::off:
            return "off";
        case SurfaceFormat::tri:
            return "tri";
    }
    return "stl";
}

class Builder {
public:
    Builder(const Case& the_case, Purpose purpose)
        : case_(the_case), purpose_(purpose), errors_(diagnostics_of(the_case)) {}

    BuiltProblem build() {
        read_start();
        at(case_.parameters_place, "parameters: ", [&] { build_tree(); });
        errors_.throw_if_any();
        evaluate_regions();
        errors_.throw_if_any();
        Problem& problem = out_.problem;
        problem.name = case_.name;
        problem.symmetry = case_.symmetry;
        problem.couple_nonmanifold = case_.couple_nonmanifold;
        set_heights();
        set_pins();
        set_parameters();
        errors_.throw_if_any();
        set_springs();
        if (!case_.loads.empty()) set_tractions();
        if (purpose_ != Purpose::deform) set_goals();
        errors_.throw_if_any();
        problem.surface = std::move(start_.mesh);
        return std::move(out_);
    }

private:
    const Case& case_;
    Purpose purpose_;
    Diagnostics errors_;
    StartSurface start_;
    BuiltProblem out_;
    std::map<std::string, int> region_index_;

    /// Runs `work`; what it refuses becomes an error at `place`.
    template <class Work>
    void at(const Place& place, const std::string& prefix, const Work& work) {
        try {
            work();
        } catch (const InvalidInput& e) {
            errors_.add(place, prefix + e.what());
        }
    }

    const std::vector<int>& triangles(const Reference& region) const {
        return out_.regions[region_index_.at(region.name)].triangles;
    }

    void read_start() {
        SurfaceFile file = read_surface(case_.surface);
        out_.format = file.format;
        start_.mesh = std::move(file.mesh);
        start_.adjacent = adjacency(start_.mesh);
        start_.area = triangle_areas(start_.mesh);
        start_.diagonal = box_diagonal(start_.mesh);
        SurfaceDemands demands{case_.couple_nonmanifold, false, case_.symmetry};
        if (purpose_ != Purpose::deform)
            for (const QuantityEntry& quantity : case_.quantities)
                demands.volume |= std::holds_alternative<VolumeEntry>(quantity.what);
        check_surface(case_.surface, start_, demands);
    }

    Split split() {
        const SplitEntry& entry = case_.parameters.split;
        if (entry.kind == SplitEntry::Kind::all) return SplitAll{};
        if (entry.kind == SplitEntry::Kind::largest) return SplitLargest{entry.largest};
        SplitContaining containing;
        const ClosestPointTree closest(start_.mesh);
        for (const auto& [what, place] : entry.containing) {
            const int* number = std::get_if<int>(&what);
            const int t = number ? *number : closest.find(std::get<NearPoint>(what).point).triangle;
            if (t < start_.mesh.num_triangles())
                containing.triangles.push_back(t);
            else
                errors_.add(place, text("parameters.split.containing: triangle ", t, " must be below ",
                                        start_.mesh.num_triangles()));
        }
        return containing;
    }

    void build_tree() {
        const bool names_patch = std::any_of(case_.regions.begin(), case_.regions.end(), [](const Region& region) {
            return std::holds_alternative<PatchShape>(region.shape);
        });
        if (purpose_ == Purpose::deform && !names_patch) return;
        const ParameterEntry& p = case_.parameters;
        if (!p.levels_deg.empty()) {
            out_.problem.tree =
                segment(start_.mesh, start_.adjacent, p.levels_deg, {p.sharp_angle_deg, p.min_patch_percent, split()});
            return;
        }
        AutomaticLevels automatic;
        if (!p.patches_per_level.empty()) automatic.patches_per_level = p.patches_per_level;
        automatic.sharp_angle_deg = p.sharp_angle_deg;
        automatic.split = split();
        out_.problem.tree = segment_automatically(start_.mesh, start_.adjacent, automatic);
    }

    void evaluate_regions() {
        for (const Region& region : case_.regions)
            at(region.shape_place, "", [&] {
                RegionTriangles found{region.name, region_triangles(region, start_, out_.problem.tree)};
                for (const int t : found.triangles) found.area += start_.area[t];
                region_index_[region.name] = static_cast<int>(out_.regions.size());
                out_.regions.push_back(std::move(found));
            });
    }

    void set_heights() {
        const int m = start_.mesh.num_triangles();
        Eigen::VectorXd height = Eigen::VectorXd::Constant(m, case_.thickness.in(start_.diagonal));
        std::vector<const ThicknessEntry*> owner(m, nullptr);
        for (const ThicknessEntry& entry : case_.thickness_by_region)
            for (const int t : triangles(entry.region)) {
                if (owner[t])
                    errors_.add(entry.region.place,
                                text("shell.thickness: regions '", owner[t]->region.name, "' and '", entry.region.name,
                                     "' share triangles; only one of them can have its own thickness"));
                owner[t] = &entry;
                height[t] = entry.height.in(start_.diagonal);
            }
        out_.problem.prism_height = vertex_heights(start_.mesh, height);
        double edges = 0;
        for (const auto& [a, b] : start_.adjacent.edges)
            edges += (start_.mesh.vertices.row(a) - start_.mesh.vertices.row(b)).norm();
        const double mean = edges / start_.adjacent.num_edges();
        if (height.minCoeff() < 0.5 * mean)
            out_.warnings.push_back(text("shell.thickness: ", height.minCoeff(),
                                         " is below half of the mean edge length ", mean,
                                         "; the stiffness will depend on the triangulation"));
    }

    void set_pins() {
        std::vector<char> is_fixed(start_.mesh.num_triangles(), 0);
        for (const Reference& region : case_.fixed)
            for (const int t : triangles(region)) is_fixed[t] = 1;
        for (int t = 0; t < start_.mesh.num_triangles(); ++t)
            if (is_fixed[t]) out_.problem.fixed.push_back(t);
        std::vector<const StrainEntry*> owner(start_.mesh.num_triangles(), nullptr);
        for (const StrainEntry& strain : case_.strains) {
            const std::vector<int>& held = triangles(strain.region);
            int fixed = 0;
            for (const int t : held) {
                fixed += is_fixed[t];
                if (owner[t] && !is_fixed[t])
                    errors_.add(strain.region.place,
                                text("strains: regions '", owner[t]->region.name, "' and '", strain.region.name,
                                     "' share triangles that cannot follow both"));
                owner[t] = &strain;
            }
            if (fixed == static_cast<int>(held.size()))
                errors_.add(strain.region.place,
                            text("strains: every triangle of region '", strain.region.name, "' is fixed"));
            else if (fixed > 0)
                out_.warnings.push_back(text("strains: ", fixed, " of ", held.size(), " triangles of region '",
                                             strain.region.name, "' are fixed as well and stay fixed"));
            warn_shared_vertices(strain, held, is_fixed);
            // The fixed ones stay fixed, so they are no part of the motion.
            GivenStrain given;
            for (const int t : held)
                if (!is_fixed[t]) given.triangles.push_back(t);
            given.motion.rotation = strain.rotate;
            for (int k = 0; k < 3; ++k) given.motion.translation[k] = strain.translate[k].in(start_.diagonal);
            given.motion.about = strain.about ? *strain.about : area_centroid(start_.mesh, held);
            out_.problem.strains.push_back(std::move(given));
        }
    }

    void warn_shared_vertices(const StrainEntry& strain, const std::vector<int>& held,
                              const std::vector<char>& is_fixed) {
        std::vector<char> moved(start_.mesh.num_vertices(), 0), fixed(start_.mesh.num_vertices(), 0);
        for (const int t : held)
            if (!is_fixed[t])
                for (int k = 0; k < 3; ++k) moved[start_.mesh.triangles(t, k)] = 1;
        for (const int t : out_.problem.fixed)
            for (int k = 0; k < 3; ++k) fixed[start_.mesh.triangles(t, k)] = 1;
        int shared = 0;
        for (int v = 0; v < start_.mesh.num_vertices(); ++v) shared += moved[v] && fixed[v];
        if (shared > 0)
            out_.warnings.push_back(text("strains: region '", strain.region.name, "' shares ", shared,
                                         " vertices with fixed regions; they stay fixed"));
    }

    void set_parameters() {
        const ParameterEntry& entry = case_.parameters;
        Parameters& p = out_.problem.parameters;
        p.kinds = entry.variables;
        p.max_displacement = entry.max_displacement.is_relative_to_diagonal
                                 ? entry.max_displacement.value
                                 : entry.max_displacement.value / start_.diagonal;
        if (purpose_ == Purpose::deform) return;
        if (!entry.on.empty()) p.on.assign(start_.mesh.num_triangles(), 0);
        for (const Reference& place : entry.on)
            for (const int t : region_or_patch(place)) p.on[t] = 1;
        const bool is_search = !case_.objective.name.empty() || !case_.fit.empty();
        if (!is_search || !errors_.empty()) return;
        std::vector<char> held(start_.mesh.num_triangles(), 0);
        for (const int t : out_.problem.fixed) held[t] = 1;
        for (const GivenStrain& strain : out_.problem.strains)
            for (const int t : strain.triangles) held[t] = 1;
        for (int t = 0; t < start_.mesh.num_triangles(); ++t)
            if (!held[t] && (p.on.empty() || p.on[t])) return;
        errors_.add(case_.parameters_place,
                    text("parameters: no triangle is left for design variables; ",
                         entry.on.empty() ? "all" : "all of parameters.on", " are under fixed or strains"));
    }

    std::vector<int> region_or_patch(const Reference& reference) {
        if (const auto found = region_index_.find(reference.name); found != region_index_.end())
            return out_.regions[found->second].triangles;
        try {
            const PatchPlace place = find_patch(out_.problem.tree, reference.name);
            return out_.problem.tree.levels[place.level].patches[place.id].triangles;
        } catch (const InvalidInput& e) {
            std::vector<std::string> names;
            for (const RegionTriangles& region : out_.regions) names.push_back(region.name);
            const std::string near = nearest(reference.name, names);
            errors_.add(reference.place,
                        text("parameters.on: '", printable(reference.name), "' is not a declared region",
                             near.empty() ? "" : text(" (did you mean '", near, "'?)"), ", and ", e.what()));
        }
        return {};
    }

    /// Springs stand under the loaded region: given loads, and what may carry load variables.
    void set_springs() {
        const int m = start_.mesh.num_triangles();
        Eigen::VectorXd own = Eigen::VectorXd::Zero(m);
        std::vector<char> loaded(m, 0), has_own(m, 0);
        const Parameters& p = out_.problem.parameters;
        const bool by_variables = std::any_of(p.kinds.begin(), p.kinds.end(), [](VariableKind kind) {
            return kind == VariableKind::load || kind == VariableKind::load_normal;
        });
        const bool is_search = !case_.objective.name.empty() || !case_.fit.empty();
        if (purpose_ != Purpose::deform && is_search && by_variables)
            for (int t = 0; t < m; ++t) loaded[t] = p.on.empty() || p.on[t];
        for (const LoadEntry& load : case_.loads)
            for (const int t : triangles(load.region)) {
                loaded[t] = 1;
                if (!load.spring) continue;
                has_own[t] = 1;
                own[t] += *load.spring;
            }
        for (int t = 0; t < m; ++t)
            if (loaded[t] && !has_own[t]) own[t] = case_.spring;
        if (own.maxCoeff() > 0) out_.problem.spring_per_area = own;
    }

    void set_tractions() {
        Points& traction = out_.problem.given_traction;
        traction = Points::Zero(start_.mesh.num_triangles(), 3);
        std::optional<PrimoShell> shell;
        ShellSetup setup;
        for (const LoadEntry& load : case_.loads) {
            Eigen::Vector3d value = Eigen::Vector3d::Zero();
            if (load.traction) value = *load.traction;
            if (load.force) value = *load.force / out_.regions[region_index_.at(load.region.name)].area;
            if (load.displacement)
                at(load.place, "", [&] {
                    if (!shell) make_shell(shell, setup);
                    value = scaled_traction(load, *shell, setup);
                });
            for (const int t : triangles(load.region)) traction.row(t) += value.transpose();
        }
        // All loads zero is the same as no loads.
        if (traction.isZero(0)) traction.resize(0, 3);
    }

    /// The shell with everything but the loads.
    void make_shell(std::optional<PrimoShell>& shell, ShellSetup& setup) {
        Problem bare = out_.problem;
        bare.surface = start_.mesh;
        bare.given_traction.resize(0, 3);
        setup = shell_setup(bare);
        setup.motions.assign(setup.motions.size(), RigidMotion{});
        shell.emplace(start_.mesh, setup.options);
    }

    /// The traction whose linear response, of this load alone, moves the surface by load.displacement.
    Eigen::Vector3d scaled_traction(const LoadEntry& load, PrimoShell& shell, const ShellSetup& setup) {
        Points unit = Points::Zero(start_.mesh.num_triangles(), 3);
        for (const int t : triangles(load.region)) unit.row(t) = load.direction.transpose();
        Loads loads{traction_forces(start_.mesh, unit), setup.loads.spring};
        double largest = 0;
        try {
            const Points moved = shell.linear_response(loads, setup.motions);
            largest = (moved - start_.mesh.vertices).rowwise().norm().maxCoeff();
        } catch (const UnheldPart& e) {
            throw UnheldPart(text(printable(case_.file.string(), 400), ":", load.place.line, ":", load.place.column,
                                  ": loads: ", e.what()));
        }
        // Below this, it is round-off of a load that acts on held vertices only.
        if (!(largest > 1e-12 * start_.diagonal * unit.norm() * start_.area.sum()) || !std::isfinite(largest))
            throw InvalidInput(
                text("loads: a load on region '", load.region.name, "' along this direction moves nothing"));
        return load.direction * (load.displacement->in(start_.diagonal) / largest);
    }

    void set_goals() {
        for (const QuantityEntry& entry : case_.quantities)
            at(entry.place, text("quantities.", entry.name, ": "), [&] {
                Quantity quantity = std::visit([&](const auto& what) { return make(entry, what); }, entry.what);
                quantity.names = entry.value_names();
                out_.problem.quantities.push_back(std::move(quantity));
            });
        out_.problem.objective = case_.objective.name;
        out_.problem.maximize = case_.maximize;
        for (const Reference& target : case_.fit) out_.problem.fit.push_back(target.name);
        for (const ConstraintEntry& entry : case_.constraints) out_.problem.constraints.push_back(entry.constraint);
        out_.problem.optimize = case_.optimize;
    }

    Quantity make(const QuantityEntry&, const VolumeEntry&) { return volume(start_.mesh, case_.symmetry); }
    Quantity make(const QuantityEntry&, const AreaEntry&) { return area(); }
    Quantity make(const QuantityEntry& entry, const TargetShapeEntry& target) {
        const TriMesh wanted = read_surface(target.file).mesh;
        return target.same_connectivity ? target_shape_same(entry.name, start_.mesh, wanted)
                                        : target_shape_closest(entry.name, start_.mesh, wanted);
    }
    Quantity make(const QuantityEntry& entry, const ExternalEntry& program) {
        ExternalCommand command;
        command.name = entry.name;
        command.command = program.command;
        command.gives = program.gives;
        command.timeout_s = program.timeout_s;
        command.format = program.format.empty() ? name_of(out_.format) : program.format;
        command.case_dir = case_.dir();
        command.evaluations_dir = case_.output.dir / "evaluations";
        command.has_gradients = program.has_gradients;
        command.diagonal = start_.diagonal;
        command.units = case_.units;
        return external(command);
    }
};

}  // namespace

BuiltProblem build_problem(const Case& the_case, Purpose purpose) { return Builder(the_case, purpose).build(); }

}  // namespace strake
