#pragma once
#include "ask.hpp"
#include "core/mesh/geometry.hpp"
#include "objectives/external/external.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>
#include <unistd.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace strake {

inline std::string contents(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// A folder of its own for every test, gone afterwards; a sphere, and the fake solver in a role.
class ExternalTest : public testing::Test {
protected:
    void SetUp() override {
        std::string name = (std::filesystem::temp_directory_path() / "strake-test-XXXXXX").string();
        ASSERT_NE(::mkdtemp(name.data()), nullptr);
        folder = name;
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    ExternalCommand fake(const std::string& role) const {
        ExternalCommand command;
        command.name = "aero";
        command.command = {FAKE_SOLVER, role, "{request}", "{result}"};
        command.timeout_s = 60;
        command.grace_s = 1;
        command.format = "obj";
        command.case_dir = folder;
        command.evaluations_dir = folder / "evaluations";
        command.diagonal = box_diagonal(mesh);
        command.units = "mm";
        return command;
    }
    QuantityResult ask(const ExternalCommand& command, bool sensitivities = false, int evaluation = 1) const {
        return external(command).evaluate({mesh, sensitivities, evaluation, 2, {{"alpha", 0.05}, {"tip.load_x", -2}}});
    }

    std::filesystem::path folder;
    TriMesh mesh = icosphere(2);
};

}  // namespace strake
