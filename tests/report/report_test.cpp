#include "cli/program_case.hpp"
#include "tests/core/planform/lofted_wing.hpp"

/// `strake report` and `output: {report: true}`, without a browser (browser_test.py has one).
namespace strake {
namespace {

const char* const with_report = "output: {report: true}\n";

class Report : public ProgramCase {
protected:
    void SetUp() override {
        ProgramCase::SetUp();
        const ProgramRun none = run_strake({"report", path("nothing")});
        if (none.err.find("built without the report page") != std::string::npos)
            GTEST_SKIP() << "this build has no page: node, npm or npm's packages were missing";
    }
    /// Of a page: what its element `data` holds.
    static Json data_of(const std::string& html) {
        const std::string begin = "<script type=\"application/json\" id=\"data\">";
        const std::size_t from = html.find(begin) + begin.size();
        return Json::parse(html.substr(from, html.find("</script>", from) - from));
    }
    std::string small_case(const std::string& tail) {
        return folder.write("case.yaml", body + built_in + "optimize: {budget: {evaluations: 6}}\n" + tail).string();
    }
};

TEST_F(Report, IsWrittenAtTheEndAndTellsTheRun) {
    const ProgramRun run = run_strake({"run", small_case(with_report), "--out", path("run"), "--json", "-q"});
    ASSERT_EQ(run.status, 0) << run.err;
    const Json end = Json::parse(run.out);
    const std::string html = bytes_of(path("run/report.html"));
    const Json data = data_of(html);
    EXPECT_EQ(data["end"]["status"], end["status"]);
    EXPECT_EQ(data["end"]["reason"], end["reason"]);
    EXPECT_EQ(data["end"]["evaluations"], end["evaluations"]);
    EXPECT_EQ(data["end"]["objective"], end["objective"]);
    EXPECT_EQ(data["end"]["objective_start"], end["objective_start"]);
    EXPECT_EQ(data["history"]["objective"].size(), end["evaluations"].get<std::size_t>());
    EXPECT_EQ(data["asked"][0], Json({"Goal", "maximize volume"}));
    EXPECT_EQ(data["quantities"]["values"][1]["name"], "area");
    EXPECT_NEAR(data["quantities"]["values"][1]["max"].get<double>(),
                1.02 * data["quantities"]["values"][1]["start"].get<double>(), 1e-12);
    EXPECT_EQ(data["shapes"]["surface"]["triangles"], 320);
    EXPECT_GE(data["shapes"]["frames"].size(), 2U);
    EXPECT_GE(data["shapes"]["tree"].size(), 2U);
    EXPECT_NE(std::find(end["files"].begin(), end["files"].end(), path("run/report.html")), end["files"].end());
    EXPECT_EQ(html.find("NaN,"), std::string::npos);
}

TEST_F(Report, HasTheSheetOfADeclaredWing) {
    Loft loft;
    loft.cells = 10;
    loft.panels = 24;
    write_surface(folder / "wing.ply", lofted(loft), SurfaceFormat::ply_binary);
    const std::string yaml =
        "case: wing\nsurface: {file: wing.ply, units: m}\nsymmetry: {plane: y, at: 0}\n"
        "planform: {wing: {span: y, stations: [0, 0.5, 1]}}\nshell: none\n"
        "parameters: {planform: {wing.sweep@0.5: {range: [-5deg, 5deg]}, wing.thickness: {range: [-5%, 5%]}}}\n"
        "objective: {maximize: volume}\nconstraints: {wing.sweep@0.5: {equals: 24deg}}\n"
        "optimize: {budget: {evaluations: 8}}\n";
    const ProgramRun run =
        run_strake({"run", folder.write("wing.yaml", yaml).string(), "--out", path("run"), "--json", "-q"});
    ASSERT_EQ(run.status, 0) << run.err;
    const Json wings = data_of(bytes_of(path("run/report.html")))["wings"];
    ASSERT_EQ(wings.size(), 1U);
    const Json &start = wings[0]["start"], &best = wings[0]["best"];
    constexpr double degree = std::numbers::pi / 180;
    EXPECT_NEAR(start["panels"][1]["sweep"].get<double>(), std::atan(0.4), 1e-3);
    EXPECT_NEAR(best["panels"][1]["sweep"].get<double>(), 24 * degree, 0.01 * degree);
    EXPECT_NEAR(best["panels"][0]["sweep"], start["panels"][0]["sweep"], 0.01 * degree);
    EXPECT_NEAR(best["stations"][1]["thickness_to_chord"].get<double>() /
                    start["stations"][1]["thickness_to_chord"].get<double>(),
                1.05, 1e-3);
    EXPECT_GE(best["curve"].size(), 20U);
    EXPECT_GE(best["stations"][2]["outlines"][0].size(), 90U);
    ASSERT_EQ(run_strake({"report", path("run"), "-o", path("again.html")}).status, 0);
    EXPECT_EQ(data_of(bytes_of(path("again.html")))["wings"], wings);
}

TEST_F(Report, SaysWhetherWingsOrBodiesChange) {
    write_surface(folder / "hull.ply", ellipsoid({2, 0.5, 0.4}, 3), SurfaceFormat::ply_binary);
    const std::string yaml =
        "case: hull\nsurface: {file: hull.ply, units: m}\nplanform: {hull: {length: x}}\nhold: none\nshell: none\n"
        "parameters: {planform: {hull.width: {range: [-5%, 5%]}}}\nobjective: {minimize: area}\n"
        "optimize: {budget: {evaluations: 3}}\n";
    const ProgramRun run = run_strake({"run", folder.write("hull.yaml", yaml).string(), "--out", path("run"), "-q"});
    ASSERT_EQ(run.status, 0) << run.err;
    const std::string html = bytes_of(path("run/report.html"));
    EXPECT_NE(html.find("changes of bodies"), std::string::npos);
    EXPECT_EQ(html.find("changes of wings"), std::string::npos);
    EXPECT_EQ(data_of(html)["wings"].size(), 0U);
}

TEST_F(Report, HasTheSheetOfADeclaredBody) {
    write_surface(folder / "hull.ply", ellipsoid({2, 0.5, 0.4}, 3), SurfaceFormat::ply_binary);
    const std::string yaml =
        "case: hull\nsurface: {file: hull.ply, units: m}\nplanform: {hull: {length: x, stations: [0.25, 0.5, 0.75]}}\n"
        "hold: none\nshell: none\nparameters: {planform: {hull.width: {range: [-5%, 5%]}, hull.length: {range: [-5%, "
        "5%]}}}\n"
        "objective: {maximize: hull.width@0.5}\nconstraints: {hull.length: {min: 4.1}}\n"
        "optimize: {budget: {evaluations: 8}}\n";
    const ProgramRun run = run_strake({"run", folder.write("hull.yaml", yaml).string(), "--out", path("run"), "-q"});
    ASSERT_EQ(run.status, 0) << run.err;
    const Json bodies = data_of(bytes_of(path("run/report.html")))["bodies"];
    ASSERT_EQ(bodies.size(), 1U);
    EXPECT_EQ(bodies[0]["name"], "hull");
    const Json &start = bodies[0]["start"], &best = bodies[0]["best"];
    EXPECT_NEAR(start["length"].get<double>(), 4, 1e-9);
    EXPECT_GE(best["length"].get<double>(), 4.1 - 1e-4);
    ASSERT_EQ(best["stations"].size(), 3U);
    for (const int k : {0, 1, 2}) {
        const Json &before = start["stations"][k], &after = best["stations"][k];
        EXPECT_NEAR(after["width"].get<double>() / before["width"].get<double>(), 1.05, 1e-3);
        EXPECT_NEAR(after["height"].get<double>() / before["height"].get<double>(), 1, 1e-3);
        // Pictures: about the middle of the start's section, over half of its larger extent.
        double wide = 0;
        const Json& points = after["outlines"][0];
        for (std::size_t i = 0; i < points.size(); i += 2) wide = std::max(wide, std::abs(points[i].get<double>()));
        EXPECT_NEAR(wide, 1.05, 0.02);
    }
    EXPECT_EQ(best["curve"].size(), 21U);
    EXPECT_NEAR(best["curve"][10]["width"].get<double>(), best["stations"][1]["width"].get<double>(), 1e-12);
}

/// A twist has a limit in degrees, not the share of the diagonal that the surface may move.
TEST_F(Report, SaysTheLimitsOfVariablesOfTheUserInTheirUnits) {
    std::string yaml = body + built_in + "optimize: {budget: {evaluations: 2}}\n";
    const auto insert = [&](const std::string& after, const std::string& more) {
        const auto at = yaml.find(after);
        ASSERT_NE(at, std::string::npos) << yaml;
        yaml.insert(at + after.size(), more);
    };
    insert("regions: {", "cap: {box: [[0.8, -2, -2], [2, 2, 2]]}, ");
    insert("parameters: {",
           "given: [{name: hinge, region: cap, rotate: [0, 1, 0], about: [1, 0, 0], max_angle: 4deg}], ");
    const ProgramRun run = run_strake({"run", folder.write("case.yaml", yaml).string(), "--out", path("run"), "-q"});
    ASSERT_EQ(run.status, 0) << run.err;
    const std::string html = bytes_of(path("run/report.html"));
    EXPECT_NE(html.find("hinge (up to 4°)"), std::string::npos);
}

TEST_F(Report, OfAFinishedRunIsTheSameBytes) {
    ASSERT_EQ(run_strake({"run", small_case(with_report), "--out", path("run"), "-q"}).status, 0);
    const ProgramRun again = run_strake({"report", path("run"), "-o", path("again.html")});
    ASSERT_EQ(again.status, 0) << again.err;
    EXPECT_EQ(again.out, path("again.html") + "\n");
    EXPECT_EQ(bytes_of(path("again.html")), bytes_of(path("run/report.html")));
}

TEST_F(Report, IsWrittenUnlessTheCaseSaysNo) {
    ASSERT_EQ(run_strake({"run", small_case(""), "--out", path("by_default"), "-q"}).status, 0);
    EXPECT_TRUE(fs::exists(path("by_default/report.html")));
    ASSERT_EQ(run_strake({"run", small_case("output: {report: false}\n"), "--out", path("run"), "-q"}).status, 0);
    EXPECT_FALSE(fs::exists(path("run/report.html")));
    ASSERT_EQ(run_strake({"report", path("run")}).status, 0);
    EXPECT_TRUE(fs::exists(path("run/report.html")));
}

TEST_F(Report, TellsOfFailuresWithTheirLogs) {
    folder.write("fail-3", "");
    const std::string file = external_case("", budget + with_report);
    const ProgramRun run = run_strake({"run", file, "--out", path("run"), "-q"});
    ASSERT_EQ(run.status, 5) << run.err;
    const Json data = data_of(bytes_of(path("run/report.html")));
    EXPECT_EQ(data["end"]["status"], "evaluation_failed");
    EXPECT_EQ(data["failures"]["count"], data["failures"]["rows"].size());
    const Json& row = data["failures"]["rows"].back();
    EXPECT_EQ(row["evaluation"], 3);
    EXPECT_TRUE(row["ends_run"]);
    EXPECT_NE(row["logs"].dump().find("licence server is down"), std::string::npos) << row.dump(2);
    EXPECT_FALSE(data["next"].empty());
    EXPECT_GE(data["cost"]["programs"][0]["calls"], 1);
}

TEST_F(Report, NothingInItEndsTheElementThatHoldsIt) {
    const std::string evil = "<script>window.broken = 1<!-- & .obj";
    write_surface(folder / evil, ellipsoid({1, 0.6, 0.4}, 2), SurfaceFormat::obj);
    std::string text = body + built_in + "optimize: {budget: {evaluations: 3}}\n" + with_report;
    text.replace(text.find("s.obj"), 5, "\"" + evil + "\"");
    folder.write("case.yaml", text);
    const ProgramRun run = run_strake({"run", path("case.yaml"), "--out", path("run"), "-q"});
    ASSERT_EQ(run.status, 0) << run.err;
    const std::string html = bytes_of(path("run/report.html"));
    EXPECT_EQ(html.find(evil), std::string::npos);
    EXPECT_NE(data_of(html)["yaml"].get<std::string>().find(evil), std::string::npos);
}

TEST_F(Report, WithoutASeriesTheShapesComeFromTheCase) {
    ASSERT_EQ(run_strake({"run", small_case("output: {paraview: none}\n"), "--out", path("run"), "-q"}).status, 0);
    ASSERT_EQ(run_strake({"report", path("run")}).status, 0);
    Json data = data_of(bytes_of(path("run/report.html")));
    EXPECT_EQ(data["shapes"]["surface"]["triangles"], 320);
    EXPECT_TRUE(data["shapes"]["frames"].empty());
    // The surface has gone: the page tells, and has the rest.
    fs::remove(folder / "s.obj");
    ASSERT_EQ(run_strake({"report", path("run")}).status, 0);
    data = data_of(bytes_of(path("run/report.html")));
    EXPECT_TRUE(data["shapes"].is_null());
    EXPECT_FALSE(data["notes"].empty());
    EXPECT_EQ(data["history"]["objective"].size(), 6U);
}

TEST_F(Report, DamagedFilesTakeAwayOnlyWhatTheyHeld) {
    ASSERT_EQ(run_strake({"run", small_case(""), "--out", path("run"), "-q"}).status, 0);
    folder.write("run/series/design_000001.vtp", "<VTKFile");
    folder.write("run/run.json", "{\"levels\": [{\"level\": \"one\"}, 3], \"variables\": 7}");
    folder.write("run/levels/variables_1.csv", "name,kind\n,,,\nx,y,z,nan,1,2,3,4\n");
    const ProgramRun run = run_strake({"report", path("run")});
    ASSERT_EQ(run.status, 0) << run.err;
    const Json data = data_of(bytes_of(path("run/report.html")));
    EXPECT_TRUE(data["shapes"].is_null());
    EXPECT_NE(data["notes"].dump().find("design_000001.vtp"), std::string::npos);
    EXPECT_EQ(data["end"]["status"], "killed");  // nothing tells of an end
    EXPECT_EQ(data["history"]["objective"].size(), 6U);
}

TEST_F(Report, TheAdviceNamesTheFolderAsItIsTyped) {
    const std::string file = small_case("");
    const fs::path before = fs::current_path();
    fs::create_directories(folder / "else where");
    const auto advice = [&](const fs::path& here, const std::string& run) {
        fs::current_path(here);
        const ProgramRun made = run_strake({"report", run});
        fs::current_path(before);
        EXPECT_EQ(made.status, 0) << made.err;
        return data_of(bytes_of(path("my runs/wing's/report.html")))["next"].dump();
    };
    fs::current_path(folder.path());
    const ProgramRun ran = run_strake({"run", file, "--out", "my runs/wing's"});
    fs::current_path(before);
    ASSERT_EQ(ran.status, 0) << ran.err;
    EXPECT_NE(ran.out.find("paraview 'my runs/wing'\\''s/series.pvd'"), std::string::npos) << ran.out;
    const auto quoted = [](const std::string& words) {
        return Json(words).dump().substr(1, Json(words).dump().size() - 2);
    };
    const std::string typed = quoted("`strake resume 'my runs/wing'\\''s' --evaluations"),
                      whole = quoted("`strake resume '" + fs::canonical(folder.path()).string() +
                                     "/my runs/wing'\\''s' --evaluations");
    EXPECT_NE(advice(folder.path(), "my runs/wing's").find(typed), std::string::npos);
    EXPECT_NE(advice(folder.path(), "my runs/wing's/").find(typed), std::string::npos);
    // From elsewhere the name that was typed is right there only: the whole path is right everywhere.
    EXPECT_NE(advice(folder / "else where", "../my runs/wing's").find(whole), std::string::npos);
    EXPECT_NE(advice(folder / "my runs/wing's", ".").find(whole), std::string::npos);
}

TEST_F(Report, NeedsARunAndAPlace) {
    const ProgramRun none = run_strake({"report", path("nothing")});
    EXPECT_EQ(none.status, 2);
    EXPECT_NE(none.err.find("no such folder"), std::string::npos) << none.err;
    ASSERT_EQ(run_strake({"run", small_case(""), "--out", path("run"), "-q"}).status, 0);
    EXPECT_EQ(run_strake({"report", path("run"), "-o", path("no/such/folder/r.html")}).status, 4);
    EXPECT_EQ(run_strake({"report", path("run"), "-o", path("run/journal.sqlite")}).status, 2);
}

}  // namespace
}  // namespace strake
