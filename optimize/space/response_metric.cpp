#include "optimize/space/response_metric.hpp"

#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/mesh/cotangents.hpp"
#include "optimize/space/motion_limit.hpp"
#include "optimize/space/response_cache.hpp"
#include "optimize/space/rest_shell.hpp"
#include "optimize/space/shape_map.hpp"
#include "optimize/space/user_variables.hpp"

namespace strake {
namespace {

constexpr int max_samples = 3000;            ///< vertices for the metric: a mean square needs no more
constexpr double response_tolerance = 1e-9;  ///< tight: designs must not depend on the unit of length

/// What the variable moves, by the names of patches: these stay from level to level, their numbers do not, and the name
/// of a variable of many patches leaves most of them out.
std::string key_of(const DesignSpace& space, const Variable& variable) {
    if (variable.patch < 0) return "given " + variable.name;
    std::string key;
    for (const DegreeOfFreedom& move : variable.moves)
        key += text(space.patches().patches[static_cast<std::size_t>(move.index / patch_dof::count)].name, '|',
                    move.index % patch_dof::count, ':', move.factor, '\n');
    return key;
}

Eigen::Index num_work_integrals(const RestFacts& rest) {
    return static_cast<Eigen::Index>(4 * rest.tree->levels.back().patches.size() +
                                     rest.parameters.user_variables.size());
}

/// Reduces displacement fields of the surface to what the metric needs.
class Reduction {
public:
    explicit Reduction(const RestFacts& rest) : rest_(rest), leaves_(rest.tree->levels.back()) {
        stride_ = std::max(1, rest.surface.num_vertices() / max_samples);
        for (int v = 0; v < rest.surface.num_vertices(); v += stride_) sampled_area_ += rest.vertex_area[v];
    }
    /// Columns have Laplacians from here on; zero at open edges, where a row is what flows across them.
    void prepare_laplacians() {
        cotangents_ = cotangent_rows(rest_.surface, sampled_vertices(rest_));
        // Around a vertex inside the surface each neighbour follows one and is followed by another.
        open_fan_.assign(static_cast<std::size_t>(rest_.surface.num_vertices()), 0);
        const Triangles& triangles = rest_.surface.triangles;
        for (int t = 0; t < triangles.rows(); ++t)
            for (int k = 0; k < 3; ++k)
                open_fan_[triangles(t, k)] += triangles(t, (k + 2) % 3) - triangles(t, (k + 1) % 3);
    }

    /// @param of_shell what does work, where `dv` (of the surface) is by a load
    ResponseCache::Column operator()(const Points& dv, const Points* of_shell) const {
        const int count = (rest_.surface.num_vertices() + stride_ - 1) / stride_;
        ResponseCache::Column column{std::sqrt(dv.rowwise().squaredNorm().maxCoeff()), Eigen::VectorXd::Zero(3 * count),
                                     Eigen::VectorXd::Zero(3 * count),
                                     Eigen::VectorXd::Zero(num_work_integrals(rest_))};
        for (int s = 0; s < count; ++s)
            column.samples.segment<3>(3 * s) =
                std::sqrt(rest_.vertex_area[s * stride_] / sampled_area_) * dv.row(s * stride_).transpose();
        if (of_shell) column.work_integrals = work_integrals(*of_shell);
        if (cotangents_.rows() == 0) return column;
        const Points integrals = cotangents_ * dv;
        for (int s = 0; s < count; ++s)
            if (const double area = rest_.vertex_area[s * stride_]; area > 0 && open_fan_[s * stride_] == 0)
                column.laplacians.segment<3>(3 * s) = -integrals.row(s).transpose() / std::sqrt(area * sampled_area_);
        return column;
    }

    /// Of a displacement of the shell: its integral over each leaf, its part along the normals, and by given loads.
    Eigen::VectorXd work_integrals(const Points& of_shell) const {
        Eigen::VectorXd work = Eigen::VectorXd::Zero(num_work_integrals(rest_));
        const Triangles& triangles = rest_.elastic().triangles;
        for (int t = 0; t < triangles.rows(); ++t) {
            Eigen::Vector3d moved = Eigen::Vector3d::Zero();
            for (int k = 0; k < 3; ++k) moved += rest_.area[t] / 3 * of_shell.row(triangles(t, k)).transpose();
            work.segment<3>(4 * leaves_.label[t]) += moved;
            work[4 * leaves_.label[t] + 3] += moved.dot(rest_.normal.row(t));
        }
        const auto& given = rest_.parameters.user_variables;
        for (std::size_t g = 0; g < given.size(); ++g)
            for (Eigen::Index i = 0; i < given[g].traction.rows(); ++i)
                work[static_cast<Eigen::Index>(4 * leaves_.patches.size() + g)] +=
                    traction_gradient(rest_, of_shell, given[g].triangles[i]).dot(given[g].traction.row(i));
        return work;
    }

    /// The parts of samples (one variable a column) along the normals.
    Eigen::MatrixXd along_normals(const Eigen::MatrixXd& samples) const {
        const Points normal = vertex_normals(rest_.surface);
        Eigen::MatrixXd along(samples.rows() / 3, samples.cols());
        for (Eigen::Index s = 0; s < along.rows(); ++s)
            along.row(s) = normal.row(s * stride_) * samples.middleRows<3>(3 * s);
        return along;
    }

    /// The sampled displacements times their shares of the area, zero elsewhere.
    Points weighted(const Points& dv) const {
        Points sampled = Points::Zero(dv.rows(), 3);
        for (int v = 0; v < dv.rows(); v += stride_) sampled.row(v) = rest_.vertex_area[v] / sampled_area_ * dv.row(v);
        return sampled;
    }

private:
    const RestFacts& rest_;
    const PatchLevel& leaves_;
    int stride_ = 1;
    double sampled_area_ = 0;
    Eigen::SparseMatrix<double> cotangents_;  ///< rows of sampled vertices; empty: no Laplacians are wanted
    std::vector<long> open_fan_;              ///< per vertex: 0, but where the fan of its triangles is open
};

/// Responses of the listed variables at the equilibrium of the shell, per unit of each.
std::vector<ResponseCache::Column> columns_at(const DesignSpace& space, PrimoShell* shell,
                                              const std::vector<int>& wanted) {
    DesignSpace movers = space;
    movers.variables.clear();
    for (const int j : wanted) movers.variables.push_back(space.variables[j]);
    Reduction reduce(*space.rest);
    reduce.prepare_laplacians();
    std::vector<ResponseCache::Column> columns;
    if (!wanted.empty())
        design_response(
            movers, shell,
            [&](int j, const Points& dv, const Points& of_shell) {
                columns.push_back(reduce(dv, is_load(movers.variables[j].kind) ? &of_shell : nullptr));
                if (!space.rest->cache->goes_on()) throw Interrupted{};
            },
            response_tolerance);
    return columns;
}

Responses none(const DesignSpace& space) {
    const RestFacts& rest = *space.rest;
    const int stride = std::max(1, rest.surface.num_vertices() / max_samples);
    const int count = (rest.surface.num_vertices() + stride - 1) / stride;
    return {Eigen::VectorXd::Zero(space.size()), Eigen::MatrixXd::Zero(3 * count, space.size()),
            Eigen::MatrixXd::Zero(num_work_integrals(rest), space.size())};
}

void set(Responses& responses, int j, const ResponseCache::Column& column, double scale) {
    responses.largest[j] = scale * column.largest;
    responses.samples.col(j) = scale * column.samples;
    responses.work_integrals.col(j) = scale * column.work_integrals;
}

/// Column j: how much of each leaf's (x, y, z, normal) traction variable j is, and of each given load, at x = 1.
Eigen::MatrixXd leaf_tractions(const DesignSpace& space) {
    const PatchLevel& leaves = space.rest->tree->levels.back();
    Eigen::MatrixXd traction = Eigen::MatrixXd::Zero(num_work_integrals(*space.rest), space.size());
    std::vector<std::vector<int>> leaves_of(space.patches().patches.size());
    for (const Patch& leaf : leaves.patches)
        leaves_of[space.patches().label[leaf.triangles.front()]].push_back(leaf.id);
    for (int j = 0; j < space.size(); ++j) {
        if (!is_load(space.variables[j].kind)) continue;
        if (space.variables[j].patch < 0)
            traction(static_cast<Eigen::Index>(4 * leaves.patches.size()) + space.variables[j].component, j) =
                space.variables[j].unit;
        else
            for (const DegreeOfFreedom& move : space.variables[j].moves)
                for (const int leaf : leaves_of[move.index / patch_dof::count])
                    traction(4 * leaf + move.index % patch_dof::count, j) += space.variables[j].unit * move.factor;
    }
    return traction;
}
/// Of a shape variable: its displacement field; -1: it is none, or wings keep nothing of what fields do.
int held_field(const DesignSpace& space, int j) {
    const Parameters& p = space.rest->parameters;
    const Variable& variable = space.variables[static_cast<std::size_t>(j)];
    if (!p.kept_sections || p.counts_kept_motion_alone || variable.kind != VariableKind::field) return -1;
    return p.user_variables[static_cast<std::size_t>(variable.component)].field;
}

/// Mean square motion (twice, over `wanted`) of the fields before wings keep their sections, times `held_share`
/// squared.
Eigen::MatrixXd held_metric(const DesignSpace& space, double wanted) {
    Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(none(space).samples.rows(), space.size());
    for (int j = 0; j < space.size(); ++j)
        if (const int field = held_field(space, j); field >= 0)
            moved.col(j) = held_share * 2 / wanted * space.variables[static_cast<std::size_t>(j)].unit *
                           sampled_motion(*space.rest, space.rest->parameters.fields->field(field));
    return moved.transpose() * moved;
}

static_assert(patch_dof::load == 0 && patch_dof::normal == 3,
              "leaf tractions are stored in the order of the degrees of freedom");

}  // namespace

std::unique_ptr<PrimoShell> shell_at_rest(const DesignSpace& space) {
    const RestFacts& rest = *space.rest;
    if (!rest.has_shell) return nullptr;
    ShellOptions options = rest.setup.options;
    options.pin = space.pin;
    auto shell = std::make_unique<PrimoShell>(rest.elastic(), options);
    std::vector<RigidMotion> still = rest.setup.motions;
    for (RigidMotion& motion : still) motion = {{0, 0, 0}, {0, 0, 0}, motion.about};
    for (std::size_t p = 0; p < space.motion.size(); ++p)
        if (space.motion[p] >= 0) still.push_back({{0, 0, 0}, {0, 0, 0}, space.carried_motion[p].about});
    const Equilibrium start = shell->solve({{}, rest.setup.loads.spring}, still, {},
                                           [&](const SolveRecord&) { return rest.cache->goes_on(); });
    if (start.status == SolveStatus::cancelled) throw Interrupted{};
    if (start.status != SolveStatus::converged) throw SolverError(text("the shell at rest: ", start.reason));
    return shell;
}

std::vector<int> sampled_vertices(const RestFacts& rest) {
    const int stride = std::max(1, rest.surface.num_vertices() / max_samples);
    std::vector<int> vertices;
    for (int v = 0; v < rest.surface.num_vertices(); v += stride) vertices.push_back(v);
    return vertices;
}

Eigen::VectorXd sampled_motion(const RestFacts& rest, const Points& motion) {
    return Reduction(rest)(motion, nullptr).samples;
}

Responses responses_at_rest(const DesignSpace& space) {
    ResponseCache& cache = *space.rest->cache;
    cache.use(space.pin);
    Responses responses = none(space);
    DesignSpace by_one = space;  // the cache knows responses to physical values of 1
    for (Variable& variable : by_one.variables) variable.unit = 1;
    std::vector<int> unknown;
    for (int j = 0; j < space.size(); ++j)
        if (space.variables[j].kind != VariableKind::stiffness && !cache.find(key_of(space, space.variables[j])))
            unknown.push_back(j);
    if (!unknown.empty()) {
        const std::unique_ptr<PrimoShell> shell = shell_at_rest(space);
        std::vector<ResponseCache::Column> fresh = columns_at(by_one, shell.get(), unknown);
        for (std::size_t i = 0; i < unknown.size(); ++i)
            cache.add(key_of(space, space.variables[unknown[i]]), std::move(fresh[i]));
    }
    for (int j = 0; j < space.size(); ++j)
        if (const auto* column = cache.find(key_of(space, space.variables[j])))
            set(responses, j, *column, space.variables[j].unit);
    return responses;
}

double soft_work(const DesignSpace& space, const Responses& responses) {
    const Eigen::MatrixXd traction = leaf_tractions(space);
    std::vector<double> works;
    for (int j = 0; j < space.size(); ++j)
        if (const double work = traction.col(j).dot(responses.work_integrals.col(j)); work > 0) works.push_back(work);
    if (works.empty()) return 0;
    std::nth_element(works.begin(), works.begin() + static_cast<std::ptrdiff_t>(works.size() / 4), works.end());
    return works[works.size() / 4] / space.rest->energy_share;
}

Eigen::MatrixXd response_metric(const DesignSpace& space, const Responses& responses) {
    const double wanted = variable_scale(space.rest->parameters) * space.rest->diagonal;
    const Eigen::MatrixXd moved = 2 / wanted * responses.samples;
    Eigen::MatrixXd metric = moved.transpose() * moved;
    if (space.rest->parameters.kept_sections && space.rest->parameters.fields) metric += held_metric(space, wanted);
    const Eigen::MatrixXd work = leaf_tractions(space).transpose() * responses.work_integrals;
    if (const double soft = soft_work(space, responses); soft > 0)
        for (int i = 0; i < space.size(); ++i)
            for (int j = 0; j < space.size(); ++j)
                if (is_load(space.variables[i].kind) && is_load(space.variables[j].kind))
                    metric(i, j) += 0.5 * (work(i, j) + work(j, i)) / soft;
    for (int j = 0; j < space.size(); ++j) {
        if (space.variables[j].kind == VariableKind::stiffness) metric(j, j) += 1;
        metric(j, j) *= 1 + 1e-9;  // definite also where loads are dependent, as a vector and a normal on a flat patch
    }
    return metric;
}

Eigen::MatrixXd normal_motion(const DesignSpace& space) {
    const Eigen::MatrixXd along = Reduction(*space.rest).along_normals(responses_at_rest(space).samples);
    return along.transpose() * along;
}

Eigen::MatrixXd roughness(const DesignSpace& space) {
    Eigen::MatrixXd laplacians = Eigen::MatrixXd::Zero(responses_at_rest(space).samples.rows(), space.size());
    for (int j = 0; j < space.size(); ++j)
        if (const auto* column = space.rest->cache->find(key_of(space, space.variables[j])))
            laplacians.col(j) = space.variables[j].unit * column->laplacians;
    return laplacians.transpose() * laplacians;
}

Eigen::VectorXd present_product(const DesignSpace& space, PrimoShell* shell, const Eigen::VectorXd& d,
                                const Points* surface) {
    if (!shell) return space.metric * d;  // fields do the same everywhere
    const Points force = load_forces(space, d);
    const Points of_shell = shell->response({force}, response_tolerance)[0];
    const Points by_loads = surface_rates(*space.rest, carried(*space.rest, of_shell), surface);
    const Points moved = by_loads + field_motion(space, d, surface);
    // d.M.d / 2 as a functional of the response: its gradient by one more substitution is M d.
    const Reduction reduce(*space.rest);
    const double wanted = variable_scale(space.rest->parameters) * space.rest->diagonal;
    const Points pull = surface_pull(*space.rest, 4 / (wanted * wanted) * reduce.weighted(moved), surface);
    const Points of_pull = shell->response({pulled_to_shell(*space.rest, pull)}, response_tolerance)[0];
    const Eigen::MatrixXd traction = leaf_tractions(space);
    const auto working = [&](const Points& one) {  // without a wrap what the surface does
        return space.rest->wrap ? one : surface_rates(*space.rest, one, surface);
    };
    Eigen::VectorXd product = traction.transpose() * reduce.work_integrals(working(of_pull));
    product.tail(space.num_parameters()) = d.tail(space.num_parameters());
    if (space.soft_work > 0)
        product += traction.transpose() * reduce.work_integrals(working(of_shell)) / space.soft_work;
    if (!space.rest->parameters.fields) return product;
    const DisplacementFields& fields = *space.rest->parameters.fields;
    const Eigen::VectorXd by_field = fields.gradient(pull);
    Eigen::VectorXd z = Eigen::VectorXd::Zero(fields.size());
    for (int j = 0; j < space.num_shape(); ++j) {
        if (const int held = held_field(space, j); held >= 0) z[held] = space.variables[j].unit * d[j];
        if (const Variable& variable = space.variables[j]; variable.kind == VariableKind::field)
            product[j] = variable.unit * by_field[space.rest->parameters.user_variables[variable.component].field];
    }
    if (!space.rest->parameters.kept_sections) return product;
    const double share = held_share * 2 / wanted;
    const Eigen::VectorXd by_held = share * share * fields.gradient(reduce.weighted(fields.displacement(z)));
    for (int j = 0; j < space.num_shape(); ++j)
        if (const int held = held_field(space, j); held >= 0) product[j] += space.variables[j].unit * by_held[held];
    return product;
}

}  // namespace strake
