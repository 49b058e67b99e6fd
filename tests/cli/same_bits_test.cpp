#include "cases/geometry/wing.hpp"
#include "cli/run_strake.hpp"
#include "core/formats/io.hpp"

#include <gtest/gtest.h>

/// The same case gives the same bits whatever the surroundings of the program are.
namespace strake {
namespace {

namespace fs = std::filesystem;

const char* yaml = R"(case: wing
surface: {file: wing.obj}
regions: {root: {box: [[-9, -9, -9], [9, 0.1, 9]]}}
fixed: [root]
symmetry: {plane: y}
parameters: {patches_per_level: [4, 12], variables: [load], split: sensitivity}
objective: {maximize: volume}
constraints: {area: {max: 1.0, relative: true}}
optimize: {starts: 2, seed: 5, budget: {evaluations: 12}}
output: {paraview: none}
)";

/// The environment of the program, put back at the end.
class Surroundings {
public:
    void set(const std::string& name, const std::string& value) {
        if (const char* old = std::getenv(name.c_str()))
            before_.emplace_back(name, old);
        else
            before_.emplace_back(name, "");
        setenv(name.c_str(), value.c_str(), 1);
    }
    ~Surroundings() {
        for (const auto& [name, value] : before_)
            if (value.empty())
                unsetenv(name.c_str());
            else
                setenv(name.c_str(), value.c_str(), 1);
    }

private:
    std::vector<std::pair<std::string, std::string>> before_;
};

TEST(SameBits, ForOneAndTwoThreadsAnyFolderLocaleAndEnvironment) {
    const TempFolder folder;
    write_surface(folder / "wing.obj", example::wing(1500), SurfaceFormat::obj);
    const std::string file = folder.write("case.yaml", yaml).string();
    const auto run = [&](const std::string& out) {
        const ProgramRun r = run_strake({"run", file, "-q", "--out", (folder / out).string()});
        EXPECT_EQ(r.status, 0) << r.err;
        return std::array<std::string, 3>{bytes_of(folder / out / "history.csv"), bytes_of(folder / out / "best.obj"),
                                          bytes_of(folder / out / "levels/best.csv")};
    };
    const auto first = run("one");
    ASSERT_GT(std::count(first[0].begin(), first[0].end(), '\n'), 3);
    {
        Surroundings around;
        around.set("OMP_NUM_THREADS", "1");
        around.set("OPENBLAS_NUM_THREADS", "1");
        around.set("STRAKE_NUM_THREADS", "1");
        EXPECT_EQ(run("one thread"), first);
    }
    {
        Surroundings around;
        around.set("OMP_NUM_THREADS", "2");
        around.set("OPENBLAS_NUM_THREADS", "2");
        around.set("STRAKE_NUM_THREADS", "2");
        around.set("LC_ALL", "de_DE.UTF-8");  // where it is installed
        around.set("STRAKE_TEST_PADDING", std::string(100000, 'x'));
        EXPECT_EQ(run("deeper/two threads"), first);
    }
    // The seed is in the case that the run used; another one makes another run.
    EXPECT_NE(bytes_of(folder / "one/case.yaml").find("seed: 5"), std::string::npos);
    std::string other = yaml;
    folder.write("case.yaml", other.replace(other.find("seed: 5"), 7, "seed: 6"));
    EXPECT_NE(run("other seed")[0], first[0]);
}

}  // namespace
}  // namespace strake
