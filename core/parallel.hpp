#pragma once
#include <vector>

/// Loops on several threads, whose results are the same bits for any number of them.
///
///     for_blocks(n, 1000, [&](int begin, int end) {
///         for (int i = begin; i < end; ++i) y[i] = f(x, i);
///     });
///     const double E = ordered_sum(n, 1000, [&](int begin, int end) { ... return part; });
///
/// 0..n is cut into blocks of the same size, whatever the number of threads. Whoever is idle takes the next block, and
/// the calling thread is one of them: where no other processor is free it does all of the work itself, and waits for
/// none but those in the middle of a block. So work must not care who does it and when: a block writes what no other
/// block reads or writes. Choose blocks of some 20 to 100 microseconds; n within one block is no parallel loop at all.
///
/// The threads are started when the first loop needs them and live as long as the process; between loops they wait,
/// the first few microseconds at the ready, then asleep. They take no signals. Where the system gives none, the loop
/// goes on with those that there are. A loop inside of a block, and one of a second thread while the first one's runs,
/// is done by its own thread alone. A child process made by fork() starts its own threads.
namespace strake {

constexpr int max_threads = 64;
/// Threads of a loop, the calling one included: what set_num_threads said, else the environment's STRAKE_NUM_THREADS,
/// else as many as there are processors for this process, but `most`: more than two were never measured for loops that
/// wait for memory, as nearly all do.
/// @throws InvalidInput: STRAKE_NUM_THREADS is no number from 1 to max_threads
int num_threads(int most = 2);
/// For the whole process, from the next loop on; 0: as if it had not been said. @throws InvalidInput
void set_num_threads(int threads);
/// Processors that this process may use.
int num_processors();

namespace detail {
using BlockCall = void (*)(const void* work, int begin, int end);
void for_blocks(int n, int block, BlockCall call, const void* work, int threads);
}  // namespace detail

/// Calls work(begin, end) for each block of 0..n. The first exception, in the order of the blocks, reaches the caller;
/// blocks after it may be left out.
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
