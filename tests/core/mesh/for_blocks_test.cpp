#include "core/parallel.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "core/error.hpp"

/// Loops on several threads.
namespace strake {
namespace {

/// Whatever a test has set is taken back.
class Parallel : public testing::Test {
protected:
    void TearDown() override { set_num_threads(0); }
};

/// How often each of 0..n was worked on.
std::vector<int> visits(int n, int block, int threads) {
    std::vector<int> count(n, 0);
    for_blocks(
        n, block,
        [&](int begin, int end) {
            EXPECT_LT(begin, end);
            EXPECT_EQ(begin % block, 0);
            EXPECT_TRUE(end - begin == block || end == n);
            for (int i = begin; i < end; ++i) ++count[i];
        },
        threads);
    return count;
}

TEST_F(Parallel, EveryElementOnceInBlocksThatDoNotDependOnThreads) {
    for (const int threads : {1, 2, 3, 8})
        for (const int n : {0, 1, 7, 8, 9, 1000})
            for (const int block : {1, 8, 1000, 5000})
                EXPECT_EQ(visits(n, block, threads), std::vector<int>(n, 1)) << n << " by " << block;
    for_blocks(-1, 8, [](int, int) { FAIL(); });
}

TEST_F(Parallel, TheSameSumsForAnyNumberOfThreads) {
    constexpr int n = 100003;
    const auto part = [](int begin, int end) {
        double sum = 0;
        for (int i = begin; i < end; ++i) sum += std::sin(i) / (1 + i);
        return sum;
    };
    set_num_threads(1);
    const double one = ordered_sum(n, 100, part);
    EXPECT_NEAR(one, part(0, n), 1e-12);
    for (const int threads : {2, 3, 8})
        for (int again = 0; again < 50; ++again) {
            set_num_threads(threads);
            EXPECT_EQ(ordered_sum(n, 100, part), one);
        }
    EXPECT_EQ(ordered_sum(0, 100, part), 0);
}

TEST_F(Parallel, TheFirstExceptionReachesTheCallerAndTheThreadsLiveOn) {
    for (const int threads : {1, 2, 4}) {
        set_num_threads(threads);
        for (int again = 0; again < 50; ++again) {
            try {
                for_blocks(1000, 1, [](int i, int) {
                    if (i >= 37 && i % 2) throw std::runtime_error(std::to_string(i));
                });
                FAIL() << "no exception";
            } catch (const std::runtime_error& e) {
                EXPECT_STREQ(e.what(), "37");
            }
        }
        EXPECT_EQ(visits(1000, 10, threads), std::vector<int>(1000, 1));
    }
}

TEST_F(Parallel, ALoopInsideOfABlockIsDoneByItsOwnThread) {
    set_num_threads(3);
    std::vector<int> wrong(64, 0);
    for_blocks(64, 1, [&](int block, int) {
        const auto here = std::this_thread::get_id();
        int last = -1;  // in order, too
        for_blocks(100, 7, [&](int begin, int) {
            if (std::this_thread::get_id() != here || begin <= last) ++wrong[block];
            last = begin;
        });
    });
    EXPECT_EQ(std::accumulate(wrong.begin(), wrong.end(), 0), 0);
}

TEST_F(Parallel, OtherThreadsTakePart) {
    set_num_threads(2);
    std::atomic<int> there = 0;
    for_blocks(2, 1, [&](int, int) {  // ends only when two threads are in it
        ++there;
        for (long waited = 0; there < 2 && waited < 20000; ++waited)
            std::this_thread::sleep_for(std::chrono::microseconds(500));
    });
    EXPECT_EQ(there, 2);
}

TEST_F(Parallel, LoopsOfSeveralThreadsDoNotDisturbEachOther) {
    set_num_threads(2);
    std::vector<std::thread> callers;
    std::atomic<int> wrong = 0;
    for (int c = 0; c < 3; ++c)
        callers.emplace_back([&] {
            for (int again = 0; again < 200; ++again)
                if (visits(500, 7, 0) != std::vector<int>(500, 1)) ++wrong;
        });
    for (std::thread& caller : callers) caller.join();
    EXPECT_EQ(wrong, 0);
}

TEST_F(Parallel, AChildProcessHasThreadsOfItsOwn) {
    set_num_threads(2);
    visits(1000, 10, 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        ::alarm(20);
        ::_exit(visits(1000, 10, 2) == std::vector<int>(1000, 1) ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
    EXPECT_EQ(visits(1000, 10, 2), std::vector<int>(1000, 1));
}

TEST_F(Parallel, NumbersOfThreads) {
    EXPECT_GE(num_processors(), 1);
    EXPECT_GE(num_threads(), 1);
    set_num_threads(5);
    EXPECT_EQ(num_threads(), 5);
    EXPECT_THROW(set_num_threads(-1), InvalidInput);
    EXPECT_THROW(set_num_threads(max_threads + 1), InvalidInput);
    EXPECT_EQ(num_threads(), 5);
}

}  // namespace
}  // namespace strake
