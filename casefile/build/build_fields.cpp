#include "casefile/build/problem_builder.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/fields/invariance.hpp"
#include "core/fields/wing_coordinates.hpp"
#include "core/mesh/geometry.hpp"
#include "core/planform/find_wings.hpp"
#include "core/planform/wing_lines.hpp"
#include "optimize/run/stored_design.hpp"
#include "optimize/space/field_conditions.hpp"

#include <algorithm>
#include <limits>
#include <span>

namespace strake {
namespace {

/// Sections moved, turned, scaled and sheared up to degree two along the axis; then to higher ones.
constexpr double invariance_tolerance = 1e-6;  ///< of the start, in diagonals: ten times what single precision leaves
constexpr std::array automatic_steps{27, 60, 192};
/// Of a wing that keeps its planform, and that twist by station comes beside: as many as few evaluations can use.
constexpr std::array steps_of_kept_wing{24, 60, 192};
/// Of shapes that are the same around an axis: there are fewer of a degree.
constexpr std::array steps_about_axis{12, 27, 60};
/// Knots are halved from level to level.
constexpr std::array spline_steps{12, 24, 48, 96, 192, 384};

/// More of a section's half thickness than this, and its sides cross.
constexpr double thinning = 0.6;
constexpr double same_distance = 1e-6;  ///< in diagonals

/// By its centroid. On a symmetric body two are often as near to its middle, in one unit of length the one by rounding,
/// in another the other: of those within `tie` of the nearest the one farthest along x counts, then along y and z.
int nearest_triangle(const TriMesh& mesh, const std::vector<int>& part, const Eigen::Vector3d& near, double tie) {
    Points centre(mesh.num_triangles(), 3);
    for (const int t : part) centre.row(t) = area_centroid(mesh, {t});
    std::vector<int> nearest;
    const auto keep_smallest = [&](const std::vector<int>& from, const auto& measure) {
        double least = std::numeric_limits<double>::infinity();
        for (const int t : from) least = std::min(least, measure(t));
        nearest.clear();
        std::ranges::copy_if(from, std::back_inserter(nearest), [&](int t) { return measure(t) <= least + tie; });
    };
    keep_smallest(part, [&](int t) { return (centre.row(t).transpose() - near).norm(); });
    for (int axis = 0; axis < 3 && tie > 0; ++axis)
        keep_smallest(std::vector<int>(nearest), [&](int t) { return -centre(t, axis); });
    return nearest.front();
}

constexpr double same_direction = 1e-6;

/// Triangles that are neither of the wing nor held.
std::vector<int> free_beside(const Wing& wing, const std::vector<int>& held, int num_triangles) {
    std::vector<char> marks(static_cast<std::size_t>(num_triangles), 1);
    for (int side = 0; side < wing.num_sides(); ++side)
        for (const int t : wing.triangles(side)) marks[static_cast<std::size_t>(t)] = 0;
    for (const int t : held) marks[static_cast<std::size_t>(t)] = 0;
    std::vector<int> rest;
    for (int t = 0; t < num_triangles; ++t)
        if (marks[static_cast<std::size_t>(t)]) rest.push_back(t);
    return rest;
}

/// A field that changes thickness has a range of its own where the wing is thinner than the motion limit is wide.
void limit_thickness(const WingLines& lines, double diagonal, Parameters& parameters) {
    double sum = 0;
    for (const auto& section : lines.sections) sum += 0.5 * section.thickness;
    const double limit = thinning * sum / static_cast<double>(lines.sections.size()) / diagonal;
    const double unit = parameters.variable_scale > 0 ? parameters.variable_scale : parameters.max_displacement;
    for (UserVariable& variable : parameters.user_variables)
        if (variable.field >= 0 && motion_of(variable.name) == "thickness" && limit < unit)
            variable.max_displacement = limit;
}

}  // namespace

void ProblemBuilder::set_invariance() {
    if (!case_.invariance) return;
    at(case_.invariance_place, "", [&] {
        out_.problem.parameters.invariance =
            std::make_shared<const Invariance>(start_.mesh, *case_.invariance, invariance_tolerance, case_.symmetry);
        out_.problem.parameters.invariance->check_held(start_.mesh, out_.problem.fixed);
    });
    if (!out_.problem.attached.empty())
        errors_.add(case_.attach.front().part.place,
                    "attach: attached parts follow their hosts and keep no kind of shape; remove attach or invariance");
    const auto& kinds = case_.parameters.variables;
    if (std::find(kinds.begin(), kinds.end(), VariableKind::strain) != kinds.end())
        errors_.add(case_.invariance_place,
                    "invariance: strain variables move patches as rigid bodies, which no extruded, revolved or cyclic "
                    "shape does; use fields, load or normal in parameters.variables");
}

/// Of a part: the triangle that holds the shell. Nearest to the point that was stated, else to the middle of the part,
/// in half models of what of it lies on the plane.
int ProblemBuilder::support_near(const std::vector<int>& part) const {
    const TriMesh& mesh = elastic().mesh;
    Eigen::Vector3d near = Eigen::Vector3d::Zero();
    if (case_.hold.point) {
        near = *case_.hold.point;
    } else {
        double weight = 0;
        for (const bool only_cut : {true, false}) {
            for (const int t : part)
                for (int k = 0; k < 3; ++k) {
                    const Eigen::Vector3d x = mesh.vertices.row(mesh.triangles(t, k));
                    if (only_cut && !(case_.symmetry && std::abs(case_.symmetry->normal.dot(x) -
                                                                 case_.symmetry->offset) < 1e-6 * start_.diagonal))
                        continue;
                    const double area = area_vector(mesh, t).norm();
                    near += area * x;
                    weight += area;
                }
            if (weight > 0) break;
        }
        near /= weight;
    }
    return nearest_triangle(mesh, part, near, case_.hold.rounding_breaks_ties ? 0 : same_distance * start_.diagonal);
}

/// hold: point and none take the place of everything else that keeps the body where it is.
void ProblemBuilder::check_hold() {
    const char* word = case_.hold.by == HoldEntry::By::none ? "none" : "point";
    const auto rival = [&](const Place& place, const char* key) {
        errors_.add(place, text(key, " and hold: ", word, " exclude each other; remove one of them"));
    };
    if (!case_.fixed.empty()) rival(case_.fixed_place, "fixed");
    if (!case_.strains.empty()) rival(case_.strains.front().place, "strains");
    if (purpose_ == Purpose::deform || !errors_.empty()) return;
    if (!case_.parameters.fields.is_wanted && case_.parameters.planform.empty() && case_.hold.by == HoldEntry::By::none)
        errors_.add(
            case_.hold.place,
            "hold: none leaves the shell without a support; use displacement fields (parameters: {fields: auto, "
            "variables: []}), or hold: point");
    else if (case_.hold.by == HoldEntry::By::none && (!case_.parameters.variables.empty() || !case_.loads.empty()))
        errors_.add(case_.hold.place,
                    text("hold: none: ", case_.loads.empty() ? "the variables of patches" : "loads",
                         " need something to act against; write parameters.variables: [] and no loads, or hold: "
                         "point"));
}

void ProblemBuilder::set_hold() {
    if (case_.hold.by == HoldEntry::By::fixed) return;
    check_hold();
    if (!errors_.empty()) return;
    const std::vector<int> number = edge_components(elastic().mesh, elastic().adjacent);
    std::vector<char> is_attached(number.size(), 0);
    for (const AttachedPart& part : out_.problem.attached)
        for (const int t : part.triangles) is_attached[static_cast<std::size_t>(t)] = 1;
    std::map<int, std::vector<int>> parts;
    for (std::size_t t = 0; t < number.size(); ++t)
        if (!is_attached[t]) parts[number[t]].push_back(static_cast<int>(t));
    for (const auto& [which, part] : parts) out_.problem.supports.push_back(support_near(part));
    std::sort(out_.problem.supports.begin(), out_.problem.supports.end());
}

/// What looks like a wing on a surface that declares none.
std::optional<FoundWing> ProblemBuilder::wing_seen() const {
    constexpr int max_searched = 400000;  // triangles
    if (wrap_ || start_.mesh.num_triangles() > max_searched) return {};
    WingSearch search{{}, {}, case_.symmetry};
    if (const auto& axes = case_.aero.axes; axes && axes->is_stated)
        search.downstream = axes->downstream, search.up = axes->up;
    return find_wing(start_.mesh, search);
}

/// By default where they were measured to be better: of a declared wing that keeps its planform, by values alone; and
/// only where nothing is said that sections alone have, and where a run has none to keep.
bool ProblemBuilder::wants_fields_of_wing() const {
    using Kind = FieldsEntry::Kind;
    const FieldsEntry& entry = case_.parameters.fields;
    if (entry.kind != Kind::automatic) return entry.kind == Kind::wing;
    if (entry.axis || !entry.motions.empty() || entry.along != AlongAxis::polynomials) return false;
    if (entry.are_sections_by_default || case_.invariance || !case_.fit.empty()) return false;
    if (case_.planform.size() != 1 || !case_.planform.front().keeps_outline || !keeps_edges()) return false;
    const bool by_values = std::ranges::any_of(case_.quantities, [](const QuantityEntry& quantity) {
        const auto* program = std::get_if<ExternalEntry>(&quantity.what);
        return program && !program->has_gradients;
    });
    if (!by_values) return false;
    return !stored_ || std::ranges::none_of(stored_->given, [](const auto& given) {
        return given.second != 0 && (given.first.starts_with("section.") || given.first.starts_with("polynomial."));
    });
}

/// The wing whose coordinates the fields have: the one that is declared, else what looks like one. What is not of the
/// wing becomes held. @throws InvalidInput where there is none.
ProblemBuilder::FieldsOfWing ProblemBuilder::fields_of_wing(FieldConditions& conditions) {
    const bool is_stated = case_.parameters.fields.kind == FieldsEntry::Kind::wing;
    if (case_.planform.size() > 1)
        throw InvalidInput(text("planform declares ", case_.planform.size(), " wings; fields are those of one"));
    FieldsOfWing result;
    std::shared_ptr<const Wing> wing;
    std::string seen;
    if (case_.planform.empty()) {
        const auto found = wing_seen();
        if (!found) throw InvalidInput("nothing of the surface looks like a wing; declare it under planform");
        wing = std::make_shared<const Wing>(start_.mesh, found->declaration);
        seen = found->why;
    } else {
        wing = wings_.at(case_.planform.front().name);
        result.keeps_planform = case_.planform.front().keeps_outline && keeps_edges();
    }
    const std::optional<SymmetryPlane>& plane = conditions.cut ? conditions.cut : conditions.mirror;
    if (plane && plane->normal.cross(wing->span(0)).norm() > same_direction)
        throw InvalidInput("the plane of symmetry is not normal to the span of the wing");
    const std::vector<int> rest = free_beside(*wing, conditions.held, start_.mesh.num_triangles());
    if (!rest.empty() && !is_stated) throw InvalidInput("a body moves, too");
    result.wing = std::make_shared<const WingCoordinates>(wing_lines(start_.mesh, *wing));
    conditions.held.insert(conditions.held.end(), rest.begin(), rest.end());
    std::sort(conditions.held.begin(), conditions.held.end());
    if (!seen.empty())
        out_.notes.push_back(text("parameters.fields: those of a wing, which the surface looks like (", seen,
                                  "); kind: sections has the others"));
    return result;
}

/// Where they are not asked for, sections serve where there is no wing.
ProblemBuilder::FieldsOfWing ProblemBuilder::chosen_fields_of_wing(FieldConditions& conditions) {
    if (!wants_fields_of_wing()) return {};
    try {
        return fields_of_wing(conditions);
    } catch (const InvalidInput& e) {
        if (case_.parameters.fields.kind == FieldsEntry::Kind::wing)
            throw InvalidInput(text("kind: wing: ", e.what(), "; or write kind: sections"));
        return {};
    }
}

void ProblemBuilder::set_fields() {
    const FieldsEntry& entry = case_.parameters.fields;
    Parameters& p = out_.problem.parameters;
    std::vector<char> on = p.variables_on;
    if (wrap_) on = marked_on_surface("parameters.variables_on", case_.parameters.variables_on);
    if (entry.on) on = marked_on_surface("parameters.fields.on", {*entry.on});
    if (!errors_.empty()) return;
    FieldConditions conditions = field_conditions(out_.problem, start_.mesh, on);
    if (case_.hold.by == HoldEntry::By::point)
        conditions.still = case_.hold.point.value_or(area_centroid(elastic().mesh, out_.problem.supports));
    const bool is_about_axis = case_.invariance && case_.invariance->type != ShapeKind::Type::extruded;
    std::span<const int> automatic = entry.along == AlongAxis::splines ? std::span<const int>(spline_steps)
                                     : is_about_axis                   ? std::span<const int>(steps_about_axis)
                                                                       : std::span<const int>(automatic_steps);
    FieldsOfWing of_wing;
    at(entry.place, "parameters.fields: ", [&] { of_wing = chosen_fields_of_wing(conditions); });
    if (!errors_.empty()) return;
    if (of_wing.keeps_planform) automatic = steps_of_kept_wing;
    FieldOptions options;
    options.wing = of_wing.wing;
    options.keeps_planform = of_wing.keeps_planform;
    options.number = entry.number > 0 ? entry.number : automatic.back();
    options.axis = entry.axis;
    options.motions = entry.motions;
    options.along = entry.along;
    options.axis_by_extent_alone = entry.axis_by_extent_alone;
    options.products_as_before = entry.products_as_before;
    at(entry.place, "parameters.fields: ", [&] {
        const auto fields = std::make_shared<const DisplacementFields>(start_.mesh, conditions, options);
        if (entry.number == 0)
            for (const int step : automatic)
                if (p.field_steps.empty() || p.field_steps.back() < fields->size())
                    p.field_steps.push_back(std::min(step, fields->size()));
        add_fields(p, fields);
        if (of_wing.wing) limit_thickness(of_wing.wing->lines(), start_.diagonal, p);
    });
}

}  // namespace strake
