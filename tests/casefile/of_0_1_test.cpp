#include "casefile/load_case.hpp"
#include "casefile/read/resolved_case.hpp"
#include "core/text/file.hpp"
#include "tests/casefile/folder.hpp"

#include <gtest/gtest.h>
#include <cstdlib>

/// Case files of version 0.1, as they were: tests/casefile/of_0_1. The examples that it came with are run by
/// of_0_1_test.py.
namespace strake {
namespace {

/// The files of `keys` hold every key that 0.1 had.
TEST(CasesOf01, EveryKeyIsStillRead) {
    const Folder folder;
    folder.write("wing.obj", tetrahedron_obj);
    folder.write("flap.txt", "0\n");
    folder.write("lines.csv", "0.2,0.2,0.1,0,0,1,0.5\n");
    folder.write("points.csv", "0.2,0.2,0.1\n0.3,0.1,0,2\n");
    for (const char* of_slurm : {"sbatch", "squeue", "sacct", "scancel"})
        std::filesystem::permissions(folder.write(of_slurm, "#!/bin/sh\n"), std::filesystem::perms::owner_all);
    const char* path = std::getenv("PATH");
    const std::string before = path ? path : "/usr/bin:/bin";
    setenv("PATH", (folder.path().string() + ":" + before).c_str(), 1);
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(STRAKE_SOURCE_DIR "/tests/casefile/of_0_1/keys")) {
        const auto file = folder.write("case.yaml", read_bytes(entry.path()));
        ++count;
        try {
            const Case c = load_case(file);
            const std::string now = resolved_case(c, folder.path());
            EXPECT_EQ(resolved_case(load_case(folder.write("again.yaml", now)), folder.path()), now) << entry.path();
        } catch (const std::exception& error) {
            ADD_FAILURE() << entry.path() << "\n" << error.what();
        }
    }
    setenv("PATH", before.c_str(), 1);
    EXPECT_EQ(count, 4);
}

}  // namespace
}  // namespace strake
