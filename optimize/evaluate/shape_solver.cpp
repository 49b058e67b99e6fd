#include "optimize/evaluate/shape_solver.hpp"

#include "core/error.hpp"
#include "core/wrap/wrap_map.hpp"
#include "optimize/problem/sliding_parts.hpp"
#include "optimize/space/shape_map.hpp"

namespace strake {
namespace {

/// A reasonable step takes four to eight; more than these are better spent on a shorter step.
constexpr int max_iterations = 14;
constexpr std::size_t known_shapes = 3;  ///< equilibria of a level from which the nearest is the start of the next

/// Where the datum has them, whatever the design: held, or moved by given strains.
std::vector<int> triangles_that_stay(const Problem& problem) {
    std::vector<int> all = problem.fixed;
    if (!problem.wrap)
        for (const PrescribedStrain& strain : problem.strains)
            all.insert(all.end(), strain.triangles.begin(), strain.triangles.end());
    return all;
}

}  // namespace

std::string to_string(EvaluationStatus status) {
    switch (status) {
        case EvaluationStatus::ok:
            return "ok";
        case EvaluationStatus::not_converged:
            return "not_converged";
        case EvaluationStatus::unstable:
            return "unstable";
        case EvaluationStatus::invalid:
            return "invalid";
        case EvaluationStatus::quantity_failed:
            return "quantity_failed";
    }
    return "unknown";
}

ShapeGuard guard_of(const Problem& problem, const std::shared_ptr<const RestFacts>& rest) {
    const bool is_mapped = !problem.has_shell || problem.wrap;
    const std::shared_ptr<const TriMesh> surface(rest, &rest->surface);  // one of millions of triangles is enough
    const Adjacency of_body = problem.wrap ? adjacency(*surface) : Adjacency{};
    ShapeGuard guard{{surface,
                      problem.wrap ? of_body : rest->adjacent,
                      {problem.fixed, problem.symmetry, sliding_triangles(problem), is_mapped}}};
    if (problem.wrap) {
        ValidityOptions of_wrap;
        of_wrap.symmetry = problem.symmetry;
        guard.wrap.emplace(problem.wrap->mesh(), problem.wrap->adjacent(), of_wrap);
    }
    return guard;
}

std::string defect_of(const ShapeGuard& guard, const RestFacts& rest, const ShellDemand& demand, const Points& vertices,
                      const PrimoShell* shell) {
    if (!shell) return guard.surface.defect(vertices, local_maps(rest, demand));
    if (!guard.wrap) return guard.surface.defect(vertices, with_fields(rest, demand, shell->poses(), vertices));
    const Points of_wrap = shell->vertices();
    const std::string defect = guard.wrap->defect(of_wrap, shell->poses());
    if (!defect.empty()) return "the wrap: " + defect;
    return guard.surface.defect(vertices, local_maps(rest, demand, of_wrap));
}

ShapeSolver::ShapeSolver(const Problem& problem, std::shared_ptr<const RestFacts> rest)
    : rest_(std::move(rest)), guard_(guard_of(problem, rest_)), held_(triangles_that_stay(problem)) {}

void ShapeSolver::enter(const DesignSpace& space) {
    space_ = space;
    last_.reset();
    known_.clear();
    settled_x_.resize(0);
}

void ShapeSolver::set_ranges(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) {
    space_.lower = lower;
    space_.upper = upper;
}

void ShapeSolver::set_limit(MotionLimit limit, std::optional<Poses> poses) {
    limit_ = std::move(limit);
    keep_border();
    if (poses) accepted_ = std::move(poses);
}

void ShapeSolver::keep_border() {
    border_ = edges_and_border_ = {};
    if (limit_.is_none() || !limits_border(rest_->parameters) || held_.empty()) return;
    std::vector<char> held(static_cast<std::size_t>(rest_->surface.num_triangles()), 0);
    for (const int t : held_) held[static_cast<std::size_t>(t)] = 1;
    const std::shared_ptr<const TriMesh> surface(rest_, &rest_->surface);
    const Adjacency of_body = guard_.wrap ? adjacency(*surface) : Adjacency{};
    const Adjacency& adjacent = guard_.wrap ? of_body : rest_->adjacent;
    border_ = EdgeFolds(surface).with_border(adjacent, held, limit_.datum());
    edges_and_border_ = guard_.surface.edge_folds().with_border(adjacent, held, limit_.datum());
}

const EdgeFolds& ShapeSolver::edge_folds() const {
    static const EdgeFolds none;
    if (limit_.is_none()) return none;
    const bool keeps = shell_ && !guard_.wrap && !rest_->parameters.lets_edges_fold;
    if (!border_.is_none()) return keeps ? edges_and_border_ : border_;
    return keeps ? guard_.surface.edge_folds() : none;
}

void ShapeSolver::set_last(std::optional<Poses> poses, const Eigen::VectorXd& x) {
    last_ = std::move(poses);
    last_x_ = x;
}

const Poses* ShapeSolver::nearest_known(const Eigen::VectorXd& x) const {
    const Poses* nearest = accepted_ ? &*accepted_ : nullptr;
    if (is_each_from_datum_) return nearest ? nearest : &rest_poses_;
    double least = std::numeric_limits<double>::infinity();
    for (const KnownShape& shape : known_) {
        const Eigen::VectorXd d = x - shape.x;
        const double distance = d.dot(space_.metric * d);
        if (distance < least) least = distance, nearest = &shape.poses;
    }
    return nearest;
}

/// A shell serves while pins and heights stay; loads and motions change freely.
void ShapeSolver::build_shell(const ShellDemand& demand) {
    if (shell_ && shell_pin_ == space_.pin && shell_height_ == demand.prism_height) return;
    ShellOptions options = rest_->setup.options;
    options.pin = space_.pin;
    options.prism_height = demand.prism_height;
    shell_.reset();  // before the new one: two factors may not fit
    shell_x_.resize(0);
    shell_ = std::make_unique<PrimoShell>(rest_->elastic(), options);
    rest_poses_ = shell_->poses();
    shell_pin_ = space_.pin;
    shell_height_ = demand.prism_height;
}

void ShapeSolver::remember(const Eigen::VectorXd& x) {
    std::erase_if(known_, [&](const KnownShape& shape) { return shape.x == x; });
    if (known_.size() == known_shapes) known_.erase(known_.begin());
    known_.push_back({x, *last_});
}

bool ShapeSolver::settle(const Eigen::VectorXd& x, ShapeEvaluation& result) {
    const bool is_known = settled_x_.size() == x.size() && settled_x_ == x;
    if (!is_known || (settled_.vertices.rows() > 0 && !is_at(x))) {
        settled_x_.resize(0);
        settled_ = {};
        settled_defect_.reset();
        solve(x, settled_);
        settled_x_ = x;
    }
    result.status = settled_.status;
    result.reason = settled_.reason;
    result.vertices = settled_.vertices;
    return result.vertices.rows() > 0;
}

bool ShapeSolver::solve(const Eigen::VectorXd& x, ShapeEvaluation& result) {
    const ShellDemand wanted = demand(space_, x);
    if (!rest_->has_shell) {
        shell_demand_ = wanted;
        return at_equilibrium(x, result);
    }
    build_shell(wanted);
    if ((rest_->parameters.fields || rest_->parameters.planform) && shell_x_.size() > 0 &&
        wanted.same_shell(shell_demand_)) {
        shell_demand_ = wanted;
        return at_equilibrium(x, result);
    }
    const Poses* start = nearest_known(x);
    if (start) shell_->set_poses(*start);
    SolveOptions options;
    options.keep_factor = true;
    // From an accepted design on a shorter step is cheaper than a way around a buckling point; the first design has to
    // be reached as it is.
    options.fallbacks = !start || is_each_from_datum_;
    if (!options.fallbacks) options.max_iterations = max_iterations;
    shell_x_.resize(0);
    Equilibrium end;
    try {
        end = shell_->solve(wanted.loads, wanted.motions, options,
                            [this](const SolveRecord&) { return !(stop_wanted_ && stop_wanted_()); });
    } catch (const SolverError& error) {
        end.reason = error.what();
        shell_.reset();  // where it stopped is no place to go on from
    }
    if (end.status == SolveStatus::cancelled) throw Interrupted{};
    if (end.status != SolveStatus::converged) {
        result.status =
            end.status == SolveStatus::unstable ? EvaluationStatus::unstable : EvaluationStatus::not_converged;
        result.reason = end.reason;
        return false;
    }
    shell_demand_ = wanted;
    return at_equilibrium(x, result);
}

/// The shell is in the equilibrium of `shell_demand_`, beside which the fields move the surface.
bool ShapeSolver::at_equilibrium(const Eigen::VectorXd& x, ShapeEvaluation& result) {
    shell_x_ = x;
    try {
        result.vertices = with_fields(*rest_, shell_demand_, shell_ ? shell_->vertices() : rest_->surface.vertices);
        return true;
    } catch (const SolverError& error) {  // edges of a wing that cannot be kept
        result.reason = error.what();
    } catch (const InvalidInput& error) {
        if (!rest_->parameters.kept_sections) throw;
        result.reason = error.what();
    }
    result.status = EvaluationStatus::invalid;
    return false;
}

std::vector<ShellSensitivities> ShapeSolver::adjoint(const std::vector<Points>& dJ_dv, const AdjointOptions& options,
                                                     const Points& surface) {
    const Points about = beside_planform(surface);
    return surface_adjoint(*rest_, shell_.get(), dJ_dv, options, &about);
}

std::vector<ShellSensitivities> ShapeSolver::adjoint_of_vertices(const std::vector<int>& vertices, const Points& dJ_dv,
                                                                 const AdjointOptions& options) {
    return strake::adjoint_of_vertices(*rest_, shell_.get(), vertices, dJ_dv, options);
}

Points ShapeSolver::beside_planform(const Points& vertices) const {
    return strake::beside_planform(*rest_, shell_demand_, vertices);
}

const std::string& ShapeSolver::defect() {
    if (!settled_defect_) settled_defect_ = defect_of(guard_, *rest_, shell_demand_, settled_.vertices, shell_.get());
    return *settled_defect_;
}

bool ShapeSolver::is_valid(const Eigen::VectorXd& x, ShapeEvaluation& result) {
    last_.reset();
    if (!settle(x, result)) return false;
    last_ = shell_ ? shell_->poses() : Poses{};
    last_x_ = x;
    result.reason = defect();
    if (result.reason.empty()) return true;
    result.status = EvaluationStatus::invalid;
    result.vertices.resize(0, 3);
    last_.reset();
    return false;
}

std::string ShapeSolver::refusal_of(const Points& settled) {
    if (!defect().empty() || limit_.is_none()) return defect();
    return limit_.excess(beside_planform(settled));
}

bool ShapeSolver::has_shape(const Eigen::VectorXd& x) {
    ShapeEvaluation shape;
    return no_datum_.empty() && settle(x, shape) && refusal_of(shape.vertices).empty();
}

std::string ShapeSolver::refusal(const Eigen::VectorXd& x) {
    ShapeEvaluation shape;
    return no_datum_.empty() && settle(x, shape) ? refusal_of(shape.vertices) : "";
}

bool ShapeSolver::deform(const Eigen::VectorXd& x, ShapeEvaluation& result) {
    if (!no_datum_.empty()) {
        result.status = EvaluationStatus::not_converged;
        result.reason = no_datum_;
        return false;
    }
    if (!is_valid(x, result)) return false;
    if (!limit_.is_none()) result.reason = limit_.excess(beside_planform(result.vertices));
    if (!result.reason.empty()) {
        result.status = EvaluationStatus::invalid;
        result.vertices.resize(0, 3);
        last_.reset();
        return false;
    }
    remember(x);
    result.max_displacement = std::sqrt((result.vertices - rest_->surface.vertices).rowwise().squaredNorm().maxCoeff());
    return true;
}

bool ShapeSolver::begin_from(const Poses& poses, const Eigen::VectorXd& x, ShapeEvaluation& result) {
    accepted_.reset();  // a design of a run without a shell has no poses: from rest
    if (!rest_->has_shell || !poses.rotation.empty()) accepted_ = poses;
    if (!is_valid(x, result)) return false;
    remember(x);
    accept();
    return true;
}

}  // namespace strake
