#include "cli/run_strake.hpp"
#include "core/formats/io.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <nlohmann/json.hpp>

/// `strake sweep` as a program: table, JSON, CSV, exit status.
namespace strake {
namespace {

class SweepProgram : public testing::Test {
protected:
    TempFolder folder;
    std::string yaml;

    SweepProgram() {
        write_surface(folder / "s.obj", ellipsoid({1, 0.6, 0.4}, 2), SurfaceFormat::obj);
        yaml = folder
                   .write("case.yaml",
                          "case: t\nsurface: {file: s.obj}\nregions: {a: {box: [[-2, -1, -1], [-0.6, 1, 1]]}}\n"
                          "fixed: [a]\nshell: {thickness: 5%}\nobjective: {maximize: volume}\n"
                          "parameters: {levels: auto, patches_per_level: [2, 4], variables: [normal]}\n")
                   .string();
    }
    /// The first variable of a level, from the message about one that does not exist.
    std::string variable() const {
        const std::string words =
            run_strake({"sweep", yaml, "--variable", "?", "--from", "0", "--to", "1", "--steps", "2"}).err;
        const std::size_t at = words.find("there are: ");
        return at == std::string::npos ? "" : words.substr(at + 11, words.find_first_of(",\n", at + 11) - at - 11);
    }
};

TEST_F(SweepProgram, PrintsATableAndWritesTheSameAsCsv) {
    const std::string csv = (folder / "table.csv").string(), name = variable();
    const std::vector<std::string> sweep{"sweep", yaml,  "--variable", name, "--from", "-0.5",
                                         "--to",  "0.5", "--steps",    "3",  "-o",     csv};
    const ProgramRun run = run_strake(sweep);
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 4) << run.out;
    EXPECT_NE(run.out.find(name), std::string::npos) << run.out;
    const std::string rows = bytes_of(csv);
    EXPECT_EQ(rows.find("x " + name + ",physical " + name + ",status,objective,volume,reason\n-0.5,"), 0u) << rows;
    EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 4) << rows;
    run_strake(sweep);
    EXPECT_EQ(bytes_of(csv), rows) << "equal sweeps give equal bytes";
}

TEST_F(SweepProgram, InvalidShapesAreRowsOfASuccess) {
    const ProgramRun run =
        run_strake({"sweep", yaml, "--variable", variable(), "--from", "-1e6", "--to", "0", "--steps", "2", "--json"});
    EXPECT_EQ(run.status, 0) << run.err;
    const auto told = nlohmann::json::parse(run.out);
    EXPECT_NE(told["points"][0]["status"], "ok");
    EXPECT_TRUE(told["points"][0]["objective"].is_null());
    EXPECT_EQ(told["points"][1]["status"], "ok");
    EXPECT_NE(run.err.find("point 1: "), std::string::npos) << run.err;
}

TEST_F(SweepProgram, KeepsTheFoldersOfProgramsWhereAsked) {
    folder.write("three.py", "open('result.json', 'w').write('{\"value\": 3}')\n");
    std::string text = bytes_of(yaml);
    text.replace(text.find("objective: {maximize: volume}"), 29,
                 "objective: {maximize: three}\noptimize: {method: cobyla}\n"
                 "quantities: {three: {command: [python3, \"-S\", \"-E\", \"{case_dir}/three.py\"]}}");
    const std::string programs = folder.write("programs.yaml", text).string();
    const std::filesystem::path keep = folder / "kept";
    std::vector<std::string> sweep{"sweep", programs, "--variable", variable(), "--from",
                                   "-0.5",  "--to",   "0.5",        "--steps",  "3"};
    const ProgramRun without = run_strake(sweep);
    ASSERT_EQ(without.status, 0) << without.err << without.out;
    sweep.insert(sweep.end(), {"--keep", keep.string()});
    const ProgramRun run = run_strake(sweep);
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_EQ(run.out, without.out);
    int results = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(keep))
        results += entry.path().filename() == "result.json";
    EXPECT_EQ(results, 3);
    const ProgramRun again = run_strake(sweep);
    EXPECT_EQ(again.status, 2);
    EXPECT_NE(again.err.find("is not empty"), std::string::npos) << again.err;
}

TEST_F(SweepProgram, TooManyPointsAndOptionsThatDoNotMatchAreUsage) {
    const ProgramRun many =
        run_strake({"sweep", yaml, "--variable", variable(), "--from", "0", "--to", "1", "--steps", "1001"});
    EXPECT_EQ(many.status, 2);
    EXPECT_NE(many.err.find("1001 points"), std::string::npos) << many.err;
    EXPECT_EQ(run_strake({"sweep", yaml, "--variable", "a", "--from", "0", "--from", "0", "--to", "1", "--steps", "2"})
                  .status,
              2);
    EXPECT_EQ(run_strake({"sweep", yaml, "--from", "0", "--to", "1", "--steps", "2"}).status, 2);
}

}  // namespace
}  // namespace strake
