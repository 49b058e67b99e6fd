#pragma once
#include <vector>

/// Loops on several threads, whose results are the same bits for any number of them.
///
///     for_blocks(n, 1000, [&](int begin, int end) {
///         for (int i = begin; i < end; ++i) y[i] = f(x, i);
///     });
///     const double E = ordered_sum(n, 1000, [&](int begin, int end) { ... return part; });
///
/// 0..n is cut into blocks of the same size, whatever the number of threads. An idle thread takes the next block, and
/// the calling thread is one of them: when no other processor is free it does all the work itself and waits only for
/// blocks in progress. A block must not depend on its thread or its time: it writes only what no other block reads or
/// writes. Choose blocks of 20 to 100 microseconds; n within one block runs serially.
///
/// The first loop starts the threads, which live as long as the process; between loops they spin for a few
/// microseconds, then sleep. They take no signals. If the system refuses a thread, the loop runs on those available. A
/// loop inside a block, or on a second thread while another loop runs, is serial. A child process after fork() starts
/// its own threads.
namespace strake {

constexpr int max_threads = 64;
/// Threads of a loop, the calling one included: from set_num_threads, else the environment's STRAKE_NUM_THREADS, else
/// the processors available to this process, at most `most`: nearly all loops wait for memory and were never measured
/// on more.
/// @throws InvalidInput: STRAKE_NUM_THREADS is not a number from 1 to max_threads
int num_threads(int most = 2);
/// For the whole process, from the next loop on; 0: back to the default. @throws InvalidInput
void set_num_threads(int threads);
/// Processors that this process may use.
int num_processors();

namespace detail {
using BlockCall = void (*)(const void* work, int begin, int end);
void for_blocks(int n, int block, BlockCall call, const void* work, int threads);
}  // namespace detail

/// Calls work(begin, end) for each block of 0..n. The first exception, in the order of the blocks, reaches the caller;
/// blocks after it may be skipped.
/// @param threads 0: num_threads()
template <class Work>
void for_blocks(int n, int block, const Work& work, int threads = 0) {
    const auto call = [](const void* w, int begin, int end) { (*static_cast<const Work*>(w))(begin, end); };
    detail::for_blocks(n, block, call, &work, threads);
}

/// The sum of part(begin, end) over the blocks of 0..n, in their order.
template <class Part>
double ordered_sum(int n, int block, const Part& part) {
    if (n <= block) return n > 0 ? part(0, n) : 0;
    std::vector<double> parts((n - 1) / block + 1);
    for_blocks(n, block, [&](int begin, int end) { parts[begin / block] = part(begin, end); });
    double sum = 0;
    for (const double one : parts) sum += one;
    return sum;
}

}  // namespace strake
