#include "casefile/load_case.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/fit.hpp"
#include "tests/casefile/build_fixture.hpp"

/// The same case in other units of length, and the same body on finer triangles, from the case file to the design.
namespace strake {
namespace {

struct Ended {
    RunResult run;
    double diagonal = 1;
};

class Similarity : public BuildProblem {
protected:
    /// @param unit in metres
    Ended ended(const TriMesh& metres, const TriMesh& target, const std::string& name, double unit,
                const std::string& yaml) {
        const TriMesh body = with_vertices(metres, metres.vertices / unit);
        surface(body);
        write_surface(folder.path() / "target.obj", with_vertices(target, target.vertices / unit), SurfaceFormat::obj);
        const Case c = load_case(
            folder.write("case.yaml", "case: c\nsurface: {file: s.obj, units: " + name + "}\n" + yaml), Purpose::any);
        const Problem problem = build_problem(c).problem;
        return {problem.fit.empty() ? optimize(problem) : fit(problem), box_diagonal(body)};
    }
};

const std::string common = R"(
regions:
  root: {box: [[-2 m, -2 m, -2 m], [-0.7 m, 2 m, 2 m]]}
  end: {plane: {normal: [1, 0, 0], at: 0.7 m}, side: above}
fixed: [root]
shell: {thickness: {default: 10 cm, end: 5%}}
loads: [{region: end, displacement: 5 mm, direction: [0, 0, 1]}]
quantities: {match: {type: target_shape, file: target.obj}}
)";

// Searched to below what is compared, by variables under which the skin does not buckle: where evaluations fail,
// rounding decides where a run ends.
const std::string volume_under_area = common + R"(
parameters: {patches_per_level: [2, 8], variables: [normal], max_displacement: 5 cm, split: sensitivity}
objective: {maximize: volume}
constraints: {area: {max: 1.02, relative: true}}
optimize: {tolerances: {objective: 1e-8}}
)";

const std::string recovery_by_strains = common + R"(
parameters: {patches_per_level: [2, 8], variables: [strain], max_displacement: 5%}
objective: {minimize: match}
)";

const std::string robust_fit = common + R"(
parameters: {patches_per_level: [2, 8], variables: [normal], max_displacement: 50 mm}
fit: [match]
optimize: {loss: huber, loss_scale: 2 mm, icp_iterations: 3}
)";

/// Not symmetric: two points of the target that are equally close would be a matter of rounding.
TriMesh bent(const TriMesh& mesh) {
    TriMesh result = mesh;
    const Eigen::ArrayXd s = (mesh.vertices.col(0).array() + 0.7).max(0);
    result.vertices.col(2).array() += s.square() * (0.05 + 0.02 * mesh.vertices.col(1).array());
    result.vertices.col(1).array() += 0.013 * s.square();
    return result;
}

}  // namespace

TEST_F(Similarity, MetresMillimetresAndInchesGiveTheSameDesigns) {
    const TriMesh body = ellipsoid({1, 0.6, 0.4}, 2), target = bent(ellipsoid({1, 0.6, 0.4}, 3));
    for (const std::string& yaml : {volume_under_area, recovery_by_strains, robust_fit}) {
        SCOPED_TRACE(yaml.substr(common.size(), 80));
        const Ended metres = ended(body, target, "m", 1, yaml);
        ASSERT_GT(metres.run.evaluations, 5) << metres.run.reason;
        for (const auto& [name, unit] : {std::pair{"mm", 1e-3}, std::pair{"in", 0.0254}}) {
            SCOPED_TRACE(name);
            const Ended other = ended(body, target, name, unit, yaml);
            EXPECT_EQ(other.run.status, metres.run.status);
            // Rounding decides how often the end is confirmed.
            EXPECT_NEAR(other.run.evaluations, metres.run.evaluations, 0.1 * metres.run.evaluations);
            EXPECT_NEAR(other.diagonal * unit, metres.diagonal, 1e-12 * metres.diagonal);
            ASSERT_EQ(other.run.x.size(), metres.run.x.size());
            EXPECT_LT((other.run.x - metres.run.x).cwiseAbs().maxCoeff(), 1e-6);
            EXPECT_LT((unit * other.run.vertices - metres.run.vertices).cwiseAbs().maxCoeff(), 1e-6 * metres.diagonal);
        }
    }
}

/// Every triangle in four flat ones: the same body, but another discretisation of the skin.
TEST_F(Similarity, HalfTheEdgeLengthGivesTheSameOptimum) {
    const std::string yaml = common + R"(
parameters: {patches_per_level: [2, 8], variables: [normal], max_displacement: 2%}
objective: {maximize: volume}
constraints: {area: {max: 1.02, relative: true}}
optimize: {budget: {evaluations: 120}}
)";
    const TriMesh coarse = ellipsoid({1, 0.6, 0.4}, 2), fine = refined(coarse), target = bent(coarse);
    const Ended a = ended(coarse, target, "m", 1, yaml), b = ended(fine, target, "m", 1, yaml);
    EXPECT_TRUE(a.run.is_done() && b.run.is_done()) << a.run.reason << "\n" << b.run.reason;
    EXPECT_NEAR(b.run.objective_start, a.run.objective_start, 1e-3 * a.run.objective_start);
    const auto gain = [](const Ended& e) { return e.run.objective / e.run.objective_start - 1; };
    if (std::getenv("STRAKE_TELL"))
        std::cout << "TELL " << gain(a) << " after " << a.run.evaluations << " " << a.run.reason << ", " << gain(b)
                  << " after " << b.run.evaluations << " " << b.run.reason << "\n";
    EXPECT_GT(gain(a), 0.01);
    EXPECT_NEAR(gain(b) / gain(a), 1, 0.05);
}

}  // namespace strake
