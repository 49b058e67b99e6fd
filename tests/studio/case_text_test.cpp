#include "studio/case_text.hpp"

#include "casefile/yaml/value.hpp"
#include "core/error.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

const RegionText nose{"nose", "plane: {normal: [1, 0, 0], at: 2}, side: below"};

/// The keys of a map in the text, in order; "?" where there is none.
std::string keys_of(const std::string& yaml, const std::string& block) {
    const Value root = parse_yaml(yaml, "case");
    for (const Entry& entry : root.entries)
        if (entry.key == block) {
            std::string words;
            for (const Entry& item : entry.value.entries)
                words += (item.key.empty() ? item.value.text : item.key) + " ";
            return words;
        }
    return "?";
}

TEST(CaseText, AddsARegionInEveryWayThatABlockIsWritten) {
    for (const std::string yaml :
         {"surface: a.stl\nregions:\n  root: {patch: p1}\n\n# behind\nfixed: [root]\n",
          "surface: a.stl\nregions:\n    root:\n        patch: p1   # why\nfixed: [root]\n",
          "surface: a.stl\nregions: {root: {patch: p1}}  # a } in a comment\nfixed: [root]\n"}) {
        EXPECT_EQ(keys_of(with_region(yaml, nose), "regions"), "root nose ") << yaml;
        EXPECT_EQ(keys_of(with_region(yaml, nose), "fixed"), "root ") << yaml;
    }
    const std::string none = "surface: a.stl   # the body\nobjective: {maximize: volume}";
    EXPECT_EQ(keys_of(with_region(none, nose), "regions"), "nose ");
    EXPECT_EQ(keys_of(with_region("regions: {}\n", nose), "regions"), "nose ");
    EXPECT_EQ(keys_of(with_region("", nose), "regions"), "nose ");
    EXPECT_EQ(keys_of(with_region("regions:\n", nose), "regions"), "nose ");
}

TEST(CaseText, ReplacesARegionAndKeepsComments) {
    const std::string yaml =
        "# mine\nregions:\n  nose:\n    box: [[0, 0, 0],\n          [1, 1, 1]]\n  # of the tail\n  tail: {patch: p2}\n";
    const std::string made = with_region(yaml, nose);
    EXPECT_EQ(made,
              "# mine\nregions:\n  nose: {plane: {normal: [1, 0, 0], at: 2}, side: below}\n  # of the tail\n  tail: "
              "{patch: p2}\n");
    EXPECT_THROW(with_region("regions: {nose: {patch: p1}}\n", nose), InvalidInput);
}

TEST(CaseText, RefusesNamesThatACaseCannotHave) {
    for (const std::string name : {"", "all", "a b", "x: y", "a\nfixed", "{", "ä"})
        EXPECT_THROW(with_region("", {name, "patch: p1"}), InvalidInput) << name;
}

TEST(CaseText, FixesARegionOnce) {
    for (const std::string yaml : {"fixed: [a]\n", "fixed:\n  - a\n", "fixed:\n- a\n",
                                   "fixed: [ a ]  # why ]\nobjective: {maximize: volume}\n"}) {
        const std::string made = with_fixed(yaml, "nose");
        EXPECT_EQ(keys_of(made, "fixed"), "a nose ") << made;
        EXPECT_EQ(with_fixed(made, "nose"), made);
    }
    EXPECT_EQ(keys_of(with_fixed("fixed: []\n", "nose"), "fixed"), "nose ");
    EXPECT_EQ(keys_of(with_fixed("surface: a.stl\n", "nose"), "fixed"), "nose ");
}

TEST(CaseText, BlocksEndWhereTheNextKeyBegins) {
    const std::string yaml = "surface:\n  file: a.stl\n\n# of the next\nrepair: {all: true}\n";
    EXPECT_EQ(block_of(yaml, "surface"), "surface:\n  file: a.stl\n");
    EXPECT_EQ(block_of(yaml, "repair"), "repair: {all: true}\n");
    EXPECT_EQ(block_of(yaml, "remesh"), "");
}

}  // namespace
}  // namespace strake
