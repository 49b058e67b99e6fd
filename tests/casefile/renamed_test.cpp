#include "casefile/schema/renamed.hpp"
#include "casefile/load_case.hpp"
#include "casefile/read/resolved_case.hpp"
#include "casefile/schema/explain.hpp"
#include "tests/casefile/folder.hpp"

#include <gtest/gtest.h>
#include <set>

namespace strake {
namespace {

/// One line of a case with an old name, and the same line of today.
struct Line {
    std::string before, now;
    int column;  ///< of the old name, in line 3
};

const std::vector<Line> lines{
    {"quantities: {q: {command: [sh], gives: [drag, lift]}}", "quantities: {q: {command: [sh], outputs: [drag, lift]}}",
     33},
    {"quantities: {q: {type: section_area, plane: {normal: [0, 0, 1], at: 0.5}, wanted: 2}}",
     "quantities: {q: {type: section_area, plane: {normal: [0, 0, 1], at: 0.5}, target: 2}}", 75},
    {"quantities: {q: {command: [sh], gradient_points: wing.obj, points_reach: 5%}}",
     "quantities: {q: {command: [sh], gradient_points: wing.obj, support_radius: 5%}}", 60},
    {"quantities: {q: {type: newtonian, mach: 6, lee: prandtl_meyer}}",
     "quantities: {q: {type: newtonian, mach: 6, leeward: prandtl_meyer}}", 44},
    {"quantities: {q: {type: newtonian, mach: 6, about: [0, 0, 1]}}",
     "quantities: {q: {type: newtonian, mach: 6, moment_center: [0, 0, 1]}}", 44},
    {"quantities: {q: {type: friction, reynolds: 1e6, layer: laminar}}",
     "quantities: {q: {type: friction, reynolds: 1e6, boundary_layer: laminar}}", 49},
    {"parameters: {freeze: [p1]}", "parameters: {frozen: [p1]}", 14},
    {"parameters: {on: [p1]}", "parameters: {variables_on: [p1]}", 14},
    {"parameters: {variables: [strain], core: 30%}", "parameters: {variables: [strain], free_border: 30%}", 35},
    {"parameters: {split: gradient, split_share: 80%}", "parameters: {split: gradient, marking_fraction: 80%}", 31},
    {"parameters: {split: gradient, growth: 3}", "parameters: {split: gradient, max_variable_ratio: 3}", 31},
    {"fit: [m]\nquantities: {m: {type: target_shape, file: wing.obj}}\noptimize: {associations: 2}",
     "fit: [m]\nquantities: {m: {type: target_shape, file: wing.obj}}\noptimize: {icp_iterations: 2}", 12},
    {"optimize: {refine_when: {promise_below: 1%}}", "optimize: {refine_when: {min_expected_gain: 1%}}", 26},
    {"parameters: {variables: [load_normal]}", "parameters: {variables: [normal]}", 26},
    {"optimize: {method: slsqp}", "optimize: {method: sqp}", 20},
};

class Renamed : public testing::Test {
protected:
    Folder folder;
    Renamed() { folder.write("wing.obj", tetrahedron_obj); }
    std::filesystem::path write(const std::string& line) {
        return folder.write("case.yaml", "case: wing\nsurface: {file: wing.obj}\n" + line + "\n");
    }
    std::string error(const std::string& line) {
        try {
            load_case(write(line));
        } catch (const CaseError& e) {
            return e.what();
        }
        return "";
    }
};

TEST_F(Renamed, EveryOldNameIsReadWithANoteAndWrittenWithTheNewOne) {
    std::set<std::string> seen;
    for (const Line& line : lines) {
        const std::filesystem::path file = write(line.before);
        const Case before = load_case(file);
        ASSERT_EQ(before.notes.size(), 1u) << line.before;
        const std::string place = line.before.starts_with("fit") ? ":5:" : ":3:";
        const std::string head = file.string() + place + std::to_string(line.column) + ": note: '";
        EXPECT_EQ(before.notes[0].substr(0, head.size()), head) << line.before;
        EXPECT_NE(before.notes[0].find("' is now called '"), std::string::npos);
        const std::string old_name = before.notes[0].substr(head.size(), before.notes[0].find("' is") - head.size());
        EXPECT_NE(line.before.find(old_name), std::string::npos);
        seen.insert(old_name);
        const Case now = load_case(write(line.now));
        EXPECT_TRUE(now.notes.empty()) << line.now;
        EXPECT_EQ(resolved_case(before, folder.path()), resolved_case(now, folder.path()));
    }
    for (const RenamedKey& key : renamed_keys()) EXPECT_TRUE(seen.count(key.before)) << key.before;
    for (const RenamedWord& word : renamed_words()) EXPECT_TRUE(seen.count(word.before)) << word.before;
}

TEST_F(Renamed, ARunThatBeganWithOldNamesHasNotChanged) {
    for (const Line& line : lines) {
        EXPECT_TRUE(changed_keys(line.before, line.now).empty()) << line.before;
        EXPECT_TRUE(load_case(write(line.before), Purpose::any, folder.path()).notes.empty()) << line.before;
    }
    EXPECT_TRUE(changed_keys("optimize: {method: sqp}\n", "optimize: {method: auto}\n").empty())
        << "the default before";
    EXPECT_EQ(changed_keys("parameters: {growth: 3}\n", "parameters: {max_variable_ratio: 4}\n"),
              std::vector<std::string>{"parameters.max_variable_ratio"});
}

TEST_F(Renamed, BothNamesAreAnErrorAtTheSecond) {
    const std::string file = (folder.path() / "case.yaml").string();
    EXPECT_EQ(error("parameters: {freeze: [p1], frozen: [p1]}"),
              file + ":3:28: 'frozen' and 'freeze' (line 3) are the same key; 'freeze' is now called 'frozen'");
    EXPECT_EQ(error("parameters: {frozen: [p1], freeze: [p1]}"),
              file + ":3:28: 'freeze' and 'frozen' (line 3) are the same key; 'freeze' is now called 'frozen'");
    EXPECT_EQ(error("parameters: {freeze: [p1], freeze: [p1]}"),
              file + ":3:28: key 'frozen' given twice in parameters (first on line 3)");
}

TEST_F(Renamed, SuggestionsAndNotesBesideErrors) {
    const std::string file = (folder.path() / "case.yaml").string();
    EXPECT_EQ(error("parameters: {frezen: [p1]}"),
              file + ":3:14: unknown key 'frezen' in parameters; did you mean 'frozen'?");
    EXPECT_EQ(error("optimize: {method: slsq}").find(" slsqp"), std::string::npos);
    try {
        load_case(write("parameters: {freeze: [p1], mirror: yes}"));
        FAIL();
    } catch (const CaseError& e) {
        EXPECT_NE(e.quoted().find("note: 'freeze' is now called 'frozen'"), std::string::npos) << e.quoted();
        EXPECT_EQ(e.diagnostics.size(), 1u);
    }
}

TEST(Explain, PointsFromOldNamesToNewOnes) {
    const auto path_of = [](const std::string& asked) { return explain(asked).at(0).path; };
    EXPECT_EQ(path_of("freeze"), "parameters.frozen");
    EXPECT_EQ(path_of("parameters.on"), "parameters.variables_on");
    EXPECT_EQ(path_of("quantities.aero.gives"), "quantities.*.outputs");
    EXPECT_EQ(path_of("load_normal"), "normal");
    EXPECT_EQ(explain("slsqp").at(0).used_by, std::vector<std::string>{"optimize.method"});
    EXPECT_EQ(explain("freeze").at(0).asked_as, "freeze");
    EXPECT_TRUE(explain("parameters.frozen").at(0).asked_as.empty());
    EXPECT_THROW(explain("optimize.freeze"), InvalidInput);
}

}  // namespace
}  // namespace strake
