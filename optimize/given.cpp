#include "optimize/given.hpp"

#include "core/error.hpp"

#include <set>

namespace strake {
namespace {

void check_one(const GivenVariable& v, int num_triangles) {
    if (v.name.empty()) throw InvalidInput("a given variable has no name");
    if (v.triangles.empty()) throw InvalidInput(text("variable ", v.name, ": it has no triangles"));
    for (const int t : v.triangles)
        if (t < 0 || t >= num_triangles)
            throw InvalidInput(text("variable ", v.name, ": triangle ", t, " must be in [0, ", num_triangles, ")"));
    if (!std::is_sorted(v.triangles.begin(), v.triangles.end(), std::less_equal<>()))
        throw InvalidInput(text("variable ", v.name, ": its triangles must be ascending"));
    if (v.traction.rows() > 0 && v.traction.rows() != static_cast<Eigen::Index>(v.triangles.size()))
        throw InvalidInput(
            text("variable ", v.name, ": ", v.traction.rows(), " tractions for ", v.triangles.size(), " triangles"));
    if (!v.traction.allFinite() || !v.motion.rotation.allFinite() || !v.motion.translation.allFinite() ||
        !v.motion.about.allFinite())
        throw InvalidInput(text("variable ", v.name, ": its traction or motion is not finite"));
    const bool is_load = v.traction.rows() > 0;
    if (is_load ? v.traction.isZero(0) : v.motion.rotation.isZero(0) && v.motion.translation.isZero(0))
        throw InvalidInput(text("variable ", v.name, ": its ", is_load ? "traction" : "motion", " is zero"));
    if (!(v.unit >= 0) || !std::isfinite(v.unit))
        throw InvalidInput(text("variable ", v.name, ": unit = ", v.unit, " must be >= 0"));
    if (!(v.max_displacement >= 0) || !std::isfinite(v.max_displacement))
        throw InvalidInput(text("variable ", v.name, ": max_displacement = ", v.max_displacement, " must be >= 0"));
}

/// Joins the motion of an earlier variable of the same triangles. False: there is none.
bool join_motion(const std::vector<GivenVariable>& given, int g, ShellSetup& setup) {
    for (int other = 0; other < g; ++other) {
        if (setup.given_motion[other] < 0 || given[other].triangles != given[g].triangles) continue;
        RigidMotion& motion = setup.motions[setup.given_motion[other]];
        for (int k = 0; k < g; ++k)
            if (setup.given_motion[k] == setup.given_motion[other] && !given[k].motion.rotation.isZero(0) &&
                !given[g].motion.rotation.isZero(0) && given[k].motion.about != given[g].motion.about)
                throw InvalidInput(text("variables ", given[k].name, " and ", given[g].name,
                                        " turn the same triangles about different points"));
        if (!given[g].motion.rotation.isZero(0)) motion.about = given[g].motion.about;
        setup.given_motion[g] = setup.given_motion[other];
        setup.given_pinned[g] = setup.given_pinned[other];
        return true;
    }
    return false;
}

void pin_motion(const std::vector<GivenVariable>& given, int g, ShellSetup& setup) {
    if (join_motion(given, g, setup)) return;
    const GivenVariable& v = given[g];
    const int number = static_cast<int>(setup.motions.size());
    int fixed = 0;
    for (const int t : v.triangles) {
        int& pin = setup.options.pin[t];
        if (pin > 0) throw InvalidInput(text("variable ", v.name, ": triangle ", t, " follows another motion already"));
        if (pin == fixed_prism) {
            ++fixed;
            continue;
        }
        pin = number + 1;
        setup.given_pinned[g].push_back(t);
    }
    if (setup.given_pinned[g].empty())
        throw InvalidInput(text("variable ", v.name, ": all of its triangles are fixed"));
    if (fixed > 0)
        setup.warnings.push_back(
            text("variable ", v.name, ": ", fixed, " of its triangles are fixed as well and stay fixed"));
    setup.motions.push_back({{0, 0, 0}, {0, 0, 0}, v.motion.about});
    setup.given_motion[g] = number;
}

}  // namespace

void place_given(const Problem& problem, ShellSetup& setup) {
    const auto& given = problem.parameters.given;
    setup.given_motion.assign(given.size(), -1);
    setup.given_pinned.assign(given.size(), {});
    std::set<std::string> names;
    for (std::size_t g = 0; g < given.size(); ++g) {
        check_one(given[g], problem.surface.num_triangles());
        if (!names.insert(given[g].name).second)
            throw InvalidInput(text("two given variables are called '", given[g].name, "'"));
        if (given[g].traction.rows() == 0) pin_motion(given, static_cast<int>(g), setup);
    }
}

void list_given(DesignSpace& space) {
    const auto& given = space.rest->parameters.given;
    for (std::size_t g = 0; g < given.size(); ++g) {
        Variable variable;
        variable.name = given[g].name;
        variable.kind = given[g].traction.rows() > 0 ? VariableKind::load : VariableKind::strain;
        variable.patch = -1;
        variable.component = static_cast<int>(g);
        variable.moves = {{given_freedom(space, static_cast<int>(g)), 1.0}};
        space.variables.push_back(std::move(variable));
    }
}

int given_freedom(const DesignSpace& space, int given) { return space.num_patch_freedoms() + given; }

void add_given_traction(const RestFacts& rest, const Eigen::VectorXd& values, Points& traction) {
    for (Eigen::Index g = 0; g < values.size(); ++g) {
        const GivenVariable& v = rest.parameters.given[g];
        if (values[g] == 0 || v.traction.rows() == 0) continue;
        for (std::size_t i = 0; i < v.triangles.size(); ++i)
            traction.row(v.triangles[i]) += values[g] * v.traction.row(static_cast<Eigen::Index>(i));
    }
}

void add_given_motions(const RestFacts& rest, const Eigen::VectorXd& values, std::vector<RigidMotion>& motions) {
    for (Eigen::Index g = 0; g < values.size(); ++g) {
        if (rest.setup.given_motion[g] < 0) continue;
        motions[rest.setup.given_motion[g]].rotation += values[g] * rest.parameters.given[g].motion.rotation;
        motions[rest.setup.given_motion[g]].translation += values[g] * rest.parameters.given[g].motion.translation;
    }
}

Eigen::RowVector3d traction_gradient(const RestFacts& rest, const Points& dJ_dF, int triangle) {
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (int k = 0; k < 3; ++k) sum += rest.area[triangle] / 3 * dJ_dF.row(rest.surface.triangles(triangle, k));
    return sum;
}

void add_given_gradient(const DesignSpace& space, const std::vector<RigidMotion>& motions,
                        const ShellSensitivities& sensitivities, Eigen::VectorXd& gradient) {
    const RestFacts& rest = *space.rest;
    const auto& given = rest.parameters.given;
    for (std::size_t g = 0; g < given.size(); ++g) {
        double& sum = gradient[given_freedom(space, static_cast<int>(g))];
        if (rest.setup.given_motion[g] < 0) {
            for (std::size_t i = 0; i < given[g].triangles.size(); ++i)
                sum += traction_gradient(rest, sensitivities.force, given[g].triangles[i])
                           .dot(given[g].traction.row(static_cast<Eigen::Index>(i)));
            continue;
        }
        if (sensitivities.wrench.rows() == 0) continue;
        Eigen::Matrix<double, 6, 1> rate;
        rate << given[g].motion.rotation, given[g].motion.translation;
        for (const int t : rest.setup.given_pinned[g]) {
            Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
            for (int k = 0; k < 3; ++k) centroid += rest.surface.vertices.row(rest.surface.triangles(t, k)) / 3;
            sum += sensitivities.wrench.row(t).dot(motion_twist(motions[rest.setup.given_motion[g]], centroid) * rate);
        }
    }
}

}  // namespace strake
