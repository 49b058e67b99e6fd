#include "core/mesh/geometry.hpp"
#include "optimize/problem/shell_setup.hpp"
#include "tests/casefile/build_fixture.hpp"

#include <cmath>
#include <numeric>

namespace strake {
namespace {

/// Triangles all of whose corners satisfy `inside`.
template <class Inside>
std::vector<int> expected(const TriMesh& mesh, const Inside& inside) {
    std::vector<int> found;
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        bool all = true;
        for (int k = 0; k < 3; ++k) all &= inside(mesh.vertices.row(mesh.triangles(t, k)));
        if (all) found.push_back(t);
    }
    return found;
}

TEST_F(BuildProblem, RegionsHoldTrianglesWithAllVerticesInsideBordersIncluded) {
    const TriMesh mesh = strip(4, 1, 8, 2);
    surface(mesh);
    folder.write("list.txt", "7\n\n 3\r\n0\n");
    const BuiltProblem built = build(R"(regions:
  box:   {box: [[0, 0, 0], [1, 1, 0]]}
  off:   {box: [[0.0000001, 0, 0], [1, 1, 0]]}
  ball:  {sphere: {center: [0, 0, 0], radius: 1.2}}
  above: {plane: {normal: [2, 0, 0], at: 3}, side: above}
  below: {plane: {normal: [2, 0, 0], at: 3}, side: below}
  all:   {component: 0}
  list:  {triangles: list.txt}
)",
                                     Purpose::deform);
    const auto x_at_most = [](double limit) { return [=](const auto& x) { return x[0] <= limit; }; };
    EXPECT_EQ(region(built, "box"), expected(mesh, x_at_most(1)));
    EXPECT_LT(region(built, "off").size(), region(built, "box").size()) << "1e-7 is more than the slack of 1e-9";
    EXPECT_EQ(region(built, "ball"), expected(mesh, [](const auto& x) { return x.norm() <= 1.2; }));
    EXPECT_EQ(region(built, "above"), expected(mesh, [](const auto& x) { return x[0] >= 3; }));
    EXPECT_EQ(region(built, "below"), expected(mesh, x_at_most(3)));
    EXPECT_EQ(static_cast<int>(region(built, "all").size()), mesh.num_triangles());
    EXPECT_EQ(region(built, "list"), (std::vector<int>{0, 3, 7}));
}

TEST_F(BuildProblem, SolidsAndPatchesAreFoundByName) {
    TriMesh cube = box_surface(Eigen::Vector3d::Ones(), 2);
    cube.group_names = {"lid", "rest"};
    cube.group.assign(cube.num_triangles(), 1);
    cube.group[5] = cube.group[6] = 0;
    surface(cube);
    const std::string levels = "parameters: {levels: [20deg]}\n";
    const BuiltProblem built = build(levels + "regions: {lid: {solid: lid}}\n");
    EXPECT_EQ(region(built, "lid"), (std::vector<int>{5, 6}));
    ASSERT_EQ(built.problem.tree.levels.size(), 2u);
    EXPECT_EQ(built.problem.tree.levels[1].patches.size(), 6u);
    const Patch& patch = built.problem.tree.levels[1].patches[2];
    EXPECT_EQ(region(build(levels + "regions: {p: {patch: \"" + patch.name + "\"}}\n", Purpose::deform), "p"),
              patch.triangles);
    EXPECT_EQ(error("regions: {lid: {solid: lit}}\n", Purpose::deform),
              "case.yaml:3:24: the surface has no solid 'lit'; did you mean 'lid'? solids: rest, lid");
    EXPECT_TRUE(contains(error(levels + "regions: {p: {patch: nowhere}}\n"), "case.yaml:4:22: ")) << "unknown patch";
}

TEST_F(BuildProblem, EmptyAndWrongRegionsAreAllNamedAtOnce) {
    surface(strip(4, 1, 8, 2));
    folder.write("list.txt", "0\n12x\n");
    folder.write("far.txt", "0\n32\n");
    EXPECT_EQ(
        error(R"(regions:
  far:  {box: [[10, 0, 0], [11, 1, 0]]}
  two:  {component: 1}
  list: {triangles: list.txt}
  out:  {triangles: far.txt}
)",
              Purpose::deform),
        "case.yaml:4:15: region 'far' holds no triangle: a triangle is inside when its three vertices are; triangle 14 "
        "comes nearest, and would be inside if each face of the box were 6.5 farther out; the surface's box is [[0, 0, "
        "0], [4, 1, 0]]\n"
        "case.yaml:5:21: component 1 must be below 1, the number of connected pieces of the surface\n"
        "case.yaml:6:21: list.txt:2: '12x' must be an integer\n"
        "case.yaml:7:21: far.txt:2: triangle 32 must be in [0, 32)");
}

TEST_F(BuildProblem, HeightsFollowTheRegionsWithTheLogMeanBetween) {
    const TriMesh mesh = strip(2, 1, 2, 1, 0);
    surface(mesh);
    const BuiltProblem built =
        build("regions: {left: {box: [[0, 0, 0], [1, 1, 0]]}}\nshell: {thickness: {default: 0.04, left: 0.01}}\n",
              Purpose::deform);
    double at_left = 0, at_right = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        if (mesh.vertices(v, 0) == 0) at_left = built.problem.prism_height[v];
        if (mesh.vertices(v, 0) == 2) at_right = built.problem.prism_height[v];
    }
    EXPECT_NEAR(at_left, 0.01, 1e-15);
    EXPECT_NEAR(at_right, 0.04, 1e-15);
    EXPECT_GT(built.problem.prism_height.minCoeff(), 0.01 - 1e-12);
    ASSERT_FALSE(built.warnings.empty()) << "thinner than half an edge";
}

TEST_F(BuildProblem, WhereThicknessRegionsOverlapTheLaterEntryCounts) {
    const TriMesh mesh = strip(2, 1, 2, 1, 0);
    surface(mesh);
    const std::string regions = "regions: {a: {component: 0}, left: {box: [[0, 0, 0], [1, 1, 0]]}}\n";
    const BuiltProblem later = build(regions + "shell: {thickness: {default: 1, a: 2, left: 3}}\n", Purpose::deform);
    const BuiltProblem earlier = build(regions + "shell: {thickness: {default: 1, left: 3, a: 2}}\n", Purpose::deform);
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        if (mesh.vertices(v, 0) == 0) {
            EXPECT_NEAR(later.problem.prism_height[v], 3, 1e-14);
        }
        EXPECT_NEAR(earlier.problem.prism_height[v], 2, 1e-14);
    }
    ASSERT_EQ(later.warnings.size(), 1u);
    EXPECT_EQ(later.warnings[0],
              "shell.thickness: regions 'a' and 'left' share 2 triangles; the later one, 'left', holds there");
}

TEST_F(BuildProblem, StrainsOffTheSymmetryPlaneAreRefusedAtTheirPlace) {
    surface(strip(4, 1, 8, 2));  // open edges on y = 0
    const std::string head =
        "regions: {end: {box: [[3, 0, 0], [4, 1, 0]]}, a: {box: [[0, 0, 0], [1, 1, 0]]}}\nsymmetry: {plane: y}\n";
    EXPECT_TRUE(contains(error(head + "strains:\n  - {region: end, translate: [0, 0.1, 0]}\n", Purpose::deform),
                         "case.yaml:6:5: strains: region 'end' takes vertex "));
    EXPECT_TRUE(contains(
        error(head + "strains:\n  - {region: end, rotate: [5deg, 0, 0], about: [0, 0.5, 0]}\n", Purpose::deform),
        "off the symmetry plane by "));
    EXPECT_EQ(error(head + "strains: [{region: end, translate: [1, 0, 1], rotate: [0, 5deg, 0]}]\n", Purpose::deform),
              "");
    EXPECT_EQ(error(head + "fixed: [end]\nstrains: [{region: a, translate: [0, 0, 1]}]\n", Purpose::deform), "");
}

TEST_F(BuildProblem, NothingFreeIsToldAtFixedOrAtTheStrains) {
    surface(strip(4, 1, 8, 2));
    const std::string regions = "regions: {all: {component: 0}, a: {box: [[0, 0, 0], [1, 1, 0]]}}\n";
    EXPECT_EQ(error(regions + "fixed: [all]\n", Purpose::deform),
              "case.yaml:4:8: fixed: every triangle is fixed; nothing is left to deform");
    EXPECT_EQ(error(regions + "fixed: [a]\nstrains: [{region: all, translate: [0, 0, 1]}]\n", Purpose::deform),
              "case.yaml:4:8: fixed: every triangle is fixed or strained; nothing is left to deform");
    EXPECT_EQ(error(regions + "strains: [{region: all, translate: [0, 0, 1]}]\n", Purpose::deform),
              "case.yaml:4:11: strains: every triangle is strained; nothing is left to deform");
}

TEST_F(BuildProblem, ForceIsSpreadOverTheAreaAndLoadsAddUp) {
    surface(strip(4, 1, 8, 2));
    const BuiltProblem built = build(R"(regions: {end: {box: [[3, 0, 0], [4, 1, 0]]}, all: {component: 0}}
loads:
  - {region: end, force: [0, 0, 6]}
  - {region: all, traction: [1, 0, 0], spring: 0.5}
shell: {spring: 2}
)",
                                     Purpose::deform);
    const Points forces = traction_forces(built.problem.surface, built.problem.given_traction);
    EXPECT_TRUE(forces.colwise().sum().isApprox(Eigen::RowVector3d(4, 0, 6), 1e-13)) << forces.colwise().sum();
    EXPECT_EQ(built.problem.spring_per_area.minCoeff(), 0.5) << "the own one replaces shell.spring";
    EXPECT_EQ(built.problem.spring_per_area.maxCoeff(), 0.5);
}

TEST_F(BuildProblem, SpringsStandUnderLoadedTrianglesOnly) {
    surface(strip(4, 1, 8, 2));
    const std::string regions = "regions: {end: {box: [[3, 0, 0], [4, 1, 0]]}}\nshell: {spring: 2}\n";
    const Eigen::VectorXd given =
        build(regions + "loads: [{region: end, traction: [0, 0, 0]}]\n", Purpose::deform).problem.spring_per_area;
    EXPECT_EQ((given.array() > 0).count(), 8) << "a load of zero counts as a load";
    const std::string run = regions + "objective: {minimize: area}\nparameters: {levels: [20deg], variables: [";
    EXPECT_EQ((build(run + "load]}\n").problem.spring_per_area.array() > 0).count(), 32);
    EXPECT_EQ((build(run + "load], variables_on: [end]}\n").problem.spring_per_area.array() > 0).count(), 8);
    EXPECT_EQ(build(run + "stiffness]}\n").problem.spring_per_area.size(), 0);
}

TEST_F(BuildProblem, DisplacementIsMetByTheLinearResponse) {
    const TriMesh mesh = strip(4, 1, 16, 4);
    surface(mesh);
    const BuiltProblem built =
        build(R"(regions: {root: {box: [[0, 0, 0], [0.5, 1, 0]]}, end: {box: [[3, 0, 0], [4, 1, 0]]}}
fixed: [root]
shell: {thickness: 0.3}
loads: [{region: end, displacement: 5%, direction: [0, 0, 2]}]
)",
              Purpose::deform);
    const ShellSetup setup = shell_setup(built.problem);
    PrimoShell shell(built.problem.surface, setup.options);
    const Points moved = shell.linear_response(setup.loads);
    EXPECT_NEAR((moved - mesh.vertices).rowwise().norm().maxCoeff(), 0.05 * box_diagonal(mesh), 1e-9);
    // What nothing holds is named with the place of the load.
    EXPECT_THROW(
        build("regions: {end: {component: 0}}\nloads: [{region: end, displacement: 1, direction: [0, 0, 1]}]\n",
              Purpose::deform),
        UnheldPart);
}

TEST_F(BuildProblem, FixedWinsOverStrainsAndStrainsMayNotOverlap) {
    surface(strip(4, 1, 8, 2));
    const std::string regions =
        "regions: {a: {box: [[0, 0, 0], [1, 1, 0]]}, b: {box: [[0.5, 0, 0], [2, 1, 0]]}, c: {box: [[1, 0, 0], [2, 1, "
        "0]]}}\n";
    const BuiltProblem built =
        build(regions + "fixed: [a]\nstrains: [{region: b, translate: [0, 0, 50%]}]\n", Purpose::deform);
    ASSERT_EQ(built.warnings.size(), 3u);
    EXPECT_EQ(built.warnings[1], "strains: 4 of 12 triangles of region 'b' are fixed as well and stay fixed");
    EXPECT_EQ(built.warnings[2], "strains: region 'b' shares 3 vertices with fixed regions; they stay fixed");
    const PrescribedStrain& strain = built.problem.strains[0];
    EXPECT_EQ(strain.triangles.size(), 8u);
    EXPECT_NEAR(strain.motion.translation[2], 0.5 * std::sqrt(17), 1e-14);
    EXPECT_TRUE(strain.motion.about.isApprox(Eigen::Vector3d(1.25, 0.5, 0), 1e-14)) << "centroid of the whole region";
    EXPECT_TRUE(shell_setup(built.problem).warnings.empty()) << "said once";
    EXPECT_EQ(error(regions + "strains: [{region: b, translate: [0, 0, 1]}, {region: c, translate: [0, 0, 2]}]\n",
                    Purpose::deform),
              "case.yaml:4:55: strains: regions 'b' and 'c' share triangles, which cannot follow both");
    EXPECT_EQ(error(regions + "fixed: [b]\nstrains: [{region: c, translate: [0, 0, 1]}]\n", Purpose::deform),
              "case.yaml:5:20: strains: every triangle of region 'c' is fixed");
}

TEST_F(BuildProblem, NothingLeftToVaryIsAnError) {
    surface(box_surface());
    const std::string yaml =
        "regions: {low: {box: [[0, 0, 0], [1, 1, 0]]}}\nfixed: [low]\nobjective: {maximize: volume}\nparameters: "
        "{levels: [20deg], variables_on: [low]}\n";
    EXPECT_EQ(error(yaml),
              "case.yaml:6:13: parameters: no triangle is left for design variables; all of parameters.variables_on "
              "are under "
              "fixed or strains");
}

TEST_F(BuildProblem, SplitContainingTakesNumbersAndPoints) {
    surface(box_surface(Eigen::Vector3d::Ones(), 2));
    EXPECT_EQ(error("parameters: {levels: [20deg], split: {containing: [48, {near: [0, 0, 0]}]}}\n"),
              "case.yaml:3:52: parameters.split.containing: triangle 48 must be below 48");
    EXPECT_EQ(error("parameters: {levels: [20deg, 10deg], split: {containing: [47, {near: [0.4, 0.4, 9]}]}}\n"), "");
    EXPECT_TRUE(contains(error("parameters: {levels: [20deg], variables_on: [nowhere]}\n"),
                         "case.yaml:3:46: parameters.variables_on: 'nowhere' is not a declared region, and "));
}

TEST_F(BuildProblem, ParametersMarkTheirTriangles) {
    surface(box_surface(Eigen::Vector3d::Ones(), 2));
    const std::string levels = "parameters: {levels: [20deg], ";
    const BuiltProblem built =
        build("regions: {low: {box: [[0, 0, 0], [1, 1, 0]]}}\n" + levels +
              "split: gradient, frozen: [low, p2], groups: [[p2], [low]], mirror: true, free_border: 0.5, variables: "
              "[load, strain_rotation], directions: [[0, 0, 2]]}\n");
    const Parameters& p = built.problem.parameters;
    EXPECT_EQ(p.split, SplitRule::gradient);
    EXPECT_EQ(std::accumulate(p.frozen.begin(), p.frozen.end(), 0), 16) << "two sides of eight triangles";
    for (const int t : region(built, "low")) EXPECT_TRUE(p.frozen[t] && p.groups[1][t] && !p.groups[0][t]);
    EXPECT_EQ(std::accumulate(p.groups[1].begin(), p.groups[1].end(), 0), 8);
    EXPECT_TRUE(p.variables_on.empty());
    EXPECT_TRUE(p.mirror && p.strain_rotates && !p.strain_translates);
    EXPECT_EQ(p.free_border, 0.5);
    EXPECT_EQ(p.load_directions, std::vector<Eigen::Vector3d>{Eigen::Vector3d(0, 0, 1)});
    EXPECT_TRUE(contains(error(levels + "frozen: [nowhere]}\n"),
                         "case.yaml:3:40: parameters.frozen: 'nowhere' is not a declared region, and "));
    EXPECT_TRUE(
        contains(error(levels + "groups: [[p1], [nowhere]]}\n"), "case.yaml:3:47: parameters.groups: 'nowhere'"));
    EXPECT_EQ(error("regions: {all: {component: 0}}\nobjective: {maximize: area}\n" + levels + "frozen: [all]}\n"),
              "case.yaml:5:13: parameters: no triangle is left for design variables; all are under fixed, strains or "
              "parameters.frozen");
}

TEST_F(BuildProblem, MirrorNeedsASymmetricSurface) {
    const std::string yaml = "objective: {maximize: area}\nparameters: {levels: [20deg], mirror: true}\n";
    surface(box_surface(Eigen::Vector3d(3, 2, 1), 2));
    EXPECT_EQ(error(yaml), "");
    TriMesh skewed = box_surface(Eigen::Vector3d(3, 2, 1), 2);
    skewed.vertices.col(0) += 0.3 * skewed.vertices.col(1).cwiseProduct(skewed.vertices.col(2));
    skewed.vertices.col(1) += 0.2 * skewed.vertices.col(0).cwiseAbs2();
    surface(skewed);
    EXPECT_EQ(error(yaml),
              "case.yaml:4:39: parameters.mirror: the surface has no plane of symmetry (to 1e-3 of the diagonal)");
}

TEST_F(BuildProblem, QuantitiesCarryTheNamesOfTheCase) {
    surface(box_surface());
    const BuiltProblem built = build(R"(regions: {low: {box: [[0, 0, 0], [1, 1, 0]]}}
fixed: [low]
quantities:
  room: {type: volume}
  t: {type: target_shape, file: s.obj, match: same}
  one: {command: [sh, "-c", "true"], outputs: [drag]}
objective: {maximize: room}
constraints: {one.drag: {max: 1}, area: {max: 1.1, relative: true}}
parameters: {levels: [20deg], max_displacement: 0.5}
)");
    std::vector<std::string> names;
    for (const Quantity& q : built.problem.quantities) names.insert(names.end(), q.names.begin(), q.names.end());
    EXPECT_EQ(names, (std::vector<std::string>{"room", "t", "one.drag", "area"}));
    EXPECT_DOUBLE_EQ(
        built.problem.quantities[0].evaluate({.surface = built.problem.surface, .variables = {}}).values[0], 1);
    EXPECT_TRUE(built.problem.quantities[1].residuals);
    EXPECT_DOUBLE_EQ(built.problem.parameters.max_displacement, 0.5 / std::sqrt(3));
}

TEST_F(BuildProblem, PointsLinesAndPlanesAreMeasured) {
    surface(box_surface(Eigen::Vector3d(1, 2, 4), 2));
    folder.write("lines.csv", "x,y,z,dx,dy,dz,wanted\n0.3,0.4,0.9,0,2,0,2.2\n0.3,0.4,0.9,-1,0,0,1.2\n");
    folder.write("points.csv", "0.3,0.4,4.5\n0.3,2.25,1,0\n");
    const BuiltProblem built = build(R"(regions: {low: {box: [[0, 0, 0], [1, 2, 0]]}}
fixed: [low]
quantities:
  room: {type: thickness, at: lines.csv}
  least: {type: thickness, at: lines.csv, values: smallest}
  scan: {type: measured_points, file: points.csv}
  rib: {type: section_area, plane: {normal: [0, 0, -2], at: -1.3}, target: 3}
fit: [room, scan, rib]
parameters: {levels: [20deg]}
optimize: {loss: huber, loss_scale: 0.5, icp_iterations: 3}
)");
    const Problem& problem = built.problem;
    std::vector<std::string> names;
    std::vector<double> values;
    for (const Quantity& q : problem.quantities) {
        names.insert(names.end(), q.names.begin(), q.names.end());
        const QuantityResult result = q.evaluate({.surface = problem.surface, .variables = {}});
        values.insert(values.end(), result.values.begin(), result.values.end());
        EXPECT_TRUE(q.failing_shortens_step) << q.names[0];
    }
    EXPECT_EQ(names, (std::vector<std::string>{"room.1", "room.2", "least", "scan", "rib"}));
    const double expected[] = {2, 1, 1, 0.25, 2};
    ASSERT_EQ(values.size(), 5u);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(values[i], expected[i], 1e-12) << names[i];
    for (const int i : {0, 2, 3}) EXPECT_TRUE(problem.quantities[i].residuals) << i;
    EXPECT_EQ(problem.fit, (std::vector<std::string>{"room", "scan", "rib"}));
    EXPECT_EQ(problem.fitting.loss, Loss::huber);
    EXPECT_DOUBLE_EQ(problem.fitting.loss_scale, 0.5 / std::sqrt(21));
    EXPECT_EQ(problem.fitting.icp_iterations, 3);
}

TEST_F(BuildProblem, SectionsOfHalfModelsAreClosedByTheirPlane) {
    TriMesh half = box_surface(Eigen::Vector3d(1, 0.5, 1), 2);
    std::vector<Eigen::Vector3i> kept;
    for (int t = 0; t < half.num_triangles(); ++t) {
        const Eigen::Vector3i corners = half.triangles.row(t);
        if (half.vertices(corners[0], 1) + half.vertices(corners[1], 1) + half.vertices(corners[2], 1) > 0)
            kept.push_back(corners);
    }
    half.triangles.resize(static_cast<Eigen::Index>(kept.size()), 3);
    for (std::size_t t = 0; t < kept.size(); ++t) half.triangles.row(static_cast<Eigen::Index>(t)) = kept[t];
    // The vertex inside of the removed side goes, too.
    const int last = half.num_vertices() - 1;
    for (int v = 0; v <= last; ++v)
        if ((half.triangles.array() == v).count() == 0) {
            half.vertices.row(v) = half.vertices.row(last);
            half.triangles = (half.triangles.array() == last).select(v, half.triangles.array()).matrix().eval();
            half.vertices.conservativeResize(last, 3);
            break;
        }
    surface(half);
    const std::string rib = "quantities: {rib: {type: section_area, plane: {normal: [1, 0, 0], at: 0.3}}}\n";
    const BuiltProblem built = build("symmetry: {plane: y, at: 0}\n" + rib);
    const Problem& p = built.problem;
    EXPECT_NEAR(p.quantities[0].evaluate({.surface = p.surface, .variables = {}}).values[0], 0.5, 1e-12);
    EXPECT_TRUE(contains(error(rib), "case.yaml:3:14: quantities.rib: rib: the section is open at the edge"))
        << error(rib);
}

TEST_F(BuildProblem, PointsAndLinesThatAreNoneNameTheirRow) {
    surface(box_surface());
    folder.write("lines.csv", "9,9,9,0,0,1\n");
    folder.write("points.csv", "0,0,0\n0,0\n");
    EXPECT_TRUE(
        contains(error("quantities: {t: {type: thickness, at: lines.csv}}\n"), "case.yaml:3:14: quantities.t: "));
    EXPECT_TRUE(contains(error("quantities: {p: {type: measured_points, file: points.csv}}\n"),
                         "case.yaml:3:14: quantities.p: points.csv:2: "));
}

}  // namespace
}  // namespace strake
