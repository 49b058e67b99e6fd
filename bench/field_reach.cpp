#include "bench/shell_cases.hpp"
#include "cases/geometry/closed_body.hpp"
#include "core/fields/displacement_fields.hpp"
#include "core/fields/typical_motions.hpp"
#include "core/patches/automatic.hpp"
#include "core/planform/find_wings.hpp"
#include "core/planform/wing_lines.hpp"
#include "optimize/space/design_space.hpp"
#include "optimize/space/response_metric.hpp"

#include <fmt/core.h>
#include <Eigen/QR>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <numeric>

/// What displacement fields can make: percent of the squared displacement (by area) of typical motions, on six bodies.
///     field_reach [FOLDER]    with the folder of real surfaces (default: $STRAKE_DATA), two more
///     field_reach --wings [FOLDER]    sections and fields of a wing on three wings: the same, and shapes of airfoils
/// "27+9": the first 27 and the nine of 192 that a refinement takes, each for what it adds to those before. "27+73
/// all": 73 more in the same way, of the fields and of the loads, in x, y and z, on the patches of the automatic
/// levels. Bodies that are symmetric stay so (`mirror: true`; long runs by values find it), their sections follow each
/// other from nose to tail.
namespace {

using namespace strake;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct SampleBody {
    std::string name;
    TriMesh mesh;
    FieldConditions conditions;
    bool has_wings = false;  ///< motions along the span, too: of a body that is about as wide as long
};

/// The triangles of which all corners are in the first 5 % of the extent, of a coarse surface more.
std::vector<int> low_end(const TriMesh& mesh, int axis) {
    const Box box = bounding_box(mesh);
    std::vector<int> held;
    for (double share = 0.05; held.empty(); share += 0.01) {
        const double limit = box.min[axis] + share * (box.max[axis] - box.min[axis]);
        for (int t = 0; t < mesh.num_triangles(); ++t)
            if (mesh.vertices(mesh.triangles.row(t), axis).maxCoeff() <= limit) held.push_back(t);
    }
    return held;
}

std::vector<SampleBody> bodies(const std::string& folder) {
    const SymmetryPlane middle{Vector3d::UnitY(), 0};
    std::vector<SampleBody> all;
    const TriMesh wing = example::wing(5000), body = example::lifting_body(5000), tube = example::tube(4000),
                  fuselage = example::fuselage(4000);
    all.push_back({"wing, root held", wing, {}});
    all.back().conditions.held = low_end(wing, 1);
    all.push_back({"lifting body, nose held", body, {}});
    all.back().conditions.held = low_end(body, 0);
    all.back().conditions.mirror = middle;
    all.push_back({"bent tube, nothing held", tube, {}});
    all.push_back({"fuselage, nose held", fuselage, {}});
    all.back().conditions.held = low_end(fuselage, 0);
    all.back().conditions.mirror = middle;
    if (folder.empty()) return all;
    for (const auto& [file, axis, name] : {std::tuple("oneraM6_su2_surface.stl", 1, "ONERA M6, root held"),
                                           std::tuple("bwb_machline_medium.vtk", 0, "blended wing body, nose held")}) {
        const auto path = std::filesystem::path(folder) / file;
        if (!std::filesystem::exists(path)) continue;
        all.push_back({name, read_surface(path).mesh, {}});
        all.back().conditions.held = low_end(all.back().mesh, axis);
        all.back().has_wings = axis == 0;
        if (axis == 0) all.back().conditions.mirror = middle;
    }
    return all;
}

/// The upper half along the body bends down, and its top rises in the middle.
Points droop(const TriMesh& mesh, const FieldFrame& frame) {
    Points u(mesh.num_vertices(), 3);
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const Vector3d at = frame.local(mesh.vertices.row(v));
        const double s = at[0];
        const double down = std::max(0.0, s) * std::max(0.0, s), r = (s - 0.2) / 0.5;
        const double canopy = std::abs(r) < 1 ? 0.5 * (1 - r * r) * (1 - r * r) * std::max(0.0, at[2]) : 0;
        u.row(v) = (canopy - down) * frame.axes.col(2);
    }
    return u;
}

VectorXd flat_by_area(const TriMesh& mesh, const Points& u) {
    const Points scaled = vertex_areas(mesh).cwiseSqrt().asDiagonal() * u;
    return VectorXd::Map(scaled.data(), scaled.size());
}

double share(const TriMesh& mesh, const DisplacementFields& fields, const Points& wanted, bool is_held) {
    const auto flat = [&](const Points& u) { return flat_by_area(mesh, u); };
    const auto rigid = is_held ? std::vector<Points>{} : rigid_motions(mesh, {});
    MatrixXd columns(3 * mesh.num_vertices(), fields.size() + static_cast<int>(rigid.size()));
    for (int b = 0; b < fields.size(); ++b) columns.col(b) = flat(fields.field(b));
    for (std::size_t k = 0; k < rigid.size(); ++k) columns.col(fields.size() + static_cast<int>(k)) = flat(rigid[k]);
    const VectorXd target = flat(wanted);
    return 1 - (columns * columns.colPivHouseholderQr().solve(target) - target).squaredNorm() / target.squaredNorm();
}

/// With the known columns and some of the others, one after the other that which adds most.
double chosen_share(const MatrixXd& known_columns, MatrixXd others, const VectorXd& target, int more) {
    const Eigen::HouseholderQR<MatrixXd> qr(known_columns);
    const MatrixXd known = qr.householderQ() * MatrixXd::Identity(known_columns.rows(), known_columns.cols());
    others.colwise().normalize();
    VectorXd left = target - known * (known.transpose() * target);
    others -= known * (known.transpose() * others);
    for (int k = 0; k < more; ++k) {
        VectorXd gain = (others.transpose() * left).cwiseAbs2();
        for (Eigen::Index j = 0; j < gain.size(); ++j) {
            const double own = others.col(j).squaredNorm();
            gain[j] = own > 1e-10 ? gain[j] / own : 0;
        }
        Eigen::Index best = 0;
        gain.maxCoeff(&best);
        const VectorXd direction = others.col(best).normalized();
        left -= direction * direction.dot(left);
        others -= direction * (direction.transpose() * others);
    }
    return 1 - left.squaredNorm() / target.squaredNorm();
}

/// What a run may choose from: the first fields, which it has, other fields, and loads on patches of all levels.
class Choice {
public:
    Choice(const SampleBody& body, const DisplacementFields& fields, int first) {
        Problem problem;
        problem.surface = body.mesh;
        problem.tree = segment_automatically(body.mesh, adjacency(body.mesh));
        problem.prism_height = VectorXd::Constant(body.mesh.num_vertices(), 0.02 * box_diagonal(body.mesh));
        problem.fixed = body.conditions.held;
        problem.parameters.mirror = body.conditions.mirror.has_value();
        if (problem.fixed.empty()) {  // hold: point
            const Points centroid = triangle_centroids(body.mesh);
            std::vector<int> all(static_cast<std::size_t>(body.mesh.num_triangles()));
            std::iota(all.begin(), all.end(), 0);
            Eigen::Index nearest = 0;
            (centroid.rowwise() - area_centroid(body.mesh, all).transpose()).rowwise().squaredNorm().minCoeff(&nearest);
            problem.supports = {static_cast<int>(nearest)};
        }
        rest_ = rest_facts(problem);
        std::vector<VectorXd> known, others;
        if (problem.fixed.empty())
            for (const Points& motion : rigid_motions(body.mesh, body.conditions.mirror))
                known.push_back(sampled_motion(*rest_, motion));
        for (int b = 0; b < fields.size(); ++b)
            (b < first ? known : others).push_back(sampled_motion(*rest_, fields.field(b)));
        num_fields_ = others.size();
        for (int level = 1; level < static_cast<int>(rest_->tree->levels.size()); ++level) {
            const MatrixXd of_level = responses_at_rest(design_space(rest_, level)).samples;
            for (Eigen::Index j = 0; j < of_level.cols(); ++j) others.emplace_back(of_level.col(j));
        }
        known_ = joined(known);
        others_ = joined(others);
    }

    double of_fields(const Points& wanted, int more) const {
        return chosen_share(known_, others_.leftCols(num_fields_), sampled_motion(*rest_, wanted), more);
    }
    double of_all(const Points& wanted, int more) const {
        return chosen_share(known_, others_, sampled_motion(*rest_, wanted), more);
    }

private:
    static MatrixXd joined(const std::vector<VectorXd>& columns) {
        MatrixXd all(columns.at(0).size(), static_cast<Eigen::Index>(columns.size()));
        for (std::size_t j = 0; j < columns.size(); ++j) all.col(static_cast<Eigen::Index>(j)) = columns[j];
        return all;
    }

    std::shared_ptr<const RestFacts> rest_;
    MatrixXd known_, others_;
    std::size_t num_fields_ = 0;
};

/// Shapes of airfoils, zero at the root and largest at 0.8 of the semispan, by s and xi of the sections found: a mean
/// line of NACA's four digits with its top at 0.4, more thickness between 0.3 and 0.9 of the chord, a nose that droops
/// from 0.25 of the chord on, a load that is carried aft of 0.6.
std::vector<TypicalMotion> airfoil_motions(const TriMesh& mesh, const FieldConditions& conditions,
                                           const WingCoordinates& wing) {
    const auto squared = [](double t) { return t > 0 ? t * t : 0; };
    const auto rise = [&](const std::string& name, double xi, double eta) {
        xi = std::clamp(xi, 0.0, 1.0);
        if (name == "camber") return xi < 0.4 ? 1 - squared((0.4 - xi) / 0.4) : 1 - squared((xi - 0.4) / 0.6);
        if (name == "thickness")
            return eta * squared(std::sin(std::numbers::pi * std::clamp((xi - 0.3) / 0.6, 0.0, 1.0)));
        if (name == "nose") return -squared((0.25 - xi) / 0.25);
        return 4 * squared((xi - 0.6) / 0.4) * (1 - xi) * (1 + xi);
    };
    std::vector<TypicalMotion> motions;
    for (const char* name : {"camber", "thickness", "nose", "aft load"}) {
        Points u = Points::Zero(mesh.num_vertices(), 3);
        for (int v = 0; v < mesh.num_vertices(); ++v) {
            const WingCoordinates::At at = wing.at(mesh.vertices.row(v));
            u.row(v) = std::sin(std::numbers::pi / 1.6 * std::clamp(at.s, 0.0, 1.0)) * rise(name, at.xi, at.eta) *
                       wing.lines().up;
        }
        for (const int t : conditions.held)
            for (int k = 0; k < 3; ++k) u.row(mesh.triangles(t, k)).setZero();
        motions.push_back({name, u});
    }
    return motions;
}

std::vector<SampleBody> wings(const std::string& folder) {
    std::vector<SampleBody> all{{"wing, root held", example::wing(5000), {}}};
    for (const char* file : {"oneraM6_pyhyp_small.ply", "dpw_w1_pypan.tri"})
        if (const auto path = std::filesystem::path(folder) / file; std::filesystem::exists(path))
            all.push_back({text(file, ", root held"), read_surface(path).mesh, {}});
    return all;
}

std::vector<int> root_of(const TriMesh& mesh, const WingCoordinates& wing) {
    std::vector<int> held;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const auto corner = mesh.triangles.row(t);
        if (std::all_of(corner.begin(), corner.end(), [&](int v) { return wing.at(mesh.vertices.row(v)).s < 0.05; }))
            held.push_back(t);
    }
    return held;
}

/// Sections (s) and fields of a wing (w) of these numbers.
std::vector<DisplacementFields> both_kinds(const SampleBody& body, const std::shared_ptr<const WingCoordinates>& wing) {
    std::vector<DisplacementFields> fields;
    for (const bool of_wing : {false, true})
        for (const int number : {12, 24, 27, 36, 60}) {
            FieldOptions options{number, {}};
            if (of_wing) options.wing = wing;
            fields.emplace_back(body.mesh, body.conditions, options);
            fmt::print("{:>7}", text(of_wing ? "w" : "s", fields.back().size()));
        }
    return fields;
}

void print_wings(const std::string& folder) {
    for (SampleBody& body : wings(folder)) {
        const auto found = find_wing(body.mesh);
        if (!found) throw InvalidInput(text(body.name, ": no wing is seen"));
        const Wing wing(body.mesh, found->declaration);
        const auto coordinates = std::make_shared<const WingCoordinates>(wing_lines(body.mesh, wing));
        body.conditions.held = root_of(body.mesh, *coordinates);
        fmt::print("{}\n{:<10}", body.name, "");
        const std::vector<DisplacementFields> fields = both_kinds(body, coordinates);
        std::vector<TypicalMotion> motions = airfoil_motions(body.mesh, body.conditions, *coordinates);
        for (TypicalMotion& motion : typical_motions(body.mesh, body.conditions)) motions.push_back(std::move(motion));
        for (const TypicalMotion& motion : motions) {
            fmt::print("\n{:<10}", motion.name);
            for (const DisplacementFields& one : fields)
                fmt::print("{:7.1f}", 100 * share(body.mesh, one, motion.displacement, true));
        }
        fmt::print("\n\n");
    }
}

/// Typical ones, and the droop; of a body with wings those of the wings, too.
std::vector<TypicalMotion> motions_of(const SampleBody& body, const FieldFrame& frame) {
    std::vector<TypicalMotion> motions = typical_motions(body.mesh, body.conditions);
    Points down = droop(body.mesh, frame);
    for (const int t : body.conditions.held)
        for (int k = 0; k < 3; ++k) down.row(body.mesh.triangles(t, k)).setZero();
    motions.push_back({"droop", down});
    if (body.has_wings)
        for (TypicalMotion& motion : typical_motions(body.mesh, body.conditions, Vector3d::UnitY()))
            if (motion.name != std::string("bump")) motions.push_back({text("y ", motion.name), motion.displacement});
    return motions;
}

}  // namespace

int main(int argc, char** argv) {
    const char* data = std::getenv("STRAKE_DATA");
    const bool is_of_wings = argc > 1 && std::string(argv[1]) == "--wings";
    const int first = is_of_wings ? 2 : 1;
    const std::string folder = argc > first ? argv[first] : data ? data : "";
    if (is_of_wings) return print_wings(folder), 0;
    for (const SampleBody& body : bodies(folder)) {
        fmt::print("{}\n{:<10}", body.name, "");
        std::vector<DisplacementFields> fields;
        for (const int number : {27, 36, 60, 100, 192}) {
            fields.emplace_back(body.mesh, body.conditions, FieldOptions{number, {}});
            fmt::print("{:>7}", fields.back().size());
        }
        fmt::print("{:>7}{:>11}", "27+9", "27+73 all");
        const Choice choice(body, fields.back(), 27);
        for (const TypicalMotion& motion : motions_of(body, fields[0].frame())) {
            fmt::print("\n{:<10}", motion.name);
            for (const DisplacementFields& one : fields)
                fmt::print("{:7.1f}", 100 * share(body.mesh, one, motion.displacement, !body.conditions.held.empty()));
            fmt::print("{:7.1f}{:11.1f}", 100 * choice.of_fields(motion.displacement, 9),
                       100 * choice.of_all(motion.displacement, 73));
        }
        fmt::print("\n\n");
    }
}
