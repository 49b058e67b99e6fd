#include "studio/case_edit.hpp"

#include "core/error.hpp"
#include "studio/case_form.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

const std::string proposed =
    "surface:\n  file: body.stl\n  # units: m     the file does not say\n\n"
    "# Regions that do not move.\nregions:\n  root: {plane: {normal: [0, 1, 0], at: 0.1}, side: below}  # the open "
    "end\n"
    "fixed: [root]\n\n# The design variables.\nparameters:\n  # Edges by angle.\n"
    "  levels: auto                 # or angles\n  variables: [normal]          # or load\n"
    "  max_displacement: 5%         # of the diagonal\n\nobjective: {maximize: volume}\n"
    "constraints:\n  area: {max: 1.01, relative: true}\noptimize: {method: sqp, budget: {evaluations: 60}}\n";

TEST(CaseEdit, ChangesOneValueAndNothingElse) {
    const std::string made = with_value(proposed, "parameters.max_displacement", "2%");
    std::string expected = proposed;
    expected.replace(expected.find("5%"), 2, "2%");
    EXPECT_EQ(made, expected);
    expected = proposed;
    expected.replace(expected.find("60"), 2, "200");
    EXPECT_EQ(with_value(proposed, "optimize.budget.evaluations", "200"), expected);
    EXPECT_EQ(with_value(made, "parameters.max_displacement", "5%"), proposed) << "and back";
}

TEST(CaseEdit, AddsWhatIsMissingInTheStyleThatIsThere) {
    EXPECT_NE(with_value(proposed, "surface.units", "mm").find("  file: body.stl\n  units: mm\n"), std::string::npos);
    EXPECT_NE(with_value(proposed, "optimize.seed", "3").find("budget: {evaluations: 60}, seed: 3}"),
              std::string::npos);
    EXPECT_NE(with_value(proposed, "optimize.tolerances.step", "1e-3").find(", tolerances: {step: 1e-3}}"),
              std::string::npos);
    EXPECT_EQ(with_value("", "optimize.budget.evaluations", "9"), "optimize:\n  budget:\n    evaluations: 9\n");
    EXPECT_EQ(with_value("fixed: [a]", "hold", "none"), "fixed: [a]\nhold: none\n");
    EXPECT_EQ(with_value("a: {}\n", "a.b", "1"), "a: {b: 1}\n");
    EXPECT_EQ(with_value("a:\n", "a.b", "1"), "a:\n  b: 1\n");
}

TEST(CaseEdit, TakesOutAnEntryWithItsCommentAndWhatIsEmptyThen) {
    const std::string made = with_value(proposed, "parameters.levels", "");
    EXPECT_EQ(made.find("levels"), std::string::npos);
    EXPECT_EQ(made.find("Edges by angle"), std::string::npos);
    EXPECT_NE(made.find("# The design variables.\nparameters:\n  variables"), std::string::npos);
    EXPECT_EQ(with_value(proposed, "constraints.area", "").find("constraints"), std::string::npos);
    EXPECT_NE(with_value(proposed, "optimize.method", "").find("optimize: {budget"), std::string::npos);
    EXPECT_NE(with_value(proposed, "optimize.budget.evaluations", "").find("optimize: {method: sqp}"),
              std::string::npos);
    EXPECT_EQ(with_value(proposed, "regions", "").find("root: {"), std::string::npos);
    EXPECT_EQ(with_value(proposed, "hold", ""), proposed) << "it is not there";
}

TEST(CaseEdit, ReplacesABlockByOneLine) {
    EXPECT_EQ(with_value("fixed:\n- a\n- b\nhold: none\n", "fixed", "[c]"), "fixed: [c]\nhold: none\n");
    EXPECT_EQ(with_value("a:\n  # why\n  b: 1\n  c: 2\nd: 3\n", "a", "{b: 4}"), "a: {b: 4}\nd: 3\n");
    EXPECT_EQ(with_value("a: 'x # y'  # z\n", "a", "\"{\""), "a: \"{\"  # z\n");
    EXPECT_EQ(with_value("ä: ü  # ö\n", "ä", "1"), "ä: 1  # ö\n");
}

TEST(CaseEdit, RefusesWhatItCannotDo) {
    for (const char* value : {"[1, 2", "a: b: c", "1\nx: 2", "x # y", "}"})
        EXPECT_THROW(with_value(proposed, "hold", value), InvalidInput) << value;
    for (const char* path : {"", "a..b", "a b", "a:", "[0]"})
        EXPECT_THROW(with_value(proposed, path, "1"), InvalidInput) << path;
    EXPECT_THROW(with_value(proposed, "fixed.a", "1"), InvalidInput);
    EXPECT_THROW(with_value("a: [", "b", "1"), InvalidInput);
    EXPECT_THROW(with_value("a: &x {b: 1}\nc: *x\n", "a.b", "2"), InvalidInput) << "c would change, too";
}

TEST(CaseForm, SaysWhatTheCaseStatesAndWhy) {
    const auto form = case_form(proposed);
    const auto row = [&](const std::string& path) {
        for (const auto& one : form["rows"])
            if (one["path"] == path) return one;
        return nlohmann::ordered_json();
    };
    EXPECT_EQ(row("parameters.max_displacement")["value"], "5%");
    EXPECT_EQ(row("parameters.max_displacement")["comment"], "of the diagonal");
    EXPECT_EQ(row("optimize.budget.evaluations")["value"], "60");
    EXPECT_EQ(row("optimize.budget.evaluations")["line"], 20);
    EXPECT_EQ(row("hold")["value"], "");
    EXPECT_FALSE(row("hold")["doc"].get<std::string>().empty());
    EXPECT_EQ(form["constraints"][0]["max"], "1.01");
    EXPECT_EQ(form["constraints"][0]["relative"], true);
    bool has_reason = false;
    for (const auto& reason : form["reasons"])
        has_reason |= reason["path"] == "regions.root" && reason["why"] == "the open end";
    EXPECT_TRUE(has_reason);
    EXPECT_EQ(case_form("a: [")["line"], 1);
    EXPECT_EQ(case_form("")["rows"].size(), form["rows"].size());
}

}  // namespace
}  // namespace strake
