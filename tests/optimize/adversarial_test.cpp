#include "brute_force.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "problems.hpp"
#include "report/run_folder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

/// Demands that no shape can meet without breaking the surface, through the real chain. Whatever the shell makes of
/// them, no broken surface may reach a quantity, a design or a file, and every refusal has a reason.
namespace strake {
namespace {

using V3 = Eigen::Vector3d;
constexpr double pi = std::numbers::pi;

struct Demand {
    std::string name;
    std::function<TriMesh()> surface;
    std::function<bool(const V3& c)> fixed;                    ///< triangles by their centroid
    std::function<void(Problem& problem, double amount)> set;  ///< given strains and loads
    bool may_hold = false;  ///< the shell may find a valid shape even for the whole of it
};

void PrintTo(const Demand& demand, std::ostream* out) { *out << demand.name; }

std::vector<int> where(const TriMesh& mesh, const std::function<bool(const V3& c)>& in) {
    const Points c = triangle_centroids(mesh);
    std::vector<int> result;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (in(c.row(t))) result.push_back(t);
    return result;
}

using Where = std::function<bool(const V3& c)>;

std::function<void(Problem&, double)> strain(const Where& in, const V3& translation, const V3& rotation = V3::Zero(),
                                             const V3& about = V3::Zero()) {
    return [=](Problem& problem, double amount) {
        problem.strains.push_back({where(problem.surface, in), {amount * rotation, amount * translation, about}});
    };
}

std::function<void(Problem&, double)> both(const std::function<void(Problem&, double)>& a,
                                           const std::function<void(Problem&, double)>& b) {
    return [=](Problem& problem, double amount) { a(problem, amount), b(problem, amount); };
}

std::function<void(Problem&, double)> load(const Where& in, const std::function<V3(const V3& c)>& traction) {
    return [=](Problem& problem, double amount) {
        const Points c = triangle_centroids(problem.surface);
        problem.given_traction = Points::Zero(c.rows(), 3);
        for (const int t : where(problem.surface, in)) problem.given_traction.row(t) = amount * traction(c.row(t));
    };
}

TriMesh joined(const TriMesh& a, const TriMesh& b, const V3& shift) {
    TriMesh result;
    result.vertices.resize(a.num_vertices() + b.num_vertices(), 3);
    result.vertices << a.vertices, b.vertices.rowwise() + shift.transpose();
    result.triangles.resize(a.num_triangles() + b.num_triangles(), 3);
    result.triangles << a.triangles, b.triangles.array() + a.num_vertices();
    return result;
}

TriMesh wing() { return ellipsoid({0.6, 3, 0.12}, 2); }
TriMesh two_spheres() { return joined(icosphere(1), icosphere(1), {2.6, 0, 0}); }
/// A big sphere with a small one inside that bounds a cavity.
TriMesh hollow() {
    TriMesh inner = ellipsoid({0.3, 0.3, 0.3}, 1);
    inner.triangles.col(1).swap(inner.triangles.col(2));
    return joined(icosphere(2), inner, {0.1, 0, 0});
}
TriMesh sphere_and_pebble() { return joined(icosphere(2), ellipsoid({0.2, 0.2, 0.2}, 1), {2, 0.05, 0}); }
/// A fuselage along x and a wing of its own above it.
TriMesh fuselage_and_wing() { return joined(ellipsoid({2, 0.4, 0.4}, 2), wing(), {0, 0, 1}); }
/// A tube bent to a fork with two prongs along x, at z = -0.6 and 0.6; the bow lies at x < 0.
TriMesh fork() {
    TriMesh mesh = capped_cylinder(10, 40, 0.25, 6);
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const double s = mesh.vertices(v, 0) - 3, r = mesh.vertices(v, 2), bow = 0.6 * pi / 2;
        const double a = std::clamp(s, -bow, bow) / 0.6;
        const double straight = std::max(std::abs(s) - bow, 0.0);
        mesh.vertices(v, 0) = straight - (0.6 + r) * std::cos(a);
        mesh.vertices(v, 2) = (0.6 + r) * std::sin(a);
    }
    return mesh;
}
TriMesh plate() { return box_surface({2, 2, 0.1}, 8); }
TriMesh tube() { return capped_cylinder(12, 16, 0.4, 4); }
TriMesh flat_strip() { return strip(4, 1, 16, 4); }

std::vector<Demand> demands() {
    const Where root = [](const V3&c) { return c.y() < -2.4; }, tip = [](const V3&c) { return c.y() > 2.2; };
    const Where left = [](const V3&c) { return c.x() < -0.6; }, second = [](const V3&c) { return c.x() > 1.5; };
    const Where start = [](const V3&c) { return c.x() < 0.4; }, end = [](const V3&c) { return c.x() > 3.6; };
    const Where bow = [](const V3& c) { return c.x() < -0.3; };
    const Where upper_prong = [](const V3&c) { return c.x() > 1.6 && c.z() > 0; },
                lower_prong = [](const V3&c) { return c.x() > 1.6 && c.z() < 0; };
    const Where rim = [](const V3& c) { return std::abs(c.x() - 1) > 0.8 || std::abs(c.y() - 1) > 0.8; };
    const Where top = [](const V3& c) { return c.z() > 0.09 && (c - V3(1, 1, c.z())).norm() < 0.5; };
    const Where bottom = [](const V3&c) { return c.z() < -0.6; }, cap = [](const V3&c) { return c.z() > 0.7; };
    const Where middle = [](const V3& c) { return c.x() > 1.5 && c.x() < 2.5; };
    const Where above = [](const V3&c) { return c.x() > 1.7 && c.x() < 2.3 && c.z() > 0.3; },
                below = [](const V3&c) { return c.x() > 1.7 && c.x() < 2.3 && c.z() < -0.3; };
    const auto fixed_start = start;
    const Where fuselage = [](const V3& c) { return c.z() < 0.5 && std::abs(c.x()) > 1.2; };
    const Where wing_root = [](const V3& c) { return c.z() > 0.5 && c.y() < -2.4; };
    return {
        {"WingFoldedThroughItself", wing, root, strain(tip, {0, -5.3, 0})},
        {"WingTipThroughItsRoot", wing, root, strain(tip, {0, 0, -0.03}, {pi, 0, 0})},
        {"WingTwistedByAFullTurn", wing, root, strain(tip, V3::Zero(), {0, 2 * pi - 0.1, 0}), true},
        {"WingLoadTenTimesTooLarge", wing, root, load(tip, [](const V3&) { return V3(0, 0, -10); }), true},
        {"WingPressedInPlane", wing, root, load(tip, [](const V3&) { return V3(0, -3, 0.01); }), true},
        {"TipBentThroughTheFuselage", fuselage_and_wing, [=](const V3& c) { return fuselage(c) || wing_root(c); },
         strain([](const V3& c) { return c.z() > 0.5 && c.y() > 2.2; }, {0, 0, -1.6})},
        {"WingThroughTheFuselageByLoads", fuselage_and_wing, [=](const V3& c) { return fuselage(c) || wing_root(c); },
         load([](const V3& c) { return c.z() > 0.5; }, [](const V3&) { return V3(0, 0, -0.002); })},
        {"SphereHalfwayIntoAnother", two_spheres, left, strain(second, {-1.5, 0.1, 0.05})},
        {"SphereOntoAnotherVertexByVertex", two_spheres, left, strain(second, {-2.6, 0, 0})},
        {"PebbleSwallowed", sphere_and_pebble, left, strain(second, {-1.9, 0, 0})},
        {"CavityTornOut", hollow, left,
         strain([](const V3& c) { return (c - V3(0.1, 0, 0)).norm() < 0.5; }, {2, 0, 0})},
        {"CavityPushedThroughTheSkin", hollow, left,
         strain([](const V3& c) { return (c - V3(0.1, 0, 0)).norm() < 0.5; }, {0.8, 0, 0})},
        {"SphereTurnedInsideOut", [] { return icosphere(2); }, bottom, strain(cap, {0, 0, -3})},
        {"CapPressedOntoTheBottom", [] { return icosphere(2); }, bottom, strain(cap, {0, 0, -1.8})},
        {"SphereSuckedIn", [] { return icosphere(2); }, bottom,
         load([](const V3& c) { return c.z() > -0.6; }, [](const V3& c) { return V3(-1.0 * c); }), true},
        {"ProngsCrossedByStrains", fork, bow,
         both(strain(upper_prong, {0, 0, -0.9}), strain(lower_prong, {0, 0.05, 0.9}))},
        {"ProngsPressedTogetherByLoads", fork, bow,
         load([=](const V3& c) { return upper_prong(c) || lower_prong(c); },
              [](const V3& c) { return V3(0, 0, c.z() > 0 ? -0.01 : 0.01); })},
        {"PlateTopThroughItsBottom", plate, rim, strain(top, {0, 0, -0.3})},
        {"TubePinchedByOpposingStrains", tube, [=](const V3& c) { return start(c) || end(c); },
         both(strain(above, {0, 0, -0.5}), strain(below, {0, 0, 0.5}))},
        {"TubeSidesSwappedByOpposingStrains", tube, [=](const V3& c) { return start(c) || end(c); },
         both(strain(above, {0, 0, -0.9}), strain(below, {0, 0, 0.9}))},
        {"StripEndsPushedThroughEachOther", flat_strip, fixed_start, strain(end, {-3.7, 0, 0})},
        {"StripFlattenedToNothing", flat_strip, fixed_start, strain(end, {-2.99999, 0, 0}), true},
        {"StripMiddleTurnedOverInItsPlane", flat_strip, [=](const V3& c) { return start(c) || end(c); },
         strain(middle, V3::Zero(), {0, 0, pi}, {2, 0.5, 0})},
        {"LoadWithoutBound", wing, root, load(tip, [](const V3&) { return V3(0, 0, 1e200); })},
    };
}

class Adversarial : public testing::TestWithParam<Demand> {
protected:
    /// Asserts that every surface it is given is valid; its value pulls the free parts on the way that the demand goes.
    Quantity spy(const Problem& problem, const Points& pull) {
        return {{"spy"},
                [this, rest = problem.surface, fixed = problem.fixed, pull](const QuantityRequest& request) {
                    ++asked_;
                    EXPECT_EQ(brute_force::defect(rest, request.surface.vertices, fixed), "");
                    QuantityResult result;
                    result.values = {-pull.cwiseProduct(request.surface.vertices).sum()};
                    if (request.want_sensitivities) result.dJ_dv = {-pull};
                    return result;
                },
                {}};
    }

    Problem problem(double amount) {
        Problem p;
        p.name = GetParam().name;
        p.surface = GetParam().surface();
        EXPECT_LE(p.surface.num_triangles(), 1500);
        p.tree = octants(p.surface, 1);
        p.prism_height = Eigen::VectorXd::Constant(p.surface.num_vertices(), 0.04 * box_diagonal(p.surface));
        p.fixed = where(p.surface, GetParam().fixed);
        GetParam().set(p, amount);
        p.parameters.max_displacement = 0.5;
        p.optimize.max_evaluations = 6;
        p.objective = "spy";
        // The largest part without a fixed triangle is held by springs.
        p.spring_per_area = Eigen::VectorXd::Constant(p.surface.num_triangles(), 1e-6);
        Points pull = Points::Zero(p.surface.num_vertices(), 3);
        const Points c = triangle_centroids(p.surface);
        for (int t = 0; t < p.surface.num_triangles(); ++t) {
            V3 way = p.given_traction.rows() ? V3(p.given_traction.row(t)) : V3::Zero();
            if (way.norm() > 1e-9) way.normalize();
            for (const PrescribedStrain& s : p.strains)
                if (std::find(s.triangles.begin(), s.triangles.end(), t) != s.triangles.end())
                    way += s.motion.translation + s.motion.rotation.cross(V3(c.row(t)) - s.motion.about);
            for (int k = 0; k < 3; ++k) pull.row(p.surface.triangles(t, k)) += way;
        }
        if (pull.norm() == 0) pull.col(2).setOnes();
        p.quantities = {spy(p, pull / pull.norm())};
        return p;
    }

    EvaluationStatus evaluated(double amount) {
        const Problem p = problem(amount);
        const auto rest = rest_facts(p);
        ShapeEvaluator evaluator(p, rest, {"spy"});
        evaluator.enter(design_space(rest, 1));
        const int before = asked_;
        ShapeEvaluation e;
        try {
            e = evaluator.evaluate(Eigen::VectorXd::Zero(evaluator.space().size()), 1);
        } catch (const SolverError& error) {  // of a load that no factorization can take
            e.reason = error.what();
        }
        EXPECT_EQ(e.status == EvaluationStatus::ok, asked_ > before);
        EXPECT_EQ(e.status == EvaluationStatus::ok, e.reason.empty()) << e.reason;
        EXPECT_EQ(e.status == EvaluationStatus::ok, e.vertices.rows() > 0);
        if (e.status == EvaluationStatus::invalid) {
            EXPECT_TRUE(e.reason.find("at (") != std::string::npos || e.reason.find("part") != std::string::npos)
                << e.reason;
        }
        reason_ = e.reason;
        return e.status;
    }

    int asked_ = 0;
    std::string reason_;
};

TEST_P(Adversarial, NothingBrokenIsHandedOn) {
    double good = 0;
    for (const double amount : {0.3, 1.0}) {
        const EvaluationStatus status = evaluated(amount);
        if (status == EvaluationStatus::ok)
            good = amount;
        else
            RecordProperty("refused_at_" + std::to_string(amount), reason_);
        if (amount == 1 && !GetParam().may_hold) {
            EXPECT_NE(status, EvaluationStatus::ok);
        }
    }
    // From the last demand that holds on, the optimizer goes the same way by loads of its own.
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("strake_adversarial_" + std::to_string(::getpid()));
    std::filesystem::remove_all(path);
    const Problem p = problem(0.3 * good);
    RunFolder folder(path);
    folder.begin(p, {"spy"}, SurfaceFormat::off, SeriesPolicy::none);
    RunEvents events;
    int refused = 0;
    events.evaluation = [&](const EvaluationRecord& record) {
        folder.add(record);
        EXPECT_EQ(record.status == "ok", record.reason.empty());
        EXPECT_EQ(record.status == "ok", std::isfinite(record.objective));
        if (record.status != "ok") {
            ++refused;
            EXPECT_FALSE(record.accepted);
        }
    };
    events.level = [&](const LevelStart& level) { folder.add(level); };
    events.accepted = [&](const AcceptedDesign& design) {
        folder.add(design);
        EXPECT_EQ(brute_force::defect(p.surface, design.vertices, p.fixed), "");
    };
    const RunResult result = optimize(p, events);
    folder.finish(result);
    RecordProperty("refused_evaluations", refused);
    if (result.best_evaluation > 0) {
        EXPECT_EQ(brute_force::defect(p.surface, result.vertices, p.fixed), "");
        const Points written = read_surface(path / "best.off").mesh.vertices;
        EXPECT_EQ(brute_force::defect(p.surface, written, p.fixed), "");
    } else {
        EXPECT_FALSE(std::filesystem::exists(path / "best.off"));
    }
    std::filesystem::remove_all(path);
}

INSTANTIATE_TEST_SUITE_P(Demands, Adversarial, testing::ValuesIn(demands()),
                         [](const testing::TestParamInfo<Demand>& info) { return info.param.name; });

TEST(BruteForce, SeesWhatIsBroken) {
    const TriMesh rest = two_spheres();
    EXPECT_EQ(brute_force::defect(rest, rest.vertices, {0}), "");
    const int n = rest.num_vertices() / 2;
    Points v = rest.vertices;
    v.bottomRows(n).rowwise() += Eigen::RowVector3d(-1.5, 0.1, 0);
    EXPECT_NE(brute_force::defect(rest, v, {0}).find("crossing"), std::string::npos);
    v = rest.vertices;
    v.bottomRows(n).col(1) *= -1;
    EXPECT_NE(brute_force::defect(rest, v, {0}).find("inside out"), std::string::npos);
    v = rest.vertices;
    v.bottomRows(n) = 0.3 * rest.vertices.topRows(n);
    EXPECT_NE(brute_force::defect(rest, v, {0}).find("swallowed"), std::string::npos);
    v = rest.vertices;
    v(rest.triangles(0, 0), 0) += 1e-16 + 1e-15;
    EXPECT_NE(brute_force::defect(rest, v, {0}).find("fixed"), std::string::npos);
}

}  // namespace
}  // namespace strake
