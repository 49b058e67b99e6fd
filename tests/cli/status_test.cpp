#include "cli/run_strake.hpp"
#include "core/formats/io.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

/// The word, the line of reason and the exit status of a run belong together.
namespace strake {
namespace {

using Json = nlohmann::json;

struct Ended {
    int status;
    std::string word, reason, out, err;
};

class Status : public testing::Test {
protected:
    TempFolder folder;
    int runs = 0;

    Ended ended(const std::string& yaml, const std::string& command = "run") {
        write_surface(folder / "s.obj", ellipsoid({1, 0.6, 0.4}, 2), SurfaceFormat::obj);
        const std::string head =
            "surface: {file: s.obj}\nshell: {thickness: 5%}\nregions: {root: {box: [[-2, -2, -2], [-0.7, 2, 2]]}}\n"
            "fixed: [root]\n";
        const std::string file = folder.write("case.yaml", head + yaml).string();
        const std::string out = (folder / std::to_string(++runs)).string();
        const ProgramRun json = run_strake({command, file, "--json", "--out", out});
        const ProgramRun words = run_strake({command, file, "-q", "--out", out + "w"});
        EXPECT_EQ(json.status, words.status);
        Ended e{json.status, "", "", words.out, json.err + words.err};
        const Json told = Json::parse(json.out);
        e.word = told["status"];
        e.reason = told["reason"];
        EXPECT_FALSE(e.reason.empty());
        EXPECT_NE(words.out.find(e.word), std::string::npos) << words.out;
        // Nothing of the libraries underneath shows: their own log lines, their own words for an end.
        for (const char* foreign : {"CHOLMOD", "glog", "ceres", "nlopt failure", "std::", "terminate"})
            EXPECT_EQ((words.out + e.err).find(foreign), std::string::npos) << foreign;
        return e;
    }
};

const std::string volume = "parameters: {patches_per_level: [2], variables: [normal]}\nobjective: {maximize: volume}\n";

TEST_F(Status, ConvergedAndLimitsAreSuccess) {
    Ended e = ended(volume + "constraints: {area: {max: 1.01, relative: true}}\n");
    EXPECT_EQ(e.status, 0) << e.err;
    EXPECT_EQ(e.word, "converged") << e.reason;
    e = ended(volume + "optimize: {budget: {evaluations: 3}}\n");
    EXPECT_EQ(e.status, 0) << e.err;
    EXPECT_EQ(e.word, "budget");
    EXPECT_NE(e.reason.find("limit of evaluations"), std::string::npos) << e.reason;
}

TEST_F(Status, AnEndByTheBudgetProvesNothingAboutTheConstraints) {
    const Ended e = ended(volume +
                          "constraints: {area: {min: 1.01, relative: true}, volume: {max: 0.9, relative: true}}\n"
                          "optimize: {budget: {evaluations: 2}}\n");
    EXPECT_EQ(e.word, "infeasible");
    EXPECT_NE(e.reason.find("none of the 2 designs evaluated meets"), std::string::npos) << e.reason;
    EXPECT_NE(e.reason.find("raise optimize.budget"), std::string::npos) << e.reason;
}

TEST_F(Status, AFolderWithoutARunIsToldSo) {
    std::filesystem::create_directories(folder / "my runs");
    folder.write("a.txt", "no folder");
    for (const std::string command : {"status", "history"}) {
        const auto refused = [&](const std::string& name, const std::string& words) {
            const ProgramRun told = run_strake({command, (folder / name).string()});
            EXPECT_EQ(told.status, 3) << command;
            EXPECT_EQ(told.out, "");
            EXPECT_NE(told.err.find(words), std::string::npos) << command << ": " << told.err;
        };
        refused("nowhere", "nowhere: no such folder");
        refused("a.txt", "a.txt: is not a folder; give the run folder");
        refused("my runs", "my runs: is not a run folder (it has no journal.sqlite)\n");
    }
    ended(volume + "optimize: {budget: {evaluations: 2}}\n");
    std::filesystem::rename(folder / "1", folder / "my runs/first");
    const ProgramRun above = run_strake({"history", (folder / "my runs").string()});
    EXPECT_EQ(above.status, 3);
    EXPECT_NE(above.err.find("; run folders below it: '" + (folder / "my runs/first").string() + "'"),
              std::string::npos)
        << above.err;
}

TEST_F(Status, HistoryAsJsonHoldsWhatTheTableHolds) {
    ended(volume + "constraints: {area: {max: 1.01, relative: true}}\noptimize: {budget: {evaluations: 3}}\n");
    const std::string run = (folder / "1").string();
    const ProgramRun told = run_strake({"history", run, "--json"}), csv = run_strake({"history", run, "--csv"});
    ASSERT_EQ(told.status, 0) << told.err;
    const Json rows = Json::parse(told.out);
    ASSERT_EQ(rows.size(), 3U);
    std::istringstream lines(csv.out);
    std::string line;
    std::getline(lines, line);
    for (const Json& row : rows) {
        std::getline(lines, line);
        std::vector<std::string> fields;
        std::istringstream cells(line);
        for (std::string cell; std::getline(cells, cell, ',');) fields.push_back(cell);
        EXPECT_EQ(row["evaluation"].get<int>(), std::stoi(fields.at(0)));
        EXPECT_EQ(row["level"].get<int>(), std::stoi(fields.at(1)));
        EXPECT_EQ(row["objective"].get<double>(), std::stod(fields.at(3)));
        EXPECT_EQ(row["values"]["volume"], row["objective"]);
        EXPECT_GT(row["values"]["area"].get<double>(), 0);
        EXPECT_EQ(row["status"], "ok");
    }
    EXPECT_EQ(run_strake({"history", run, "--json", "--csv"}).status, 2);
}

TEST_F(Status, NothingThatIsReadIsOverwritten) {
    const std::string surface = (folder / "s.obj").string();
    write_surface(surface, ellipsoid({1, 0.6, 0.4}, 2), SurfaceFormat::obj);
    const std::string file =
        folder
            .write("case.yaml",
                   "surface: {file: s.obj}\nregions: {root: {box: [[-2, -2, -2], [-0.7, 2, 2]]}}\nfixed: [root]\n" +
                       volume)
            .string();
    const std::string before = bytes_of(surface), text_before = bytes_of(file), link = (folder / "link.obj").string();
    std::filesystem::create_symlink(surface, link);
    const std::string twice = (folder / "twice.obj").string();
    for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
             {"deform", file, "-o", surface},
             {"deform", file, "-o", link},
             {"deform", file, "-o", twice, "--prisms", twice},
             {"patches", surface, "--angle", "auto", "--labels", surface},
             {"patches", surface, "--angle", "auto", "--labels", (folder / "." / "s.obj").string()},
             {"sweep", file, "--variable", "p1.load_normal", "--from", "0", "--to", "1", "--steps", "2", "-o", file}}) {
        const ProgramRun run = run_strake(arguments);
        EXPECT_EQ(run.status, 2) << run.err;
        EXPECT_NE(run.err.find(arguments.back() == twice ? "two outputs" : "would overwrite"), std::string::npos)
            << run.err;
    }
    EXPECT_EQ(bytes_of(surface), before);
    EXPECT_EQ(bytes_of(file), text_before);
    EXPECT_FALSE(std::filesystem::exists(twice));
}

TEST_F(Status, ConflictsAreFailures) {
    const Ended e =
        ended(volume + "constraints: {area: {max: 0.98, relative: true}, volume: {min: 1.02, relative: true}}\n");
    EXPECT_EQ(e.status, 1);
    EXPECT_EQ(e.word, "conflict") << e.reason;
    EXPECT_NE(e.reason.find("area <= "), std::string::npos) << e.reason;
}

TEST_F(Status, AFlatObjectiveIsConvergedOnlyWithANote) {
    // Points on the part that is held do not move.
    folder.write("points.csv", "-1.2,0,0\n");
    const Ended e = ended(
        "parameters: {patches_per_level: [2], variables: [normal]}\nquantities: {p: {type: measured_points, file: "
        "points.csv}}\nobjective: {minimize: p}\n");
    EXPECT_EQ(e.status, 0) << e.err;
    EXPECT_NE(e.reason.find("did not change with any variable"), std::string::npos) << e.reason;
}

TEST_F(Status, AFitEndsInItsOwnWord) {
    write_surface(folder / "t.obj", ellipsoid({1, 0.62, 0.38}, 2), SurfaceFormat::obj);
    const Ended e = ended(
        "parameters: {patches_per_level: [2], variables: [normal]}\nquantities: {t: {type: target_shape, file: "
        "t.obj}}\nfit: [t]\n",
        "fit");
    EXPECT_EQ(e.status, 0) << e.err;
    EXPECT_TRUE(e.word == "converged" || e.word == "progress") << e.word << " " << e.reason;
}

}  // namespace
}  // namespace strake
