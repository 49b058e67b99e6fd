#pragma once
#include "cases/diagnostics.hpp"
#include "cases/made_quantity.hpp"
#include "core/patches/hierarchy.hpp"
#include "core/primo/shell.hpp"
#include "core/remesh/remesh.hpp"
#include "core/repair/repair.hpp"
#include "objectives/section_area.hpp"
#include "objectives/thickness.hpp"
#include "optimize/problem.hpp"

#include <array>
#include <filesystem>
#include <memory>
#include <variant>

/// A case file as written, checked and with its units resolved: lengths in the surface's unit (or relative to
/// the diagonal), angles in radians, times in seconds, paths relative to the working directory or absolute. The keys,
/// their defaults and limits stand in the tables of cases/schema_*.cpp; docs/cases.md is made from it.
namespace strake {

/// A length: in the surface's unit, or a fraction of the diagonal of its bounding box.
struct Length {
    double value = 0;
    bool is_relative_to_diagonal = false;
    double in(double diagonal) const { return is_relative_to_diagonal ? value * diagonal : value; }
};

/// What is mended before anything else; the lengths of `options` are those beside it.
struct RepairEntry {
    RepairOptions options;
    bool all = false;
    std::optional<Length> weld, cracks, holes;
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

struct Region {
    std::string name;
    std::variant<BoxShape, SphereShape, HalfSpace, SolidShape, ComponentShape, PatchShape, TriangleFile> shape;
    Place place;        ///< of the name
    Place shape_place;  ///< of the shape's key
};

struct LoadEntry {
    Reference region;
    Place place;
    std::optional<Eigen::Vector3d> traction;              ///< force per area, 1/length
    std::optional<Eigen::Vector3d> force;                 ///< total over the region, length
    std::optional<Length> displacement;                   ///< wanted largest displacement by the linear response
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

/// A part that goes with another one.
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

/// A shape variable of the user's own.
struct GivenEntry {
    enum class Kind { load, load_normal, translate, rotate, twist } kind = Kind::load;
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

struct ParameterEntry {
    std::vector<double> levels_deg;      ///< empty: automatic
    double min_patch_percent = 0;        ///< with given levels
    std::vector<int> patches_per_level;  ///< with automatic levels; empty: the default
    double sharp_angle_deg = 40;
    std::vector<VariableKind> variables;
    Length max_displacement;
    bool strain_rotates = true, strain_translates = true;  ///< with strain variables
    double core = 0.4;
    std::vector<Eigen::Vector3d> directions;  ///< unit, of load variables; empty: x, y, z
    SplitEntry split;
    double split_share = 0.9, growth = 8;
    std::vector<Reference> on;                   ///< regions or patches; empty: everywhere
    std::vector<Reference> freeze;               ///< likewise; empty: nothing
    std::vector<std::vector<Reference>> groups;  ///< likewise
    bool mirror = false;
    Place mirror_place;
    std::vector<GivenEntry> given;
};

struct OwnVariableEntry {
    OwnVariable variable;
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
    std::vector<std::string> command, gives;
    double timeout_s = 3600;
    std::string format;  ///< empty: the format of the surface file
    bool has_gradients = true;
    std::vector<std::string> gradient_command;
    std::optional<double> gradient_timeout_s;
    std::filesystem::path gradient_points;  ///< empty: none
    Place gradient_points_place;
    Length points_reach{1, true};
    struct Plugin {
        std::filesystem::path library;
        std::string options;
    };
    std::optional<Plugin> plugin;                      ///< in place of a command
    std::optional<std::vector<Reference>> depends_on;  ///< own variables; without it all
    int retries = 0;
    enum class OnFailure { abort, value, shrink_step } on_failure = OnFailure::abort;
    double value_after_failure = 0;
    int parallel = 1;
    std::optional<std::vector<std::string>> slurm;  ///< options of sbatch
    double queue_s = 7 * 86400.0, poll_s = 2;
    std::filesystem::path cache;  ///< empty: none
    std::vector<std::filesystem::path> cache_files;
};
/// A formula of other values.
struct FormulaEntry {
    Reference text;                    ///< as written
    std::vector<std::string> of = {};  ///< values and own variables in it
    std::function<double(const Eigen::VectorXd&, Eigen::VectorXd*)> value = {};
};
struct VolumeEntry {};
struct AreaEntry {};
struct QuantityEntry {
    std::string name;
    Place place;
    std::variant<VolumeEntry, AreaEntry, TargetShapeEntry, MeasuredPointsEntry, LineThicknessEntry, SectionAreaEntry,
                 ExternalEntry, MadeQuantity, FormulaEntry>
        what;
    std::vector<std::string> value_names() const;
};

struct ConstraintEntry {
    Constraint constraint;
    Place place;
};

enum class ParaView { every_accepted, best, none };
enum class Keep { all, failed, best, none };

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
    std::optional<SymmetryPlane> symmetry;
    Place symmetry_place;
    Length thickness;
    std::vector<ThicknessEntry> thickness_by_region;
    double spring = 0;  ///< lambda_A over loaded regions without an own one
    bool couple_nonmanifold = false;
    LinearSolver solver = LinearSolver::automatic;
    std::vector<LoadEntry> loads;
    std::vector<StrainEntry> strains;
    std::vector<AttachEntry> attach;
    ParameterEntry parameters;
    Place parameters_place;
    std::vector<OwnVariableEntry> variables;
    std::vector<QuantityEntry> quantities;  ///< declared ones, then built-in ones that are used without an entry
    Reference objective;                    ///< empty name: none
    bool maximize = false;
    std::vector<Reference> fit;
    std::vector<ConstraintEntry> constraints;
    OptimizeOptions optimize;
    std::optional<std::filesystem::path> start_from;  ///< folder of a run
    Place start_place;
    FitOptions fitting;              ///< without the scale
    Length loss_scale{0.001, true};  ///< of `fitting`
    struct Output {
        std::filesystem::path dir;  ///< may be set by the program before the problem is built
        ParaView paraview = ParaView::every_accepted;
        Keep keep = Keep::all;  ///< folders of evaluations
        bool report = false;    ///< report.html at the end
        bool goes_on = false;   ///< the folder is that of a run which goes on
        bool by_hand = false;   ///< programs are not run: their folders are handed out (`strake step`)
    } output;
    /// Asked while the surface is remeshed; true ends that by throwing Interrupted. May be set by the program.
    std::function<bool()> stop_wanted;
    /// {case_dir} of commands; empty: the folder of the case file. A run that goes on reads another file than it began
    /// with.
    std::filesystem::path command_dir;

    /// Folder of the case file, "." when it was named without one.
    std::filesystem::path dir() const { return file.has_parent_path() ? file.parent_path() : "."; }

    struct Source;  ///< the checked tree, for messages and for `resolved_case`
    std::shared_ptr<const Source> source;
};

/// What a command needs of the case: `run` an objective, `fit` a fit, `deform` neither.
enum class Purpose { any, deform, run, fit };

/// Reads and checks a case file without reading the surface. @throws CaseError with all that is wrong.
Case load_case(const std::filesystem::path& file, Purpose purpose = Purpose::any);
/// The same, where {case_dir} of commands stays another folder than the file's: a run that goes on.
Case load_case(const std::filesystem::path& file, Purpose purpose, const std::filesystem::path& command_dir);

/// The case with every default filled in, as YAML text that gives the same case when it is loaded from `folder`
/// (files there and not there are named by absolute paths where they lie outside of it).
std::string resolved_case(const Case& the_case, const std::filesystem::path& folder);

/// Files that the case names (not the programs), as seen from the working directory, by the path of their key; with
/// `optimize.start_from` the design that it begins with.
std::vector<std::pair<std::string, std::filesystem::path>> files_of(const Case& the_case);

/// Keys, as "optimize.method", in which two texts that `resolved_case` gave differ; sorted.
/// @throws CaseError where one of them is no YAML.
std::vector<std::string> changed_keys(const std::string& before, const std::string& now);
/// What is free to change in a run that goes on: budget, output, timeouts.
bool may_change(const std::string& key);

/// A collector for further errors about this case (used while the problem is built).
Diagnostics diagnostics_of(const Case& the_case);

}  // namespace strake
