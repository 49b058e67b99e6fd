#pragma once
#include "casefile/model/built_in.hpp"
#include "casefile/yaml/diagnostics.hpp"
#include "core/fields/field_functions.hpp"
#include "core/fields/invariance.hpp"
#include "core/patches/hierarchy.hpp"
#include "core/planform/planform_motion.hpp"
#include "core/primo/shell.hpp"
#include "core/remesh/remesh.hpp"
#include "core/repair/repair.hpp"
#include "core/wrap/wrap_binding.hpp"
#include "objectives/geometry/section_area.hpp"
#include "objectives/geometry/thickness.hpp"
#include "optimize/problem/problem.hpp"

#include <array>
#include <filesystem>
#include <memory>
#include <variant>

/// A case file as written, checked and with its units resolved: lengths in the surface's unit (or relative to
/// the diagonal), angles in radians, times in seconds, paths relative to the working directory or absolute. The keys,
/// their defaults and limits are in the tables of casefile/schema/; docs/cases.md is generated from them.
namespace strake {

enum class KeptRules : int;  // core/planform/kept_sections.hpp

/// A length: in the surface's unit, or a fraction of the diagonal of its bounding box.
struct Length {
    double value = 0;
    bool is_relative_to_diagonal = false;
    double in(double diagonal) const { return is_relative_to_diagonal ? value * diagonal : value; }
};

/// Repairs before anything else; the lengths of `options` are stated separately.
struct RepairEntry {
    RepairOptions options;
    bool all = false;
    std::optional<Length> weld, cracks, holes, joints;
    Place place;
};
struct RemeshEntry {
    RemeshOptions options;
    std::optional<Length> edge_length, chord_error, shortest_edge;
    Place place;
};

struct BoxShape {
    Eigen::Vector3d min, max;
};
struct SphereShape {
    Eigen::Vector3d center;
    Length radius;
};
struct HalfSpace {
    Eigen::Vector3d normal;  ///< unit
    double offset = 0;
    bool above = true;  ///< normal . x >= offset
};
struct SolidShape {
    std::string name;
};  ///< part named in the surface file
struct ComponentShape {
    int number = 0;
};  ///< edge-connected, in the order of the smallest triangle
struct PatchShape {
    std::string name;
};  ///< on the finest level at which it exists
struct TriangleFile {
    std::filesystem::path file;
};  ///< 0-based numbers in the order of the surface file, one a line

struct RegionFormula {
    std::string formula;
};  ///< names of regions, parts and patches, `all`, joined by + - & and parentheses
struct GrownRegion {
    Reference of;
    Length by;  ///< along edges; negative shrinks
};
struct FloodedRegion {
    std::optional<int> triangle;                      ///< number in the surface file
    Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< without a number: from the triangle nearest to it
    double angle = 0;                                 ///< edges of a larger dihedral angle are not crossed, radians
};
struct NearRegion {
    Reference of;
    Length within;  ///< straight
};
struct FacingDirection {
    Eigen::Vector3d direction;  ///< unit
    double within = 0;          ///< largest angle between it and the normal, radians, not itself included
};

/// A part of a declared wing.
struct WingRegion {
    Reference of;
    std::array<double, 2> chord{0, 1}, span{0, 1};                  ///< fractions of the chord and of the semispan
    int side = 0;                                                   ///< 1: upper, -1: lower, 0: both
    enum class Edge { none, leading, trailing } edge = Edge::none;  ///< in place of `chord`
};

struct Region {
    std::string name;
    std::variant<BoxShape, SphereShape, HalfSpace, SolidShape, ComponentShape, PatchShape, TriangleFile, RegionFormula,
                 GrownRegion, FloodedRegion, NearRegion, FacingDirection, WingRegion>
        shape;
    bool touches = false;  ///< box, sphere, half space: any point inside is enough; near: one vertex
    Place place;           ///< of the name
    Place shape_place;     ///< of the shape's key
};

/// A wing: its planform is measured by sections along the span.
struct WingEntry {
    std::string name;
    Place place;
    std::optional<Reference> on;                      ///< a region, part or patch; nothing: the whole surface
    Eigen::Vector3d span = Eigen::Vector3d::UnitY();  ///< unit
    std::vector<double> stations;                     ///< fractions of the semispan; empty: kinks
    double axis = 0.25;                               ///< fraction of the chord
    std::optional<Reference> behind;                  ///< the wing ahead of it, for gap and overlap
    std::vector<double> grid_span, grid_chord;        ///< of thickness_grid and others
    std::array<double, 2> box_span{}, box_chord{};    ///< of box_volume
    std::vector<Reference> values;                    ///< to record
    bool keeps_outline = true;                        ///< loads, strains and fields leave its edges where they are
    WingRules rules = WingRules::latest;              ///< of a run that began so
};

/// A body by its length, under planform, too.
struct FuselageEntry {
    std::string name;
    Place place;
    std::optional<Reference> on;                        ///< as of a wing
    Eigen::Vector3d length = Eigen::Vector3d::UnitX();  ///< unit, from nose to tail
    std::vector<double> stations;                       ///< fractions of the length; empty: five
    std::vector<Reference> values;                      ///< to record
};

struct LoadEntry {
    Reference region;
    Place place;
    std::optional<Eigen::Vector3d> traction;  ///< force per area, 1/length
    std::optional<Eigen::Vector3d> force;     ///< total over the region, length
    std::optional<Length> displacement;       ///< target for the maximum displacement of the linear response
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit, with `displacement`
    std::optional<double> spring;                         ///< lambda_A of this region, 1/length^2
};

struct StrainEntry {
    Reference region;
    Place place;
    std::array<Length, 3> translate;
    Eigen::Vector3d rotate = Eigen::Vector3d::Zero();  ///< rotation vector, radians
    std::optional<Eigen::Vector3d> about;              ///< default: the region's area centroid
};

/// A part that moves with another one.
struct AttachEntry {
    Reference part, to;  ///< a region, a part that the surface file names, or the number of a connected component
    AttachHow how = AttachHow::rigid;
};

struct ThicknessEntry {
    Reference region;
    Length height;
};

struct NearPoint {
    Eigen::Vector3d point;
};
struct SplitEntry {
    enum class Kind { all, largest, containing, sensitivity, gradient } kind = Kind::all;
    int largest = 1;
    std::vector<std::pair<std::variant<int, NearPoint>, Place>>
        containing;  ///< triangle number, or the triangle nearest
};

/// A user-defined shape variable.
struct UserVariableEntry {
    enum class Kind { load, normal_load, translate, rotate, twist } kind = Kind::load;
    std::string name;
    Place place;
    std::optional<Reference> region;                       ///< a region or patch; a twist without it: the whole surface
    Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit: of the traction, the translation or the axis
    std::optional<Eigen::Vector3d> about;                  ///< a point on the axis; without it the area centroid
    std::optional<Length> max_displacement;
    std::optional<double> max_angle;  ///< radians
    int num_stations = 3;             ///< of a twist
    std::vector<double> stations;     ///< of a twist, along the axis from `about`; empty: num_stations
    bool is_motion() const { return kind == Kind::translate || kind == Kind::rotate; }
};

/// What keeps the body in its place.
struct HoldEntry {
    enum class By { fixed, point, none };
    By by = By::fixed;
    std::optional<Eigen::Vector3d> point;
    bool rounding_breaks_ties = false;  ///< the meaning of earlier runs: between triangles as near to the point
    Place place;
};

/// Displacement fields.
struct FieldsEntry {
    /// automatic: of a wing that is declared, keeps its planform and alone may move, by values alone, where nothing is
    /// stated that sections alone have.
    enum class Kind { automatic, sections, wing };
    bool is_wanted = false;
    int number = 0;  ///< 0: automatic
    std::optional<Reference> on;
    std::optional<Eigen::Vector3d> axis;  ///< unit
    std::vector<std::string> motions;     ///< empty: all
    AlongAxis along = AlongAxis::polynomials;
    Kind kind = Kind::automatic;
    bool are_sections_by_default = false;  ///< what `automatic` means to a run that began so
    bool axis_by_extent_alone = false;     ///< `FieldOptions`: of a run that began so
    bool products_as_before = false;       ///< the same
    bool are_offered_by_steps = false;     ///< `Parameters`: of a run that began so
    Place place;
};

/// What a wing may change by.
struct PlanformRangeEntry {
    std::string wing;
    PlanformRange range;  ///< but for the number of the wing
    Place place;
};

/// A motion limit of a region.
struct MotionLimitEntry {
    Reference region;
    std::optional<Length> inward, outward;  ///< without one: that outside the regions
};

struct ParameterEntry {
    std::vector<double> levels_deg;      ///< empty: automatic
    double min_patch_percent = 0;        ///< with given levels
    std::vector<int> patches_per_level;  ///< with automatic levels; empty: the default
    bool patches_are_stated = false;     ///< `patches_per_level` stands in the case
    double sharp_angle_deg = 40;
    std::vector<VariableKind> variables;
    std::vector<PlanformRangeEntry> planform;
    Length max_displacement;  ///< outside of `max_displacement_by_region`
    Place max_displacement_place;
    std::vector<MotionLimitEntry> max_displacement_by_region;
    bool is_limit_stated = false;           ///< in the file, not by default
    bool limits_variables = false;          ///< as `Parameters::limits_variables`: of a run that began so
    bool counts_kept_motion_alone = false;  ///< the same
    bool lets_edges_fold = false;           ///< the same
    KeptRules kept_rules{};                 ///< the same; by default the latest
    StationCorners station_corners{};       ///< the same
    std::optional<Length> variable_scale;
    bool strain_rotates = true, strain_translates = true;  ///< with strain variables
    double free_border = 0.4;
    std::vector<Eigen::Vector3d> directions;  ///< unit, of load variables; empty: x, y, z
    SplitEntry split;
    double marking_fraction = 0.9, max_variable_ratio = 8;
    std::vector<Reference> variables_on;         ///< regions or patches; empty: everywhere
    std::vector<Reference> frozen;               ///< regions or patches; empty: none
    std::vector<std::vector<Reference>> groups;  ///< regions or patches
    bool mirror = false;
    Place mirror_place;
    std::vector<UserVariableEntry> user_variables;
    FieldsEntry fields;
    bool keeps_smooth_border = false;
    bool lets_border_turn = false;  ///< as `Parameters::lets_border_turn`

    /// Then the motion limit limits nothing: planform variables move its datum, too.
    bool is_planform_alone() const {
        return !planform.empty() && variables.empty() && user_variables.empty() && !fields.is_wanted;
    }
};

struct ProgramParameterEntry {
    ProgramParameter variable;
    Place place;
};

struct TargetShapeEntry {
    std::filesystem::path file;
    bool same_connectivity = false;
};
struct MeasuredPointsEntry {
    std::filesystem::path file;
};
struct LineThicknessEntry {
    std::vector<ThicknessLine> lines;  ///< read with the case: the names of the values depend on them
    ThicknessValues values = ThicknessValues::each;
};
struct SectionAreaEntry {
    Section section;
};
struct ExternalEntry {
    std::vector<std::string> command, outputs;
    double timeout_s = 3600;
    std::string format;  ///< empty: the format of the surface file
    bool has_gradients = true;
    std::vector<std::string> gradient_command;
    std::optional<double> gradient_timeout_s;
    std::filesystem::path gradient_points;  ///< empty: none
    Place gradient_points_place;
    Length support_radius{1, true};
    struct Plugin {
        std::filesystem::path library;
        std::string options;
    };
    std::optional<Plugin> plugin;                      ///< in place of a command
    std::optional<std::vector<Reference>> depends_on;  ///< variables; nothing: all of them
    int retries = 0;
    enum class OnFailure { abort, value, shrink_step } on_failure = OnFailure::abort;
    double value_after_failure = 0;
    int parallel = 1;
    std::optional<std::vector<std::string>> slurm;  ///< options of sbatch
    double queue_s = 7 * 86400.0, poll_s = 2;
    std::filesystem::path cache;  ///< empty: none
    std::vector<std::filesystem::path> cache_files;
    std::filesystem::path convergence;  ///< in the folder of each call; empty: none
    Place low_fidelity_place;
    /// Cheap values beside its own: output (empty: all, those of the same names) and value.
    std::vector<std::pair<Reference, Reference>> low_fidelity;
};
/// A formula of other values.
struct FormulaEntry {
    Reference text;                    ///< as written
    std::vector<std::string> of = {};  ///< values and variables in it
    std::function<double(const Eigen::VectorXd&, Eigen::VectorXd*)> value = {};
};
struct VolumeEntry {};
struct AreaEntry {};
struct QuantityEntry {
    std::string name;
    Place place;
    std::variant<VolumeEntry, AreaEntry, TargetShapeEntry, MeasuredPointsEntry, LineThicknessEntry, SectionAreaEntry,
                 ExternalEntry, BuiltInEntry, FormulaEntry>
        what;
    std::vector<std::string> value_names() const;
};

struct ConstraintEntry {
    Constraint constraint;
    Place place;
};

enum class ParaView { every_accepted, best, none };
enum class Keep { all, failed, best, none };

/// What is elastic in the place of the body.
struct WrapEntry {
    std::optional<Length> alpha, offset, edge_length;    ///< without alpha: auto
    RadialSums sums = RadialSums::by_boxes;              ///< `WrapBindingOptions`: of a run that began so
    int max_centers = WrapBindingOptions().max_centers;  ///< the same
    Place place;
};

struct Case {
    std::filesystem::path file;  ///< the case file, as it was given
    std::string name;
    std::filesystem::path surface;
    Place surface_place;
    std::string units;  ///< of length: m, cm, mm, um, in, ft; empty: not stated
    std::optional<RepairEntry> repair;
    std::optional<RemeshEntry> remesh;
    std::vector<Region> regions;
    std::vector<Reference> fixed;
    Place fixed_place;
    HoldEntry hold;
    std::optional<ShapeKind> invariance;
    Place invariance_place;
    std::optional<SymmetryPlane> symmetry;
    Place symmetry_place;
    std::optional<Length> symmetry_snap;  ///< open edges so near to the plane are moved onto it
    std::vector<WingEntry> planform;
    std::vector<FuselageEntry> bodies;
    AeroGround aero;  ///< axes and coefficients; its plane is `symmetry`
    Length thickness;
    Place thickness_place;
    std::vector<ThicknessEntry> thickness_by_region;
    double spring = 0;      ///< lambda_A under loaded regions that state none
    bool has_shell = true;  ///< false: `shell: none`
    Place shell_place;
    std::optional<WrapEntry> wrap;
    bool couple_nonmanifold = false;
    LinearSolver solver = LinearSolver::automatic;
    std::vector<LoadEntry> loads;
    std::vector<StrainEntry> strains;
    std::vector<AttachEntry> attach;
    ParameterEntry parameters;
    Place parameters_place;
    std::vector<ProgramParameterEntry> variables;
    std::vector<QuantityEntry> quantities;  ///< declared ones, then built-in ones that are used without an entry
    Reference objective;                    ///< empty name: none
    bool maximize = false;
    std::vector<Reference> fit;
    std::vector<ConstraintEntry> constraints;
    OptimizeOptions optimize;
    std::optional<std::filesystem::path> start_from;  ///< folder of a run
    Place start_place;
    std::optional<Spread> sample;  ///< designs are spread instead of searched
    std::optional<std::filesystem::path> sample_table;
    Place sample_place;
    FitOptions fitting;              ///< without the scale
    Length loss_scale{0.001, true};  ///< of `fitting`
    struct Output {
        std::filesystem::path dir;  ///< may be set before the problem is built
        ParaView paraview = ParaView::every_accepted;
        Keep keep = Keep::all;          ///< folders of evaluations
        bool report = true;             ///< report.html at the end
        bool report_is_stated = false;  ///< in the file, not by default
        bool is_resumed = false;        ///< the folder is that of a run that continues
        bool by_hand = false;           ///< programs are not run: their folders are handed out (`strake step`)
    } output;
    /// Asked while the surface is remeshed; true ends that by throwing Interrupted. Set by the caller.
    std::function<bool()> stop_wanted;
    /// {case_dir} of commands; empty: the folder of the case file. A run that continues reads another file than it
    /// began with.
    std::filesystem::path command_dir;

    /// Folder of the case file, "." when it was named without one.
    std::filesystem::path dir() const { return file.has_parent_path() ? file.parent_path() : "."; }

    std::vector<std::string> notes;  ///< about old names in the file: "case.yaml:14:5: note: ..."

    struct Source;  ///< the checked tree, for messages and for `resolved_case`
    std::shared_ptr<const Source> source;
};

/// What a command needs of the case: `run` an objective, `fit` a fit, `deform` neither.
enum class Purpose { any, deform, run, fit };

/// A collector for further errors about this case (used while the problem is built).
Diagnostics diagnostics_of(const Case& the_case);

/// Names of all values that objective, fit and constraints may use, `volume` and `area` included.
std::vector<std::string> known_values(const Case& the_case);

/// The body's axes: the case's, or those of its first quantity with a stream (assumed unless `is_stated`), `up` made
/// perpendicular. Nothing where the case has neither.
std::optional<BodyAxes> body_axes(const Case& the_case);

}  // namespace strake
