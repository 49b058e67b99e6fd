#include "cli/run_strake.hpp"
#include "core/formats/io.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

/// `variables` and `start_from` from the case file to the run folder, with the example program newton.py.
namespace strake {
namespace {

using Json = nlohmann::json;

class VariablesProgram : public testing::Test {
protected:
    TempFolder folder;

    VariablesProgram() { write_surface(folder / "s.obj", ellipsoid({1, 0.6, 0.4}, 2), SurfaceFormat::obj); }
    std::string path(const std::string& name) const { return (folder / name).string(); }
    /// @param alpha "{start: ...}"
    std::string yaml(const std::string& name, const std::string& alpha, const std::string& optimize) const {
        return folder
            .write(name,
                   "case: t\nsurface: {file: s.obj}\nregions: {a: {box: [[-2, -1, -1], [-0.6, 1, 1]]}}\n"
                   "fixed: [a]\nshell: {thickness: 5%}\n"
                   "parameters: {levels: auto, patches_per_level: [2, 4], variables: [normal]}\n"
                   "variables: {alpha: " +
                       alpha +
                       "}\nquantities:\n  aero: {command: [" EXAMPLE_DIR
                       "/newton.py, \"{request}\", \"{result}\"], outputs: [drag, lift]}\n"
                       "objective: {minimize: aero.drag}\n"
                       "constraints: {aero.lift: {min: 1, relative: true}, volume: {min: 1, relative: true}}\n"
                       "optimize: {" +
                       optimize + "}\noutput: {paraview: none}\n")
            .string();
    }
    std::vector<std::vector<std::string>> history(const std::string& run) const {
        std::vector<std::vector<std::string>> rows;
        std::istringstream lines(bytes_of(path(run + "/history.csv")));
        for (std::string line; std::getline(lines, line);) {
            std::istringstream cells(line);
            rows.emplace_back();
            for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
        }
        return rows;
    }
};

TEST_F(VariablesProgram, ARunReportsThemAndUnitsMakeNoDifference) {
    const std::string file = yaml("deg.yaml", "{start: 6deg, min: 0deg, max: 12deg}", "budget: {evaluations: 9}");
    const ProgramRun run = run_strake({"run", file, "-q", "--json", "--out", path("deg")});
    EXPECT_EQ(run.status, 0) << run.err;
    const Json told = Json::parse(run.out);
    const Json& alpha = told["variables"]["alpha"];
    EXPECT_DOUBLE_EQ(alpha["start"].get<double>(), std::numbers::pi / 30);
    EXPECT_NE(alpha["best"], alpha["start"]);
    EXPECT_EQ(alpha["unit"], "rad");
    EXPECT_LT(told["objective"].get<double>(), told["objective_start"].get<double>());
    EXPECT_GE(told["values"]["aero.lift"]["best"].get<double>(),
              (1 - 1.1e-6) * told["values"]["aero.lift"]["start"].get<double>());
    const auto rows = history("deg");
    EXPECT_EQ(rows[0].back(), "alpha");
    EXPECT_EQ(std::stod(rows[1].back()), alpha["start"].get<double>());
    bool any_best = false;
    for (std::size_t i = 1; i < rows.size(); ++i) {
        EXPECT_EQ(rows[i].size(), rows[0].size());
        EXPECT_GE(std::stod(rows[i].back()), 0);
        EXPECT_LE(std::stod(rows[i].back()), std::numbers::pi / 15);
        any_best |= std::stoi(rows[i][0]) == told["best_evaluation"] && std::stod(rows[i].back()) == alpha["best"];
    }
    EXPECT_TRUE(any_best);
    std::ostringstream radians;
    radians.precision(17);
    radians << "{start: " << 6 * (std::numbers::pi / 180) << "rad, min: 0, max: " << 12 * (std::numbers::pi / 180)
            << "rad}";
    const std::string other = yaml("rad.yaml", radians.str(), "budget: {evaluations: 9}");
    const ProgramRun words = run_strake({"run", other, "-q", "--out", path("rad")});
    EXPECT_EQ(words.status, 0) << words.err;
    EXPECT_NE(words.out.find("\nalpha        6deg -> "), std::string::npos) << words.out;
    EXPECT_EQ(bytes_of(path("rad/history.csv")), bytes_of(path("deg/history.csv")));
}

TEST_F(VariablesProgram, CheckGradientCheckAndSweepKnowThem) {
    const std::string file = yaml("case.yaml", "{start: 6deg, min: 0deg, max: 12deg}", "");
    const Json checked = Json::parse(run_strake({"check", file, "--json"}).out);
    EXPECT_EQ(checked["variables"][0]["name"], "alpha");
    EXPECT_NE(run_strake({"check", file}).out.find("variable    alpha: 6deg in [0deg, 12deg]"), std::string::npos);
    const ProgramRun gradients = run_strake({"gradient-check", file, "-q", "--level", "1"});
    EXPECT_EQ(gradients.status, 0) << gradients.out << gradients.err;
    const auto sweep = [&](const std::string& from, const std::string& to) {
        return run_strake(
            {"sweep", file, "--variable", "alpha", "--from", from, "--to", to, "--steps", "3", "--json", "-q"});
    };
    const ProgramRun work_integrals = sweep("0deg", "12deg");
    ASSERT_EQ(work_integrals.status, 0) << work_integrals.err;
    const Json points = Json::parse(work_integrals.out)["points"];
    EXPECT_DOUBLE_EQ(points[1]["physical"][0].get<double>(), std::numbers::pi / 30);
    EXPECT_LT(points[0]["values"][1].get<double>(), points[2]["values"][1].get<double>()) << "lift rises with alpha";
    EXPECT_NE(sweep("0", "12").err.find("--to of alpha = 12 must be an angle"), std::string::npos);
    EXPECT_NE(sweep("0deg", "13deg").err.find("must be in [0, "), std::string::npos);
    EXPECT_EQ(sweep("0deg", "13deg").status, 2);
}

TEST_F(VariablesProgram, ARunGoesOnWhereAnotherEnded) {
    const std::string alpha = "{start: 6deg, min: 0deg, max: 12deg}";
    ASSERT_EQ(run_strake({"run", yaml("a.yaml", alpha, "budget: {evaluations: 4}"), "-q", "--out", path("a")}).status,
              0);
    const Json before = Json::parse(bytes_of(path("a/run.json")));
    const std::string on = "budget: {evaluations: 10}, start_from: a";
    const ProgramRun run = run_strake({"run", yaml("b.yaml", alpha, on), "-q", "--json", "--out", path("b")});
    ASSERT_EQ(run.status, 0) << run.err;
    const Json after = Json::parse(run.out);
    const double objective = before["objective"];
    EXPECT_NEAR(after["objective_start"].get<double>(), objective, 1e-10 * objective);
    EXPECT_EQ(after["variables"]["alpha"]["start"], before["variables"]["alpha"]["best"]);
    EXPECT_LT(after["objective"].get<double>(), objective);
    // The folder of the second run holds a case that can be run again from anywhere.
    EXPECT_EQ(run_strake({"run", path("b/case.yaml"), "-q", "--out", path("c")}).status, 0);
    EXPECT_EQ(bytes_of(path("c/history.csv")), bytes_of(path("b/history.csv")));

    write_surface(folder / "s.obj", ellipsoid({1, 0.6, 0.4}, 1), SurfaceFormat::obj);
    const ProgramRun other = run_strake({"run", path("b.yaml"), "-q", "--out", path("d")});
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("b.yaml:12:51: optimize.start_from"), std::string::npos) << other.err;
    EXPECT_NE(other.err.find("that of the run has 162 and 320"), std::string::npos) << other.err;
    EXPECT_FALSE(std::filesystem::exists(path("d")));
}

/// keep: smooth_border says what limits designs: not beside a fit without a limit of its own.
TEST_F(VariablesProgram, CheckSaysWhereABorderIsKept) {
    const std::string body =
        "surface: {file: s.obj}\nregions: {a: {box: [[-2, -1, -1], [-0.6, 1, 1]]}}\nfixed: [a]\n"
        "parameters: {patches_per_level: [2], variables: [normal]@}\n";
    const auto kept = [&](const std::string& more, const std::string& what) {
        std::string text = body + what;
        text.replace(text.find('@'), 1, more);
        const ProgramRun check = run_strake({"check", folder.write("b.yaml", text).string(), "--json"});
        EXPECT_EQ(check.status, 0) << check.err;
        return Json::parse(check.out)["border"]["kept_deg"];
    };
    const std::string search = "objective: {maximize: volume}\n",
                      fit = "quantities: {d: {type: target_shape, file: s.obj, match: same}}\nfit: [d]\n";
    EXPECT_TRUE(kept("", search).is_null());
    EXPECT_EQ(kept(", keep: smooth_border", search), 2);
    EXPECT_TRUE(kept(", keep: smooth_border", fit).is_null());
    EXPECT_EQ(kept(", keep: smooth_border, max_displacement: 5%", fit), 2);
}

}  // namespace
}  // namespace strake
