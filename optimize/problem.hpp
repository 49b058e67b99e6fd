#pragma once
#include "core/patches/hierarchy.hpp"
#include "core/primo/shell.hpp"
#include "objectives/quantity.hpp"

#include <memory>
#include <optional>

/// A shape optimization problem, free of YAML: what `cases` makes of a case file and what a program that
/// links the library fills in itself.
namespace strake {

enum class VariableKind {
    load,         ///< traction of a patch as a vector: three variables, or one for each of `load_directions`
    load_normal,  ///< traction along each triangle's own rest normal: one variable
    strain,       ///< rigid motion of a pinned patch core: rotation and translation, six variables
    stiffness,    ///< logarithm of the prism height: one variable
    own           ///< one of `Problem::own`: not shape; not for `Parameters::kinds`
};

/// A design variable that is not shape, as an angle of attack: quantities are given its value.
struct OwnVariable {
    std::string name;
    double start = 0, min = -1, max = 1;  ///< min <= start <= max, min < max; angles in radians
    bool is_angle = false;
};

/// A prescribed rigid motion of some triangles (a given strain).
struct GivenStrain {
    std::vector<int> triangles;
    RigidMotion motion;
};

/// Which patches the next level splits. The rules by sensitivity choose during the run, among the patches of the tree.
enum class SplitRule {
    tree,         ///< those that the tree itself splits from level to level (all, the largest, those containing points)
    sensitivity,  ///< those whose children promise the largest decrease in the response metric
    gradient      ///< those with the largest integral of |dJ/dv| over their area (the paper's rule, IV)
};

/// A design variable that the user states, beside those of the patches: there on every level, never split. A load where
/// `traction` is given, else the rigid motion of its triangles, which it pins for the whole run.
struct GivenVariable {
    std::string name;
    std::vector<int> triangles;  ///< where it acts, ascending
    Points traction;             ///< per listed triangle, 1/length, at the value 1; empty: a motion
    RigidMotion motion;          ///< at the value 1; its rotation vector and translation are multiplied by the value
    double unit = 0;             ///< value at x = 1; 0: where the linear response moves the surface by max_displacement
    double max_displacement = 0;  ///< diagonals; 0: that of the parameters
};

struct Parameters {
    std::vector<VariableKind> kinds{VariableKind::load};  ///< empty: the shape stays as it is
    double max_displacement = 0.05;  ///< bound of each variable by its own linear response, in diagonals, > 0
    std::vector<char>
        on;  ///< per triangle: may carry variables; empty: all. A patch takes part if any of its triangles does
    SplitRule split = SplitRule::tree;
    double split_share = 0.9;  ///< by sensitivity: split patches until they hold this share of all that is promised
    double growth = 8;         ///< by sensitivity: most variables of a level, as a multiple of the level before, > 1
    std::vector<char> frozen;  ///< per triangle: keeps what it inherits, is offered no variable; empty: none
    std::vector<Eigen::Vector3d> load_directions;  ///< unit vectors for `load`; empty: x, y, z
    bool mirror = false;                           ///< tie mirror images about the plane of symmetry of the surface
    std::vector<std::vector<char>> groups;         ///< per group, per triangle: patches of a group share their values
    double core = 0.4;                             ///< what a strain leaves free, as a share of the inradius, in (0, 1)
    bool strain_rotates = true, strain_translates = true;  ///< components offered by `strain`
    std::vector<GivenVariable> given;                      ///< beside those of the patches
};

struct Constraint {
    std::string quantity;  ///< a value's name
    std::optional<double> min, max, equals;
    bool relative = false;  ///< limits are multiples of the value at the start
};

/// How to search; what each one needs and takes stands in `method_facts` (optimize/methods.hpp).
enum class Method {
    slsqp,  // local, with gradients
    mma,
    ccsaq,
    lbfgs,
    tnewton,
    var2,
    cobyla,  // local, without
    bobyqa,
    neldermead,
    sbplx,
    praxis,
    crs2,  // global
    isres,
    mlsl,
    direct,
    esch
};

/// What a level knows of the Hessian when it starts; the first is what a run does, the others are there to be compared.
enum class LevelStartHessian {
    carried,  ///< what the level above learned, and the metric for the details
    metric,   ///< a multiple of the response metric
    diagonal  ///< a multiple of the metric's diagonal: raw variables, each scaled by itself
};

struct OptimizeOptions {
    Method method = Method::slsqp;
    int max_evaluations = 60;     ///< whole run, >= 1
    double max_seconds = 0;       ///< whole run; 0: no limit
    double promise_below = 2e-3;  ///< split only what is expected to give this share of what was gained for every ten
                                  ///< new variables; fewer than ten in all count as ten
    /// Refine when the gain per evaluation falls below this fraction of the level's best rate, or finer details promise
    /// more than the level still does; 0: only when its own search ends.
    double progress_below = 0.01;
    double objective_tolerance = 1e-6;   ///< a level has converged below this relative change of the objective
    double step_tolerance = 1e-6;        ///< or below this change of the scaled variables
    double constraint_tolerance = 1e-6;  ///< of the scaled constraint, for "feasible"
    bool finite_differences = false;  ///< gradients of values without sensitivities by differences in the scaled basis
    double difference_step = 1e-4;    ///< of these, as a share of the size-1 step of the metric, in (0, 1]
    int starts = 1;                   ///< of the first level: the given one and random ones within the bounds, >= 1
    unsigned seed = 1;                ///< of all that is random
    LevelStartHessian level_start = LevelStartHessian::carried;
};

enum class Loss { none, huber, cauchy, soft_l1 };  ///< robust.hpp has the formulas

struct FitOptions {
    Loss loss = Loss::none;
    double loss_scale = 0.001;  ///< distance from which on a point pulls less, in diagonals, > 0
    /// 0: what is closest is found anew at every evaluation. n: it is kept within a solve, and a level has at most n
    /// solves.
    int associations = 0;
};

struct StoredDesign;

struct Problem {
    std::string name;
    TriMesh surface;
    PatchHierarchy tree;
    Eigen::VectorXd prism_height;  ///< per vertex
    std::vector<int> fixed;        ///< triangles
    std::vector<GivenStrain> strains;
    std::vector<AttachedPart> attached;  ///< go with their hosts; their triangles are under nothing else of this struct
    std::optional<SymmetryPlane> symmetry;
    bool couple_nonmanifold = false;
    LinearSolver solver = LinearSolver::automatic;
    Points given_traction;            ///< m x 3 background loads; empty: none
    Eigen::VectorXd spring_per_area;  ///< per triangle, lambda_A; empty: none
    Parameters parameters;
    std::vector<OwnVariable> own;      ///< beside the shape, on every level
    std::vector<Quantity> quantities;  ///< all that is logged, optimized or constrained
    std::string objective;             ///< a value's name; empty for a fit
    bool maximize = false;
    std::vector<std::string> fit;  ///< names of quantities with residuals
    FitOptions fitting;
    std::vector<Constraint> constraints;
    OptimizeOptions optimize;
    std::shared_ptr<const StoredDesign> start;  ///< where `optimize` and `fit` begin, set by `start_from`; else at rest
};

}  // namespace strake
