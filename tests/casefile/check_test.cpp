#include "tests/casefile/folder.hpp"
#include "tests/cli/run_strake.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

/// The program itself on broken cases: the message, and the exit status.
namespace strake {
namespace {

class Check : public testing::Test {
protected:
    Folder folder;
    Check() {
        folder.write("s.obj", tetrahedron_obj);
        folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
        folder.write("cut.obj", "v 0 0 0\nv 1 0\n");
    }
    ProgramRun check(const std::string& yaml, std::vector<std::string> options = {}) {
        options.insert(options.begin(), {"check", folder.write("case.yaml", yaml).string()});
        ProgramRun run = run_strake(options);
        const std::string prefix = folder.path().string() + "/";
        for (std::size_t at; (at = run.err.find(prefix)) != std::string::npos;) run.err.erase(at, prefix.size());
        return run;
    }
    static std::string with(const std::string& more, const std::string& file = "s.obj") {
        return "case: c\nsurface: {file: " + file +
               "}\nregions: {a: {component: 0}, b: {box: [[0, 0, 0], [1, 1, 0]]}}\n"
               "fixed: [b]\nshell: {thickness: 0.4}\nparameters: {levels: [20deg]}\n" +
               more;
    }
};

TEST_F(Check, GoodCaseIsSummed) {
    const ProgramRun run =
        check(with("objective: {maximize: volume}\nconstraints: {area: {max: 1.1, relative: true}}\n"));
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_NE(run.out.find("region      b: 1 triangles"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("at most 9 variables"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("constraint  area <= 1.1 x start"), std::string::npos) << run.out;
}

struct Broken {
    std::string yaml, message;
    int status;
};

TEST_F(Check, TenBrokenCases) {
    const Broken broken[] = {
        {with("objective: {maximise: volume}\n"),
         "case.yaml:7:13: unknown key 'maximise' in objective; did you mean 'maximize'?\n", 2},
        {with("constrains: {area: {max: 1}}\n"),
         "case.yaml:7:1: unknown key 'constrains'; did you mean 'constraints'?\n  7 | constrains: {area: {max: 1}}\n",
         2},
        {with("objective: {maximize: volume}\nconstraints: {area: {min: 2, max: 1}}\n"),
         "case.yaml:8:27: constraints.area.min = 2 must be <= max = 1\n", 2},
        {with("loads: [{region: b, force: [0, 0, 1]}]\n"),
         "case.yaml:7:18: region 'b' is under loads and under fixed; a held region cannot be loaded\n", 2},
        {with("output: {dir: x, dir: y}\n"), "case.yaml:7:18: key 'dir' given twice in output (first on line 7)\n", 2},
        {with("fixed: &f [*f]\n"),
         "case.yaml:7:12: this alias refers to a value that contains it; write the value out instead\n", 2},
        {with("optimize: {method: bfgs}\n"), "direct, esch; did you mean 'lbfgs'?\n", 2},
        {with("", "gone.obj"), "case.yaml:2:17: surface.file = gone.obj does not exist (gone.obj)\n", 2},
        {with("loads: [{region: a, traction: [0, .nan, 0]}]\n"),
         "case.yaml:7:35: loads[0].traction[1] = .nan must be a finite number\n", 2},
        {"case: c\nsurface: {file: s.obj}\nregions: {b: {box: [[5, 5, 5], [6, 6, 6]]}}\n",
         "case.yaml:3:20: region 'b' holds no triangle: a triangle is inside when its three vertices are; triangle 0 "
         "comes nearest, and would be inside if each face of the box were 5 farther out; the surface's box is [[0, 0, "
         "0], [1, 1, 1]]\n",
         2},
        {with("case: [unclosed\n"), "case.yaml:8:1: not YAML: end of sequence flow not found\n", 2},
        {with("objective: {maximize: volume}\n", "open.obj"),
         "volume needs a closed surface; 1 of them lie in the plane x = 0 (a half model?", 3},
        {with("", "cut.obj"), "cut.obj:2: ", 3},
        {"case: c\nsurface: {file: s.obj}\nshell: {thickness: 1}\nparameters: {levels: [20deg]}\n", "case.yaml: ", 1},
    };
    for (const Broken& b : broken) {
        const ProgramRun run = check(b.yaml);
        EXPECT_EQ(run.status, b.status) << b.yaml << run.err;
        EXPECT_NE(run.err.find(b.message), std::string::npos) << b.message << "\nnot in\n" << run.err;
        EXPECT_EQ(run.out, "") << "errors go to stderr";
    }
}

TEST_F(Check, VariablesAreCountedAsTheyAreOffered) {
    const auto most = [&](const std::string& parameters) {
        const ProgramRun run = check(
            "surface: {file: s.obj}\nregions: {b: {box: [[0, 0, 0], [1, 1, 0]]}}\nfixed: [b]\n"
            "shell: {thickness: 0.4}\nobjective: {maximize: volume}\nparameters: {levels: "
            "[20deg], " +
                parameters + "}\n",
            {"--json", "--quick"});  // strains leave nothing free of so few triangles
        EXPECT_EQ(run.status, 0) << run.err;
        return nlohmann::json::parse(run.out)["levels"][0]["max_variables"].get<int>();
    };
    EXPECT_EQ(most("variables: [load]"), 9) << "three patches are free";
    EXPECT_EQ(most("variables: [load], directions: [[0, 0, 2], [1, 1, 0]]"), 6);
    EXPECT_EQ(most("variables: [strain_rotation, stiffness]"), 12);
    EXPECT_EQ(most("variables: [normal], frozen: [p1]"), 2);
}

TEST_F(Check, JsonHoldsTheErrorsAndTheSummary) {
    const ProgramRun bad = check("cas: x\nsurface: {file: s.obj}\n", {"--json"});
    EXPECT_EQ(bad.status, 2);
    const auto errors = nlohmann::json::parse(bad.out);
    EXPECT_EQ(errors["status"], "error");
    ASSERT_EQ(errors["errors"].size(), 1u);
    EXPECT_EQ(errors["errors"][0]["line"], 1);
    EXPECT_EQ(errors["errors"][0]["message"], "unknown key 'cas'; did you mean 'case'?");
    const ProgramRun good = check(with("objective: {maximize: volume}\n"), {"--json"});
    EXPECT_EQ(good.status, 0) << good.err;
    const auto summary = nlohmann::json::parse(good.out);
    EXPECT_EQ(summary["surface"]["triangles"], 4);
    EXPECT_EQ(summary["levels"][0]["max_variables"], 9);
}

TEST_F(Check, ResolvedCaseIsACase) {
    const ProgramRun first = check(with("objective: {maximize: volume}\n"), {"--print-resolved"});
    EXPECT_EQ(first.status, 0) << first.err;
    EXPECT_NE(first.out.find("evaluations: 60"), std::string::npos) << first.out;
    EXPECT_EQ(check(first.out, {"--print-resolved"}).out, first.out);
}

TEST_F(Check, AMissingCaseIsAUsageError) {
    const ProgramRun run = run_strake({"check", (folder.path() / "none.yaml").string()});
    EXPECT_EQ(run.status, 2);
    EXPECT_NE(run.err.find("none.yaml: cannot be read: No such file or directory"), std::string::npos) << run.err;
}

}  // namespace
}  // namespace strake
