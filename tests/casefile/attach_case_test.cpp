#include "core/mesh/topology.hpp"
#include "optimize/check/gradient_check.hpp"
#include "optimize/evaluate/validity.hpp"
#include "optimize/problem/shell_setup.hpp"
#include "tests/casefile/build_fixture.hpp"

#include <algorithm>

namespace strake {
namespace {

/// A slab along y, and a pod that sticks in its lower side; the file names both.
TriMesh slab_and_pod() {
    TriMesh mesh = box_surface({1, 3, 0.15}, 6);
    const int v = mesh.num_vertices(), t = mesh.num_triangles();
    const TriMesh pod = ellipsoid({0.4, 0.15, 0.15}, 2);
    mesh.vertices.conservativeResize(v + pod.num_vertices(), 3);
    mesh.triangles.conservativeResize(t + pod.num_triangles(), 3);
    mesh.vertices.bottomRows(pod.num_vertices()) = pod.vertices.rowwise() + Eigen::RowVector3d(0.45, 2.1, -0.08);
    mesh.triangles.bottomRows(pod.num_triangles()) = pod.triangles.array() + v;
    mesh.group.assign(mesh.num_triangles(), 1);
    std::fill_n(mesh.group.begin(), t, 0);
    mesh.group_names = {"wing", "nacelle"};
    return mesh;
}

const std::string held =
    "regions: {root: {box: [[-1, -1, -1], [2, 0.51, 2]]}, tip: {box: [[-1, 2.4, -1], [2, 4, 2]]}, pod: {component: "
    "1}, some: {box: [[0, 2, -0.3], [0.45, 3, -0.08]]}}\nfixed: [root]\nshell: {thickness: 8%}\n";

class Attached : public BuildProblem {
protected:
    void SetUp() override { surface(slab_and_pod()); }
};

TEST_F(Attached, PartsAreNamedByRegionByTheFileOrByNumber) {
    for (const std::string part : {"pod", "nacelle", "1"})
        for (const std::string to : {"wing", "0"}) {
            const BuiltProblem built = build(held + "attach: [{part: " + part + ", to: " + to + ", how: follow}]\n");
            ASSERT_EQ(built.problem.attached.size(), 1u);
            const AttachedPart& attached = built.problem.attached[0];
            EXPECT_EQ(attached.triangles, region(built, "pod"));
            EXPECT_EQ(static_cast<int>(attached.triangles.size() + attached.host.size()),
                      built.problem.surface.num_triangles());
            EXPECT_EQ(attached.how, AttachHow::follow);
        }
    EXPECT_EQ(build(held + "attach: [{part: pod, to: wing}]\n").problem.attached[0].how, AttachHow::rigid);
}

TEST_F(Attached, WhatCannotBeIsRefusedWithItsPlace) {
    const auto refusal = [&](const std::string& attach, const std::string& rest = "") {
        return error(held + rest + "attach: " + attach + "\n", Purpose::deform);
    };
    const std::string unknown = refusal("[{part: nacele, to: wing}]");
    EXPECT_TRUE(contains(unknown, "case.yaml:6:17: attach: there is no part 'nacele'; did you mean 'nacelle'?"))
        << unknown;
    EXPECT_TRUE(contains(unknown,
                         "regions: root, tip, pod, some; parts of the surface file: wing, nacelle; connected "
                         "components: 0 to 1"))
        << unknown;
    EXPECT_TRUE(contains(refusal("[{part: pod, to: 2}]"), "case.yaml:6:26: attach: there is no part '2'"));
    EXPECT_TRUE(contains(refusal("[{part: pod, to: nacelle}]"), "attached to itself"));
    EXPECT_TRUE(contains(refusal("[{part: pod, to: wing}, {part: nacelle, to: 1}]"),
                         "case.yaml:6:40: attach: 'nacelle' is already attached at line 6 (triangle "));
    EXPECT_TRUE(contains(refusal("[{part: pod, to: nacelle}]"),
                         "case.yaml:6:26: attach: part 'pod' is attached to itself (320"));
    EXPECT_TRUE(contains(refusal("[{part: some, to: wing}]"), "shares vertex"));
    EXPECT_TRUE(contains(refusal("[{part: pod, to: wing}, {part: wing, to: pod}]"), "is also under fixed"));
    EXPECT_TRUE(contains(refusal("[{part: pod, to: wing, how: loosely}]"), "rigid, follow"));
    EXPECT_TRUE(contains(refusal("[{part: pod}]"), "to"));
    EXPECT_TRUE(contains(refusal("[{part: pod, to: wing}]", "loads: [{region: pod, traction: [0, 0, 1]}]\n"),
                         "loads: 320 of 320 triangles of region 'pod' belong to attached parts and take no load"));
}

TEST_F(Attached, TheyNeedNoHoldAndStayIntersected) {
    const std::string loads = "loads: [{region: tip, displacement: 6%, direction: [0.2, 0, 1]}]\n";
    const auto deformed = [&](const std::string& attach) {
        const BuiltProblem built = build(held + loads + attach, Purpose::deform);
        const ShellSetup setup = shell_setup(built.problem);
        PrimoShell shell(built.problem.surface, setup.options);
        EXPECT_EQ(shell.solve(setup.loads, setup.motions).status, SolveStatus::converged);
        const ValidityGuard guard(built.problem.surface, adjacency(built.problem.surface),
                                  {built.problem.fixed, {}, attached_triangles(built.problem)});
        EXPECT_EQ(guard.defect(shell.vertices(), shell.poses()), "");
        return with_vertices(built.problem.surface, shell.vertices());
    };
    try {
        deformed("");
        ADD_FAILURE() << "nothing holds the pod";
    } catch (const UnheldPart& error) {
        EXPECT_TRUE(contains(error.what(), "1 of 2 connected parts")) << error.what();
        EXPECT_TRUE(contains(error.what(), "or attach it to another part")) << error.what();
    }
    for (const std::string how : {"rigid", "follow"}) {
        const TriMesh now = deformed("attach: [{part: pod, to: wing, how: " + how + "}]\n");
        EXPECT_GT(intersections(now).apart.size(), 30u);
    }
}

TEST_F(Attached, GradientsOfARunGoThroughThem) {
    for (const std::string how : {"rigid", "follow"}) {
        const BuiltProblem built = build(held + "attach: [{part: pod, to: wing, how: " + how +
                                             "}]\n"
                                             "quantities: {reach: {type: target_shape, file: s.obj, match: same}}\n"
                                             "objective: {minimize: reach}\nconstraints: {area: {max: 9}}\n"
                                             "parameters: {variables: [load], patches_per_level: [4]}\n",
                                         Purpose::run);
        const GradientCheck check = check_gradients(built.problem, {});
        EXPECT_EQ(check.tests.size(), 2u);
        for (const TaylorTest& test : check.tests) EXPECT_TRUE(test.passed) << how << ' ' << test.name << test.verdict;
        // No variable for what is attached; and without the way through, the gradient would be a wrong one.
        Problem loose = built.problem;
        const auto evaluate = loose.quantities[0].evaluate;
        loose.quantities[0].evaluate = [=, &loose](const QuantityRequest& request) {
            QuantityResult result = evaluate(request);
            for (Points& g : result.dJ_dv)
                for (const int t : loose.attached[0].triangles)
                    for (int k = 0; g.rows() > 0 && k < 3; ++k) g.row(loose.surface.triangles(t, k)).setZero();
            return result;
        };
        EXPECT_FALSE(check_gradients(loose, {}).passed());
    }
}

}  // namespace
}  // namespace strake
