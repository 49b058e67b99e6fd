#include "optimize/journal/answer_cache.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/temp_folder.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <atomic>
#include <thread>

namespace strake {
namespace {

namespace fs = std::filesystem;

class AnswerCache : public testing::Test {
protected:
    TempFolder folder;
    TriMesh mesh = icosphere(1);
    std::atomic<int> calls{0};
    Quantity quantity;

    void SetUp() override {
        quantity.names = {"aero.drag", "aero.lift"};
        quantity.program = quantity.cache_key = "solver";
        quantity.cache = folder / "answers";
        quantity.evaluate = [this](const QuantityRequest& request) {
            ++calls;
            QuantityResult result;
            result.values = {0.1 + (request.parameters.empty() ? 0.0 : request.parameters[0].second), -2};
            if (request.want_sensitivities) result.dJ_dv.assign(2, request.surface.vertices);
            if (request.want_sensitivities) result.dJ_dp.assign(2, Eigen::VectorXd::Constant(1, 0.3));
            return result;
        };
    }
    QuantityResult ask(bool gradients = false, const std::string& surface = "aa", double alpha = 0.5) {
        QuantityRequest request{mesh, gradients, 3, 1, {}, {{"alpha", alpha}}};
        request.surface_hash = surface;
        return cached_answer(quantity, request);
    }
    std::vector<fs::path> entries() const {
        std::vector<fs::path> files;
        for (const auto& entry : fs::directory_iterator(folder / "answers")) files.push_back(entry.path());
        return files;
    }
};

TEST_F(AnswerCache, TheSameQuestionIsAskedOnceAndAnsweredBitByBit) {
    const QuantityResult first = ask(true), second = ask(true);
    EXPECT_EQ(calls, 1);
    EXPECT_EQ(first.values, second.values);
    EXPECT_EQ(first.dJ_dv, second.dJ_dv);
    EXPECT_EQ(first.dJ_dp, second.dJ_dp);
    EXPECT_TRUE(first.remarks.empty());
    ASSERT_EQ(second.remarks.size(), 1u);
    EXPECT_EQ(second.remarks[0], "aero.drag is taken from the cache");
}

TEST_F(AnswerCache, AnotherQuestionIsAsked) {
    ask();
    ask(true);
    ask(false, "ab");
    ask(false, "aa", 0.6);
    quantity.cache_key = "another solver";
    ask();
    mesh = icosphere(0);
    ask();
    EXPECT_EQ(calls, 6);
    EXPECT_EQ(entries().size(), 6u);
}

TEST_F(AnswerCache, FailuresAndWhatStandsForThemAreNotKept) {
    quantity.evaluate = [this](const QuantityRequest&) {
        ++calls;
        QuantityResult result;
        result.values = {1, 1};
        if (calls == 1)
            result.failure = Failure{"exit", "3"};
        else
            result.is_substitute = true;
        return result;
    };
    for (int k = 0; k < 3; ++k) ask();
    EXPECT_EQ(calls, 3);
    EXPECT_FALSE(fs::exists(quantity.cache));
}

TEST_F(AnswerCache, WhatIsDamagedIsToldAndAskedAnew) {
    ask(true);
    const std::string whole = bytes_of(entries().at(0));
    const std::vector<double> values = ask(true).values;
    for (std::size_t size : {std::size_t{0}, std::size_t{10}, whole.size() / 2, whole.size() - 1}) {
        folder.write("answers/" + entries()[0].filename().string(), whole.substr(0, size));
        const int before = calls;
        const QuantityResult again = ask(true);
        EXPECT_EQ(calls, before + 1) << size;
        EXPECT_EQ(again.values, values);
        ASSERT_EQ(again.remarks.size(), 1u);
        EXPECT_NE(again.remarks[0].find("is not used"), std::string::npos);
    }
    for (std::size_t at = 0; at < whole.size(); at += 1 + whole.size() / 40) {
        std::string flipped = whole;
        flipped[at] = static_cast<char>(flipped[at] ^ 4);
        folder.write("answers/" + entries()[0].filename().string(), flipped);
        const int before = calls;
        EXPECT_EQ(ask(true).values, values);
        EXPECT_EQ(calls, before + 1) << "byte " << at;
    }
    // The name of one question with the answer to another.
    const fs::path one = entries()[0];
    ask(true, "other");
    for (const fs::path& file : entries())
        if (file != one) fs::copy_file(file, one, fs::copy_options::overwrite_existing);
    const int before = calls;
    ask(true);
    EXPECT_EQ(calls, before + 1);
}

TEST_F(AnswerCache, RunsMayShareAFolder) {
    std::vector<std::thread> runs;
    std::atomic<bool> right{true};
    for (int k = 0; k < 8; ++k)
        runs.emplace_back([&] {
            for (int j = 0; j < 20; ++j) right = right && ask(true, std::to_string(j % 5)).values[1] == -2;
        });
    for (std::thread& run : runs) run.join();
    EXPECT_TRUE(right);
    EXPECT_EQ(entries().size(), 5u);
    EXPECT_LT(calls, 60);
}

/// The program has run, perhaps for hours: its answer counts.
TEST_F(AnswerCache, AFolderThatCannotBeMadeIsARemark) {
    folder.write("file", "");
    quantity.cache = folder / "file" / "answers";
    const QuantityResult answer = ask(true);
    EXPECT_EQ(answer.values[1], -2);
    EXPECT_EQ(answer.dJ_dv.size(), 2u);
    ASSERT_EQ(answer.remarks.size(), 1u);
    EXPECT_NE(answer.remarks[0].find("the answer of aero.drag is not kept for other runs: "), std::string::npos);
    EXPECT_NE(answer.remarks[0].find((folder / "file").string()), std::string::npos) << answer.remarks[0];
    ask(true);
    EXPECT_EQ(calls, 2);
}

}  // namespace
}  // namespace strake
