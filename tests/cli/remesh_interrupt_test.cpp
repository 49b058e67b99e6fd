#include "core/formats/io.hpp"
#include "run_strake.hpp"
#include "surfaces.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

/// Ctrl-C while a case remeshes.
namespace strake {
namespace {

TEST(RemeshOfACase, IsEndedByTheFirstSignalWithNothingWritten) {
    const TempFolder folder;
    write_surface(folder / "s.obj", icosphere(4), SurfaceFormat::obj);
    std::ofstream(folder / "case.yaml")
        << "case: c\nsurface: {file: s.obj}\nremesh: {edge_length: 0.012, iterations: 300}\n"
           "regions: {low: {box: [[-2, -2, -2], [2, 2, -0.5]]}}\nfixed: [low]\n";
    const std::string out = (folder / "out.obj").string();
    int status = 0;
    // However busy the machine is, at one of these times it remeshes.
    for (int wait_ms = 200; wait_ms < 20000 && status != 75; wait_ms *= 2) {
        const std::string the_case = (folder / "case.yaml").string();
        const pid_t child = fork();
        if (child == 0) {
            dup2(open((folder / "err").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), 2);
            execl(STRAKE_PROGRAM, STRAKE_PROGRAM, "deform", the_case.c_str(), "-o", out.c_str(), nullptr);
            _exit(126);
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
        kill(child, SIGINT);
        int ended = 0;
        waitpid(child, &ended, 0);
        status = WIFEXITED(ended) ? WEXITSTATUS(ended) : 128 + WTERMSIG(ended);
        ASSERT_TRUE(status == 75 || status == 128 + SIGINT) << status;  // 130: before it began
    }
    EXPECT_EQ(status, 75);
    EXPECT_EQ(bytes_of((folder / "err").string()),
              "strake: interrupted by SIGINT while remeshing; nothing was written\n");
    EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace strake
