#pragma once
#include "core/patches/hierarchy.hpp"
#include "core/primo/shell.hpp"
#include "objectives/quantity/quantity.hpp"
#include "optimize/nlp/program/methods.hpp"

#include <memory>
#include <optional>

/// A shape optimization problem, free of YAML: what `cases` makes of a case file and what a program that
/// links the library fills in itself.
namespace strake {

class DisplacementFields;
class Invariance;
class KeptSections;
class PlanformMotion;
class WrapMap;

enum class VariableKind {
    load,         ///< traction of a patch as a vector: three variables, or one for each of `load_directions`
    normal_load,  ///< traction along each triangle's own rest normal: one variable
    strain,       ///< rigid motion of a pinned patch core: rotation and translation, six variables
    stiffness,    ///< logarithm of the prism height: one variable
    field,        ///< one of `Parameters::fields`: a displacement of the surface; not for `Parameters::kinds`
    planform,     ///< one of `Parameters::planform`: a change of a wing; not for `Parameters::kinds`
    parameter     ///< one of `Problem::program_parameters`: not shape; not for `Parameters::kinds`
};

/// A design variable that is not shape, for example an angle of attack: quantities are given its value.
struct ProgramParameter {
    std::string name;
    double start = 0, min = -1, max = 1;  ///< min <= start <= max, min < max; angles in radians
    bool is_angle = false;
};

/// A prescribed rigid motion of some triangles (a given strain).
struct PrescribedStrain {
    std::vector<int> triangles;
    RigidMotion motion;
};

/// Which patches the next level splits. The rules by sensitivity choose during the run, among the patches of the tree.
enum class SplitRule {
    tree,         ///< those that the tree itself splits from level to level (all, the largest, those containing points)
    sensitivity,  ///< those whose children have the largest expected decrease in the response metric
    gradient      ///< those with the largest integral of |dJ/dv| over their area (the paper's rule, IV)
};

/// A design variable that the user states, beside those of the patches: there on every level, never split. A load where
/// `traction` is given, a displacement field where `field` names one, a change of a wing where `planform` does, else
/// the rigid motion of its triangles, which it pins for the whole run.
struct UserVariable {
    std::string name;
    int field = -1;              ///< number in `Parameters::fields`, with no triangles; -1: not a field
    int planform = -1;           ///< number in `Parameters::planform`, likewise, with a range of its own
    std::vector<int> triangles;  ///< where it acts, ascending
    Points traction;             ///< per listed triangle, 1/length, at the value 1; empty: a motion
    RigidMotion motion;          ///< at the value 1; its rotation vector and translation are multiplied by the value
    double unit = 0;             ///< value at x = 1; 0: where the linear response moves the surface by `variable_scale`
    double max_displacement = 0;  ///< of its linear response at x = 1, diagonals; 0: none of its own
};

struct Parameters {
    std::vector<VariableKind> kinds{VariableKind::load};  ///< empty: the shape stays as it is
    /// The motion limit, in diagonals, > 0: the farthest that any point of the surface may be from its datum (the
    /// surface under the given loads and strains, all variables zero), in every shape that is handed to a quantity,
    /// written or called best; infinity: none. A limit of `optimize`: others keep to it where `is_limit_stated`.
    double max_displacement = 0.05;
    /// Per vertex, in diagonals, >= 0, infinity: none; empty: `max_displacement`. No vertex is farther than the larger
    /// of its two limits, nor farther than each along the datum's normal outward, and against it inward.
    Eigen::VectorXd max_outward, max_inward;
    bool is_limit_stated = false;  ///< by the case, not by default
    /// The meaning of runs before 1.0: `max_displacement` bounds each variable by its own linear response, and no
    /// shape.
    bool limits_variables = false;
    /// The meaning of earlier runs: a change of fields counts by what wings that keep their sections leave of it.
    bool counts_kept_motion_alone = false;
    bool lets_edges_fold = false;  ///< the same: designs of a shell that fold an edge are tried, and fail
    /// Unit of the variables: their linear response at x = 1, in diagonals, > 0; 0: `max_displacement`, or 5 % where
    /// that is infinite.
    double variable_scale = 0;
    std::vector<char> variables_on;  ///< per triangle: may carry variables; empty: all. A patch takes part if any of
                                     ///< its triangles does
    SplitRule split = SplitRule::tree;
    double marking_fraction =
        0.9;  ///< by sensitivity: split patches until they hold this share of the whole expected decrease
    double max_variable_ratio =
        8;  ///< by sensitivity: maximum number of variables of a level, as a multiple of the level before, > 1
    std::vector<char> frozen;  ///< per triangle: keeps what it inherits, is offered no variable; empty: none
    std::vector<Eigen::Vector3d> load_directions;  ///< unit vectors for `load`; empty: x, y, z
    bool mirror = false;                           ///< tie mirror images about the plane of symmetry of the surface
    std::vector<std::vector<char>> groups;         ///< per group, per triangle: patches of a group share their values
    double free_border = 0.4;                      ///< what a strain leaves free, as a share of the inradius, in (0, 1)
    bool strain_rotates = true, strain_translates = true;  ///< components offered by `strain`
    std::vector<UserVariable> user_variables;              ///< beside those of the patches
    /// Displacement fields: level 0 of the hierarchy, one user variable each (`add_fields`). The surface of a design is
    /// x0 + sum_b z_b field_b + E, E the equilibrium displacement of the shell at rest under the loads and motions of
    /// the others; attached parts follow their hosts there. Null: none.
    std::shared_ptr<const DisplacementFields> fields;
    /// Changes of wings, one user variable each (`add_planform`). They move the start surface, exactly; fields and
    /// shell add what they do to the start surface at rest, and the datum of the motion limit goes with them. Null:
    /// none. Not with attached parts, `invariance`, nor a fit.
    std::shared_ptr<const PlanformMotion> planform;
    /// Wings whose edges, chords and twists stay where fields and the shell would move them: u = K(sum_b z_b field_b +
    /// E) takes the place of that sum, and the planform moves beside it. Null: none. Not with attached parts,
    /// `invariance`, nor a fit.
    std::shared_ptr<const KeptSections> kept_sections;
    /// How many of the fields, the first ones, a run has as it refines: ascending, the last all of them. Empty: all of
    /// them from the start.
    std::vector<int> field_steps;
    /// By sensitivity a refinement is offered the fields of the next step alone, not all that there are, and a first
    /// level of fields is left where what is offered promises a tenth of what they do: of splines along the axis, and
    /// the meaning of earlier runs.
    bool offers_fields_by_steps = false;
    /// Fields leave what is held with no slope, and no design turns normals beside it by more than
    /// `max_border_turn`, where the motion limit limits shapes and there is no planform.
    bool keeps_smooth_border = false;
    static constexpr double max_border_turn = 2;  ///< degrees
    bool lets_border_turn = false;                ///< the meaning of earlier runs: of fields alone
    /// The kind of shape that every design keeps: its surface is x0 + P(...), P the projection of `Invariance`. Loads
    /// act by what of them keeps it. Null: any shape. Not with kinds `strain`, nor with attached parts.
    std::shared_ptr<const Invariance> invariance;
};

/// The first level that has variables, if it is not for patches: displacement fields are level 0 by themselves.
inline int coarsest_level(const Parameters& parameters) { return parameters.fields ? 0 : 1; }

/// Makes the fields design variables: each a user variable that is called as it is.
void add_fields(Parameters& parameters, std::shared_ptr<const DisplacementFields> fields);

/// The same with changes of wings.
void add_planform(Parameters& parameters, std::shared_ptr<const PlanformMotion> planform);

/// A cheap model beside an expensive value.
struct CheapModel {
    std::string value;  ///< of a program
    std::string low;    ///< the value that stands for it, maybe on another scale
};

struct Constraint {
    std::string quantity;  ///< a value's name
    std::optional<double> min, max, equals;
    bool relative = false;  ///< limits are multiples of the value at the start
};

/// What a level knows of the Hessian when it starts; the first is what a run does, the others are there to be compared.
enum class LevelStartHessian {
    carried,  ///< what the level above learned, and the metric for the details
    metric,   ///< a multiple of the response metric
    diagonal  ///< a multiple of the metric's diagonal: raw variables, each scaled by itself
};

/// How `sample` spreads its designs.
enum class Spread {
    sobol,
    lhs,    ///< a Latin hypercube
    levels  ///< all combinations of equidistant levels
};

struct OptimizeOptions {
    Method method = Method::sqp;
    /// Where values lack gradients and the budget is short of what differences of them need, `model` takes the place of
    /// `method`, which is sqp.
    bool chooses_method = false;
    int batch = 8;                    ///< of method model: designs that are proposed together, >= 1
    int max_evaluations = 60;         ///< whole run, >= 1
    double max_seconds = 0;           ///< whole run; 0: no limit
    double min_expected_gain = 2e-3;  ///< split only what is expected to give this share of what was gained for every
                                      ///< ten new variables; fewer than ten in all count as ten
    /// Refine when the gain per evaluation falls below this fraction of the level's best rate, or finer details are
    /// expected to gain more than the level; 0: only when its own search ends.
    double progress_below = 0.01;
    double objective_tolerance = 1e-6;  ///< a level has converged below this share of what the run has gained
    /// The meaning of runs before 0.2: `objective_tolerance` is relative to the objective, and a gradient is checked
    /// only where the search had ended.
    bool is_relative_to_objective = false;
    /// The same: a budget is shared among all levels, also where each then has too few evaluations to move.
    bool shares_with_all_levels = false;
    /// The meaning of earlier runs: ranges of variables stay as they are where a level has converged at them.
    bool keeps_ranges = false;
    /// The meaning of earlier runs: without a shell, too, a level begins with what a variable may do alone.
    bool begins_with_narrow_ranges = false;
    bool begins_with_narrow_shell_ranges = false;  ///< the same with a shell
    bool models_begin_with_narrow_ranges = false;  ///< the same of searches by models
    bool trusts_long_steps = false;                ///< the meaning of earlier runs: `MinimizeOptions`
    /// The meaning of earlier runs: `MinimizeOptions`; all levels by `model` have the same share of the budget; levels
    /// by differences never begin with it, and a group of variables joins from a third of the other's promise on.
    bool learns_as_before = false;
    /// The meaning of earlier runs: levels by differences that begin by `model` ask whole batches in random directions,
    /// and have no patches; a level that was left for finer details may be left for finer ones before it has moved; of
    /// `sqp`: `MinimizeOptions`.
    bool descends_as_before = false;
    bool limits_by_models = false;             ///< the meaning of earlier runs: `MinimizeOptions`
    bool limits_by_turns = false;              ///< the same
    bool minima_in_variables = false;          ///< the same
    bool leaves_equations = false;             ///< the same
    bool leaves_limits = false;                ///< the same
    bool pays_without_shape = false;           ///< the same
    bool steps_pay_without_shape = false;      ///< the same
    bool stays_where_models_are_sure = false;  ///< the same
    bool images_are_exact = false;             ///< the same
    bool follows_short_waves = false;          ///< the same
    /// No values of mirror images are compared (`NonlinearProgram::mirror_images`): the meaning of earlier runs, and
    /// `optimize.symmetry: false`.
    bool ignores_symmetry = false;
    /// The meaning of earlier runs: models of patches alone have the metric's curvature, not that of motions along
    /// normals beside it (`NonlinearProgram::second_curvature`).
    bool one_curvature = false;
    /// The same of models of fields, which have that of rough motions beside it (`roughness`).
    bool fields_have_one_curvature = false;
    /// The meaning of earlier runs: in long ones by models patches lead only where they gain nearly what the fields
    /// before them did, and the finest patches are the last level (optimize/run/level_order.hpp).
    bool fields_lead = false;
    /// The meaning of earlier runs: long ones by models have their patches beside finer fields, never before them
    /// (optimize/run/level_order.hpp).
    bool patches_last = false;
    /// The meaning of earlier runs: `method: auto` is `sqp` in all long runs by values alone, and searches by models
    /// begin in random directions: none `is_long_with_fields` (optimize/run/method_choice.hpp).
    bool long_runs_by_differences = false;
    /// The meaning of earlier runs: long ones that begin in order by models do not set
    /// `MinimizeOptions::begins_with_few`, fields alone have two evaluations for each variable there, not one and a
    /// half, and fields are searched on all levels.
    bool begins_slowly = false;
    /// The meaning of earlier runs: the first level of these asks whole batches (`batch_of_first_fields`).
    bool begins_with_whole_batches = false;
    /// The meaning of earlier runs: elastic energies count wholly beside fields, by gradients too (`energy_share`).
    bool counts_whole_energy = false;
    /// The meaning of earlier runs: by sensitivity refinement ends where parts of patches promise too little, whatever
    /// their parts would (optimize/run/refinement_choice.hpp).
    bool sees_parts_alone = false;
    /// The meaning of earlier runs: beside fields all patches of a front have variables, by gradients too
    /// (`takes_single_patches`).
    bool refines_whole_fronts = false;
    /// The meaning of earlier runs, and of those that state `starts`: steps are not watched for waves
    /// (`looks_for_waves`).
    bool ignores_waves = false;
    /// The meaning of earlier runs: levels of long ones by models end at their limits, though they still gain
    /// (`MinimizeOptions::limit_while_gaining`).
    bool levels_end_at_limits = false;
    bool levels_gain_a_quarter = false;  ///< the same: they go on where `MinimizeOptions::gaining_share` is a quarter
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
    int icp_iterations = 0;
};

struct StoredDesign;
struct DesignTable;

struct Problem {
    std::string name;
    TriMesh surface;  ///< what is measured, guarded and handed on
    /// What is elastic in the place of the surface, and carries it along: v = x0 + Phi z + B E(F y). All of this struct
    /// that is elastic (tree, prism_height, supports, strains, given_traction, spring_per_area; of the parameters
    /// variables_on, frozen, groups and the user variables' triangles) is then about the wrap; `fixed`, symmetry,
    /// fields, motion limits and quantities stay about the surface. Null: the surface itself is elastic. Not without a
    /// shell, nor with attached parts or `invariance`.
    std::shared_ptr<const WrapMap> wrap;
    /// With a wrap: triangles of the surface that fields leave as they are, beside those of `fixed`.
    std::vector<int> still;
    PatchHierarchy tree;
    /// false: no elastic shell is built, and `Parameters::fields` alone move the surface, which may then be any: not
    /// manifold, piercing itself, of slivers. Without loads, strains, springs and attached parts; variables are fields.
    bool has_shell = true;
    Eigen::VectorXd prism_height;  ///< per vertex; empty without a shell
    std::vector<int> fixed;        ///< triangles
    std::vector<int> supports;     ///< triangles that are fixed in the shell alone: fields may move them
    std::vector<PrescribedStrain> strains;
    std::vector<AttachedPart> attached;  ///< go with their hosts; their triangles are under nothing else of this struct
    std::optional<SymmetryPlane> symmetry;
    bool couple_nonmanifold = false;
    LinearSolver solver = LinearSolver::automatic;
    Points given_traction;            ///< m x 3 background loads; empty: none
    Eigen::VectorXd spring_per_area;  ///< per triangle, lambda_A; empty: none
    Parameters parameters;
    std::vector<ProgramParameter> program_parameters;  ///< beside the shape, on every level
    std::vector<Quantity> quantities;                  ///< all that is logged, optimized or constrained
    std::string objective;                             ///< a value's name; empty for a fit
    bool maximize = false;
    std::vector<std::string> fit;  ///< names of quantities with residuals
    FitOptions fitting;
    std::vector<Constraint> constraints;
    std::vector<CheapModel> cheap_models;
    /// The programs that cheap models come from, with folders of their own: beside what `quantities` say of a design
    /// they are asked for designs that are never evaluated.
    std::vector<Quantity> cheap_programs;
    OptimizeOptions optimize;
    std::optional<Spread> sample;               ///< designs are spread instead of searched
    std::shared_ptr<const DesignTable> table;   ///< of `sample`: the designs and what they gave; null: they are spread
    std::shared_ptr<const StoredDesign> start;  ///< where `optimize` and `fit` begin, set by `start_from`; else at rest
};

/// The wrap, or where there is none the surface.
const TriMesh& elastic_surface(const Problem& problem);

}  // namespace strake
