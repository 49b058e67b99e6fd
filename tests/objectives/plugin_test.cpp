#include "objectives/external/plugin.hpp"

#include "core/error.hpp"
#include "core/mesh/temp_folder.hpp"
#include "objectives/external/running_plugin.hpp"
#include "objectives/geometry/measures.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <unistd.h>
#include <cstdlib>

/// Shared libraries as quantities: the example of the documentation, and ones that misbehave.
namespace strake {
namespace {

const TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 2);

PluginLibrary bad(const std::string& role, const char* file = BAD_PLUGIN) {
    PluginLibrary wanted;
    wanted.name = std::string("p");
    wanted.library = file;
    wanted.options = role;
    return wanted;
}
QuantityResult ask(const PluginLibrary& wanted, bool gradients = true) {
    return plugin(wanted).evaluate({mesh, gradients, 3, 1, {}, {{"alpha", 0.25}, {"speed", 3}}});
}
std::string failure_of(const PluginLibrary& wanted) {
    const QuantityResult result = ask(wanted);
    return result.failure ? result.failure->kind + ": " + result.failure->message : "";
}
std::string refusal(const PluginLibrary& wanted) {
    try {
        plugin(wanted);
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "";
}
bool says(const std::string& words, const std::string& part) { return words.find(part) != std::string::npos; }

TEST(Plugin, TheExampleGivesTheAreaAndItsGradient) {
    PluginLibrary wanted;
    wanted.name = "wetted";
    wanted.library = EXAMPLE_PLUGIN;
    const Quantity quantity = plugin(wanted);
    EXPECT_EQ(quantity.names, std::vector<std::string>{"wetted"});
    const QuantityResult result = quantity.evaluate({mesh, true, 1, 1, {}}),
                         known = area().evaluate({mesh, true, 1, 1, {}});
    ASSERT_FALSE(result.failure) << result.failure->message;
    EXPECT_NEAR(result.values.at(0), known.values.at(0), 1e-13);
    EXPECT_LT((result.dJ_dv.at(0) - known.dJ_dv.at(0)).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_TRUE(quantity.evaluate({mesh, false, 1, 1, {}}).dJ_dv.empty());
    const QuantityResult flat = quantity.evaluate({with_vertices(mesh, 0 * mesh.vertices), false, 1, 1, {}});
    ASSERT_TRUE(flat.failure);
    EXPECT_TRUE(says(flat.failure->message, "a triangle has no area"));
}

TEST(Plugin, SeveralValuesAndVariables) {
    PluginLibrary wanted = bad("");
    wanted.outputs = {"a", "b"};
    wanted.depends_on = {"alpha"};
    const QuantityResult result = ask(wanted);
    ASSERT_FALSE(result.failure) << result.failure->message;
    EXPECT_EQ(result.values.at(1), mesh.vertices(0, 0) + 1);
    EXPECT_EQ(result.dJ_dv.at(1)(0, 0), 1);
    EXPECT_EQ(result.dJ_dp.at(0), Eigen::Vector2d(0.25, 0));
    wanted.depends_on.reset();
    EXPECT_EQ(failure_of(wanted), "not_finite: p: the plug-in gave d a / d speed = NaN");
    wanted.may_lack_derivatives = true;
    EXPECT_TRUE(std::isnan(ask(wanted).dJ_dp.at(0)[1]));
}

/// Files of the run would be written elsewhere.
TEST(Plugin, TheWorkingDirectoryStays) {
    const auto before = std::filesystem::current_path();
    PluginLibrary wanderer = bad("wander");
    wanderer.may_lack_derivatives = true;
    EXPECT_FALSE(ask(wanderer).failure);
    EXPECT_EQ(std::filesystem::current_path(), before);
}

TEST(Plugin, OneThatThrowsWhenItIsOpenedIsRefusedInWords) {
    const std::string words = refusal(bad("throw", THROWING_PLUGIN));
    EXPECT_TRUE(says(words, "p: ")) << words;
    EXPECT_TRUE(says(words, "failed to open: strake_plugin_open threw no licence today")) << words;
}

/// Loading it ended the program with SIGBUS.
TEST(Plugin, OneThatIsCutShortIsRefusedInWords) {
    const TempFolder folder;
    const std::string whole = bytes_of(BAD_PLUGIN);
    for (const std::size_t size : {whole.size() - 1, whole.size() / 2, whole.size() / 4, std::size_t{100}}) {
        const std::string file = folder.write("cut.so", whole.substr(0, size)).string();
        const std::string words = refusal(bad("", file.c_str()));
        EXPECT_TRUE(says(words, text("is cut short: it has ", size, " bytes, its header asks for "))) << words;
    }
    const std::string file = folder.write("whole.so", whole).string();
    EXPECT_EQ(refusal(bad("", file.c_str())), "");
}

TEST(Plugin, OneThatEndsTheProgramIsKnownByName) {
    EXPECT_EQ(running_plugin(), nullptr);
    static const char* seen = nullptr;
    EXPECT_EXIT(
        {
            std::atexit([] {
                seen = running_plugin();
                if (seen && says(seen, "p: ") && says(seen, ", evaluation 3")) _exit(41);
            });
            ask(bad("exit"));
        },
        testing::ExitedWithCode(41), "");
}

TEST(Plugin, WhatItDoesWrongIsAFailure) {
    EXPECT_TRUE(says(failure_of(bad("fail")), "plugin: p: ")) << failure_of(bad("fail"));
    EXPECT_TRUE(says(failure_of(bad("fail")), "evaluation 3: diverged at 3\\x1B[31m")) << failure_of(bad("fail"));
    EXPECT_TRUE(says(failure_of(bad("silent")), "gives no reason"));
    PluginLibrary forgetful = bad("forget");
    forgetful.outputs = {"a", "b"};
    forgetful.depends_on.emplace();
    EXPECT_EQ(failure_of(forgetful), "not_finite: p: the plug-in gave the value b = NaN");
    PluginLibrary gradient = bad("no gradient");
    gradient.depends_on.emplace();
    EXPECT_EQ(failure_of(gradient), "not_finite: p: the plug-in gave d value / d vertex 1 = NaN");
}

TEST(Plugin, WhatCannotBeLoadedIsRefusedBeforeTheRun) {
    const TempFolder folder;
    const std::string missing = (folder / "none.so").string(), text = folder.write("text.so", "no library").string();
    EXPECT_TRUE(says(refusal(bad("", missing.c_str())), "none.so cannot be loaded"));
    EXPECT_TRUE(says(refusal(bad("", text.c_str())), "text.so cannot be loaded"));
    EXPECT_TRUE(says(refusal(bad("", BAD_PLUGIN_ABI)), "was built for version 9 of plugin.h, this Strake needs 1"));
    EXPECT_TRUE(says(refusal(bad("", BAD_PLUGIN_SYMBOL)), "has no function strake_plugin_evaluate"));
    EXPECT_TRUE(says(refusal(bad("refuse")), "failed to open: no licence for refuse"));
}

}  // namespace
}  // namespace strake
