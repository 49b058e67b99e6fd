#include "cases/geometry/slender_body.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "tests/casefile/build_fixture.hpp"

#include <numbers>

/// cases/wave_drag, small: few triangles, few rings, few evaluations.
namespace strake {
namespace {

using WaveDragCase = BuildProblem;

std::string small_case(int rings) {
    std::string regions, given;
    const double first = 0.25, last = 9.75, width = (last - first) / rings;
    for (int i = 0; i < rings; ++i) {
        const double from = first + i * width - 0.1, to = first + (i + 1) * width + 0.1;
        regions += text("  b", i, ": {box: [[", from, ", -1, -1], [", to, ", 1, 1]]}\n");
        given += text("    - {name: g", i, ", region: b", i, ", load: normal}\n");
    }
    return "regions:\n  nose: {plane: {normal: [1, 0, 0], at: 0.25}, side: below}\n"
           "  tail: {plane: {normal: [1, 0, 0], at: 9.75}, side: above}\n" +
           regions +
           "fixed: [nose, tail]\nshell: {thickness: 30%, spring: 0.01}\n"
           "parameters:\n  levels: auto\n  patches_per_level: [2]\n  variables: []\n  max_displacement: 3%\n  "
           "given:\n" +
           given +
           "quantities: {wave: {type: wave_drag}}\nobjective: {minimize: wave}\n"
           "constraints: {volume: {equals: 1, relative: true}}\n"
           "optimize: {method: sqp, budget: {evaluations: 30}}\n";
}

}  // namespace

TEST_F(WaveDragCase, ComesCloseToSearsAndHaack) {
    const TriMesh start = example::wavy_body(1200);
    surface(start);
    const RunResult result = optimize(build(small_case(16)).problem);
    const double V = enclosed_volume(start), least = 128 * V * V / (std::numbers::pi * 1e4);
    EXPECT_GT(result.objective_start, 3.5 * least);
    EXPECT_LT(result.objective, 1.25 * least);
    EXPECT_GT(result.objective, 0.97 * least) << "nothing has less";
}

}  // namespace strake
