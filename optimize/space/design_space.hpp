#pragma once
#include "core/patches/front.hpp"
#include "optimize/space/rest_facts.hpp"

/// The design variables of one level: x in scaled units <-> loads, strains and prism heights (docs/theory-optimize.md).
/// A variable's unit is the change whose linear response at rest moves the surface by `variable_scale` at x = 1.
/// Bounds and results then depend neither on the unit of length nor on the mesh. A prism height moves nothing at
/// rest: its unit is ln 2.
namespace strake {

/// The degrees of freedom of one patch: what variables act on. Traction vector, traction along the normals, rotation
/// and translation of its core, logarithm of the height's factor.
namespace patch_dof {
constexpr int load = 0, normal = 3, rotation = 4, translation = 7, stiffness = 10, count = 11;
}

/// One degree of freedom that a variable moves, and by how much: patch * patch_dof::count + one of these, behind them
/// one for each user variable.
struct DegreeOfFreedom {
    int index = 0;
    double factor = 1;
};

struct Variable {
    std::string name;  ///< patch and component: `wing.upper.load_x`
    VariableKind kind = VariableKind::load;
    int patch = 0;      ///< id in its level; of tied patches the first; -1: not of a patch
    int component = 0;  ///< load: x, y, z or number of the direction; strain: rotation x, y, z, translation x, y, z
                        ///< user variable: its number in `Parameters::user_variables`
    double unit = 1;  ///< physical value at x = 1: 1/length, radians, length, or log of a factor; parameters: `offset`
    std::vector<DegreeOfFreedom> moves;  ///< one, or several for a direction and for tied patches; parameters: none
    double offset = 0;                   ///< physical value at x = 0: the start of a parameter, else zero
};

/// What x asks of the shell, and of the fields beside it. Without a shell: no forces, no motions, no heights.
struct ShellDemand {
    Loads loads;
    std::vector<RigidMotion> motions;  ///< given strains first
    Eigen::VectorXd prism_height;      ///< per vertex
    Eigen::VectorXd fields;            ///< values of `Parameters::fields`: beside the shell; empty: there are none
    Eigen::VectorXd planform;          ///< likewise of `Parameters::planform`
    /// The shell is asked for the same.
    bool same_shell(const ShellDemand& other) const;
};

/// The surface whose shell is in equilibrium at `of_shell` (n x 3; with a wrap its vertices): moved by planform and
/// fields, attached parts with their hosts; of the kind of shape that is to be kept.
Points with_fields(const RestFacts& rest, const ShellDemand& demand, const Points& of_shell);
/// Poses for the guard: the prisms' rotations, with the polar part of what these do. @param surface n x 3
Poses with_fields(const RestFacts& rest, const ShellDemand& demand, const Poses& of_shell, const Points& surface);

/// The same surface without the motion by the planform: what the motion limit looks at.
Points beside_planform(const RestFacts& rest, const ShellDemand& demand, const Points& surface);
/// Per triangle: the linear part of the map by planform and fields at its centroid.
std::vector<Eigen::Matrix3d> local_maps(const RestFacts& rest, const ShellDemand& demand);
/// The same with a wrap, whose vertices are at `of_wrap`.
std::vector<Eigen::Matrix3d> local_maps(const RestFacts& rest, const ShellDemand& demand, const Points& of_wrap);

/// A dependent variable: others do the same, the direction from it to them moves nothing.
struct DependentVariable {
    Variable variable;
    Eigen::VectorXd share;  ///< x of the shape variables whose linear response is that of this one at 1
};

/// Which of `Parameters::fields` are variables of a level.
struct FieldSet {
    std::vector<int> numbers;  ///< ascending
    int reach = 0;             ///< those from here on have not been offered yet: one of `Parameters::field_steps`
};

/// What the variables of a level are made of.
struct LevelSet {
    Front front;
    FieldSet fields;
    bool has_patches = true;      ///< patches have variables; false: the fields are by themselves
    std::vector<char> resting{};  ///< per patch: it has none, and keeps what it inherits; empty: all have
    bool takes_up = false;        ///< fields that rested above go on with the values that they have, in the same ranges
};

struct DesignSpace {
    std::shared_ptr<const RestFacts> rest;
    int level = 0;
    std::shared_ptr<const Front> front;
    FieldSet fields;
    bool has_patches = true;
    std::vector<char> resting;        ///< `LevelSet::resting`
    std::vector<Variable> variables;  ///< of the shape, then those of `rest->program_parameters`
    /// size() x size(), positive definite: x.metric.x is the size of a small change x, see response_metric.hpp.
    Eigen::MatrixXd metric;
    double soft_work = 0;                      ///< what energies are measured by in it; 0: there are no loads
    Eigen::VectorXd lower, upper;              ///< per variable, scaled; wider where an inherited value lies outside
    std::vector<std::string> notes;            ///< dependent and ineffective variables, and why
    std::vector<DependentVariable> dependent;  ///< because they depend on others
    std::vector<std::string> weak;             ///< names of variables that do nearly what others can do
    std::vector<std::string> nearly_fixed;     ///< names of patches with almost no free area
    std::vector<int> pin;                ///< ShellOptions::pin of this level: fixed, given strains, then the cores
    std::vector<std::vector<int>> core;  ///< pinned triangles of each patch with strain variables; empty elsewhere
    std::vector<int> motion;  ///< per patch: number of its motion in `ShellDemand::motions`, -1 without a core
    std::vector<RigidMotion> carried_motion;  ///< per patch: about the core's area-weighted centroid, with what was
                                              ///< inherited and has no variable here
    Points carried_traction;                  ///< m x 3: inherited where this level has no variable for it; empty: none
    Eigen::VectorXd carried_log_height;       ///< m: the same of the logarithm of the height's factor; empty: none
    Eigen::VectorXd carried_user_values;      ///< per user variable: the same of its value

    int size() const { return static_cast<int>(variables.size()); }
    int num_parameters() const;  ///< of the variables, the last ones
    int num_shape() const { return size() - num_parameters(); }
    const PatchLevel& patches() const { return front->patches; }
    bool has_variables(int patch) const { return has_patches && (resting.empty() || !resting[patch]); }
    int num_patch_dofs() const { return patch_dof::count * static_cast<int>(front->patches.patches.size()); }
    int num_dofs() const { return num_patch_dofs() + static_cast<int>(rest->parameters.user_variables.size()); }
    Eigen::VectorXd user_values(const Eigen::VectorXd& dofs) const { return dofs.tail(num_dofs() - num_patch_dofs()); }
    bool changes_height() const;  ///< some variable is a stiffness, or one was inherited
};

/// How many a patch that is free has.
int variables_of_a_patch(const Parameters& parameters);

/// The space of `level` of the tree with x = 0 the undeformed start (under given loads and strains).
/// @throws InvalidInput: no such level; strain cores that leave no free prism. UnheldPart from the rest solve.
/// Cost: one factorization at rest and one back-substitution per variable.
DesignSpace design_space(std::shared_ptr<const RestFacts> rest, int level);

struct InheritedSpace {
    DesignSpace space;
    Eigen::VectorXd x;
    Eigen::MatrixXd prolongation;  ///< dx / d(x of the parent)
};
/// The space of the next level, and its x that demands the same of the shell as `x` does of `parent`: equal traction,
/// equal motion and equal height of every triangle. Bounds are widened where an inherited value lies outside.
InheritedSpace refine(const DesignSpace& parent, const Eigen::VectorXd& x, const LevelSet& next);
/// To the next level of the tree.
InheritedSpace refine(const DesignSpace& parent, const Eigen::VectorXd& x);
/// To a front made by `split_front`, with the parent's fields.
InheritedSpace refine(const DesignSpace& parent, const Eigen::VectorXd& x, const Front& front);

/// What the variables of a space are made of.
LevelSet level_set_of(const DesignSpace& space);
/// A level of the tree: on each, `Parameters::field_steps` goes on by one number.
LevelSet level_set(const RestFacts& rest, int level);
/// All fields below the next of `Parameters::field_steps`.
FieldSet more_fields(const Parameters& parameters, const FieldSet& present);
/// Those that a refinement by sensitivity is offered: all fields, unless `Parameters::offers_fields_by_steps`.
FieldSet offered_fields(const Parameters& parameters, const FieldSet& present);

/// Values of all degrees of freedom (num_dofs()).
Eigen::VectorXd dofs(const DesignSpace& space, const Eigen::VectorXd& x);

/// Tractions, motions and heights of x. Forces are summed over triangles in their order, whatever the patches.
ShellDemand demand(const DesignSpace& space, const Eigen::VectorXd& x);
/// Its `planform` alone. @pre there are changes of wings
Eigen::VectorXd planform_change(const DesignSpace& space, const Eigen::VectorXd& x);

/// Change of the vertex forces, n x 3, by a change of the load variables.
Points load_forces(const DesignSpace& space, const Eigen::VectorXd& change);

/// Displacement of the surface by a change of the field variables, n x 3. @param surface of the design, where attached
/// parts follow; null: at rest
Points field_motion(const DesignSpace& space, const Eigen::VectorXd& change, const Points* surface = nullptr);

/// dJ/dx (size()) from dJ/d(force, motion, height) at x. One pass over the surface, however many variables.
Eigen::VectorXd design_gradient(const DesignSpace& space, const Eigen::VectorXd& x,
                                const ShellSensitivities& sensitivities);
/// dJ/dx by that of the values of `Parameters::fields`.
Eigen::VectorXd design_gradient_of_fields(const DesignSpace& space, const Eigen::VectorXd& by_field);

/// dv/dx at the shell's equilibrium, column j as n x 3 points: one back-substitution each, in blocks; `tolerance` is
/// that of `PrimoShell::response`, `surface` as for `field_motion`. `shell` is null where the problem has none.
/// `consume(j, dv)` is called in the order of the variables. @throws InvalidInput for stiffness variables.
/// @param x where changes of wings are; null: at rest
void design_response(const DesignSpace& space, PrimoShell* shell,
                     const std::function<void(int j, const Points& dv)>& consume, double tolerance = 1e-11,
                     const Points* surface = nullptr, const Eigen::VectorXd* x = nullptr);

/// The same; `of_shell` (rows: the elastic surface's vertices) is what the shell does, for loads.
void design_response(const DesignSpace& space, PrimoShell* shell,
                     const std::function<void(int j, const Points& dv, const Points& of_shell)>& consume,
                     double tolerance = 1e-11, const Points* surface = nullptr, const Eigen::VectorXd* x = nullptr);

/// Physical values with names of the shape variables, for programs (`parameter_values` has the others).
std::vector<std::pair<std::string, double>> physical_values(const DesignSpace& space, const Eigen::VectorXd& x);

inline bool is_load(VariableKind kind) { return kind == VariableKind::load || kind == VariableKind::normal_load; }

}  // namespace strake
