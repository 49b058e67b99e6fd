#include "optimize/space/rest_facts.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/wrap/wrap_map.hpp"
#include "optimize/space/mirror.hpp"
#include "optimize/space/response_cache.hpp"

namespace strake {
namespace {

void check_flags(const char* key, const std::vector<char>& flags, int m) {
    if (!flags.empty() && static_cast<int>(flags.size()) != m)
        throw InvalidInput(text("parameters.", key, ": ", flags.size(), " entries for ", m, " triangles"));
}

void check(const Parameters& p, int n, int m) {
    if (!(p.max_displacement > 0)) throw InvalidInput(text("max_displacement = ", p.max_displacement, " must be > 0"));
    if (!(p.variable_scale >= 0) || !std::isfinite(p.variable_scale))
        throw InvalidInput(text("variable_scale = ", p.variable_scale, " must be >= 0"));
    for (const Eigen::VectorXd* limits : {&p.max_outward, &p.max_inward})
        if (limits->size() > 0 && (limits->size() != n || !(limits->minCoeff() >= 0)))
            throw InvalidInput(text("motion limits: ", limits->size(), " values for ", n,
                                    " vertices; there must be one for each, >= 0"));
    if (!(p.free_border > 0 && p.free_border < 1))
        throw InvalidInput(text("parameters.free_border = ", p.free_border, " must be in (0, 1)"));
    if (!(p.max_variable_ratio > 1))
        throw InvalidInput(text("parameters.max_variable_ratio = ", p.max_variable_ratio, " must be > 1"));
    if (!(p.marking_fraction > 0 && p.marking_fraction <= 1))
        throw InvalidInput(text("parameters.marking_fraction = ", p.marking_fraction, " must be in (0, 1]"));
    check_flags("variables_on", p.variables_on, m);
    check_flags("frozen", p.frozen, m);
    for (const auto& group : p.groups) check_flags("groups", group, m);
    for (const Eigen::Vector3d& direction : p.load_directions)
        if (!(std::abs(direction.norm() - 1) < 1e-9))
            throw InvalidInput(text("parameters.directions: length ", direction.norm(), " must be 1"));
}

/// @throws InvalidInput: a name twice, empty or with a dot; not finite; not min <= start <= max with min < max.
void check_parameters(const std::vector<ProgramParameter>& parameters) {
    for (std::size_t i = 0; i < parameters.size(); ++i) {
        const ProgramParameter& v = parameters[i];
        if (v.name.empty() || v.name.find('.') != std::string::npos)
            throw InvalidInput(text("variable ", i, " is called '", v.name, "': a name without a dot is needed"));
        for (std::size_t k = 0; k < i; ++k)
            if (parameters[k].name == v.name) throw InvalidInput(text("two variables are called '", v.name, "'"));
        if (!std::isfinite(v.min) || !std::isfinite(v.max) || !(v.min < v.max))
            throw InvalidInput(text("variable ", v.name, ": min = ", v.min, " must be < max = ", v.max));
        if (!(v.min <= v.start && v.start <= v.max))
            throw InvalidInput(
                text("variable ", v.name, ": start = ", v.start, " must be in [", v.min, ", ", v.max, "]"));
    }
}

}  // namespace

const TriMesh& RestFacts::elastic() const { return wrap ? wrap->mesh() : surface; }

const Adjacency& RestFacts::elastic_adjacent() const { return wrap ? wrap->adjacent() : adjacent; }

std::shared_ptr<const RestFacts> rest_facts(const Problem& problem, double energy_share, bool takes_single_patches) {
    auto rest = std::make_shared<RestFacts>();
    check(problem.parameters, problem.surface.num_vertices(), elastic_surface(problem).num_triangles());
    check_parameters(problem.program_parameters);
    rest->has_shell = problem.has_shell;
    rest->setup = shell_setup(problem);
    rest->surface = problem.surface;
    if (!problem.wrap) rest->adjacent = adjacency(problem.surface);
    rest->wrap = problem.wrap;
    rest->area = triangle_areas(elastic_surface(problem));
    rest->normal = triangle_normals(elastic_surface(problem));
    if (problem.wrap) rest->wrap_vertex_area = vertex_areas(problem.wrap->mesh());
    rest->vertex_area = vertex_areas(problem.surface);
    rest->diagonal = box_diagonal(problem.surface);
    rest->energy_share = energy_share;
    rest->takes_single_patches = takes_single_patches;
    rest->given_traction = problem.given_traction;
    rest->tree = std::make_shared<const PatchHierarchy>(problem.tree);
    rest->parameters = problem.parameters;
    rest->program_parameters = problem.program_parameters;
    rest->cache = std::make_shared<ResponseCache>();
    if (problem.parameters.mirror) {
        rest->mirror = plane_of_symmetry(elastic_surface(problem));
        if (!rest->mirror)
            throw InvalidInput("parameters.mirror: the surface has no plane of symmetry (to 1e-3 of the diagonal)");
        const Eigen::Vector3d n = rest->mirror->normal;
        Eigen::Index axis = 0;
        const bool is_straight = n.cwiseAbs().maxCoeff(&axis) > 1 - 1e-12 && n[axis] > 0;
        const std::string left =
            is_straight ? std::string(1, "xyz"[axis]) : text(n[0], " x + ", n[1], " y + ", n[2], " z");
        rest->notes.push_back(text("mirror images are tied about the plane ", left, " = ", rest->mirror->offset));
    }
    return rest;
}

}  // namespace strake
