#include "studio/shape_bench.hpp"

#include "casefile/build/build_problem.hpp"
#include "casefile/load_case.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "optimize/check/sweep.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

namespace strake {
namespace {

class Bench : public ::testing::Test {
protected:
    std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("strake-bench-" + std::to_string(::getpid()));
    void SetUp() override {
        std::filesystem::create_directories(folder);
        write_surface(folder / "body.obj", ellipsoid({1, 2, 0.7}, 3), SurfaceFormat::obj);
    }
    void TearDown() override { std::filesystem::remove_all(folder); }
    Case read(const std::string& goals) const {
        return load_case_text(
            "surface: {file: body.obj}\nregions: {root: {plane: {normal: [0, 1, 0], at: -1.2}, side: below}}\n"
            "fixed: [root]\nparameters: {levels: auto, patches_per_level: [3], variables: [normal], "
            "max_displacement: 8%}\n" +
                goals,
            folder / "case.yaml");
    }
};

TEST_F(Bench, ShapesAreThoseOfASweepAndDoNotDependOnTheWay) {
    const Case the_case = read("objective: {maximize: volume}\n");
    ShapeBench bench(the_case);
    const auto& variables = bench.variables(1);
    ASSERT_GE(variables.size(), 2u);
    std::vector<double> x(variables.size(), 0.0);
    const BenchShape start = bench.at(1, x);
    x[0] = 0.2;
    const BenchShape one = bench.at(1, x);
    ASSERT_EQ(one.status, "ok") << one.reason;
    EXPECT_GT((one.vertices - start.vertices).cwiseAbs().maxCoeff(), 1e-3);
    x[0] = -0.1;
    x[1] = 0.1;
    const BenchShape other = bench.at(1, x);
    ASSERT_EQ(other.status, "ok") << other.reason;
    EXPECT_NE(other.vertices, one.vertices);
    x[0] = 0.2;
    x[1] = 0;
    const BenchShape again = bench.at(1, x);
    ASSERT_EQ(again.status, "ok") << again.reason;
    EXPECT_LT((again.vertices - one.vertices).cwiseAbs().maxCoeff(), 1e-9);
    ShapeBench fresh(the_case);
    EXPECT_LT((fresh.at(1, x).vertices - one.vertices).cwiseAbs().maxCoeff(), 1e-9);
    const BuiltProblem built = build_problem(the_case);
    const Sweep by_command = sweep(built.problem, {{{variables[0].name, x[0], x[0], 1}}, 1});
    ASSERT_EQ(by_command.names, one.names);
    for (std::size_t k = 0; k < one.names.size(); ++k) EXPECT_NEAR(one.values[k], by_command.points[0].values[k], 1e-9);
}

TEST_F(Bench, ShapesAreToldBeforeTheyAreJudged) {
    ShapeBench bench(read("objective: {maximize: volume}\n"));
    std::vector<double> x(bench.variables(1).size(), 0.0);
    x[0] = 0.2;
    Points told(0, 3);
    const BenchShape shape = bench.at(1, x, [&](const Points& vertices) {
        told = vertices;
        return true;
    });
    ASSERT_EQ(shape.status, "ok") << shape.reason;
    EXPECT_EQ(told, shape.vertices);
    x[0] = 0.1;
    const BenchShape left = bench.at(1, x, [](const Points&) { return false; });
    EXPECT_EQ(left.status, "overtaken");
    EXPECT_EQ(left.vertices.rows(), 0);
    EXPECT_TRUE(left.values.empty()) << "nothing was measured";
}

TEST_F(Bench, ProgramsAreNotRun) {
    const std::string trap = (folder / "trap").string();
    ShapeBench bench(read("quantities: {q: {command: [touch, '" + trap + "']}}\nobjective: {maximize: q}\n"));
    EXPECT_TRUE(bench.leaves_out_programs());
    const BenchShape shape = bench.at(1, std::vector<double>(bench.variables(1).size(), 0.0));
    EXPECT_EQ(shape.status, "ok") << shape.reason;
    EXPECT_GT(shape.vertices.rows(), 0);
    EXPECT_FALSE(std::filesystem::exists(trap));
}

TEST_F(Bench, RefusesWhatIsNoPlaceInItsSpace) {
    ShapeBench bench(read("objective: {maximize: volume}\n"));
    const auto& variables = bench.variables(1);
    std::vector<double> x(variables.size(), 0.0);
    EXPECT_THROW(bench.variables(7), InvalidInput);
    EXPECT_THROW(bench.at(1, {}), InvalidInput);
    x[0] = std::nan("");
    EXPECT_THROW(bench.at(1, x), InvalidInput);
    x[0] = variables[0].upper * 1.01;
    EXPECT_THROW(bench.at(1, x), InvalidInput);
}

}  // namespace
}  // namespace strake
