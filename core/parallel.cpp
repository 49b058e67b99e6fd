#include "core/parallel.hpp"

#include <pthread.h>
#include <sched.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <charconv>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

#include "core/error.hpp"

namespace strake {
namespace {

constexpr int ready_looks = 400;  // polls of a flag, some 10 microseconds, before a thread sleeps

void look_again() {
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
}

/// A running loop; lives on its caller's stack.
struct Loop {
    const int n, block, blocks;
    const detail::BlockCall call;
    const void* const work;
    std::atomic<int> next{0};    ///< next free block
    std::atomic<int> inside{0};  ///< other threads at work; grows only while the pool's mutex is held
    std::mutex failing{};
    int failed_block = 0;
    std::exception_ptr failure{};

    void take_blocks() {
        for (int b; (b = next.fetch_add(1, std::memory_order_relaxed)) < blocks;) {
            try {
                const int begin = b * block;
                call(work, begin, n - begin < block ? n : begin + block);
            } catch (...) {
                next.store(blocks, std::memory_order_relaxed);  // all blocks before this one have been taken
                const std::scoped_lock lock(failing);
                if (!failure || b < failed_block) failure = std::current_exception(), failed_block = b;
            }
        }
    }
};

thread_local bool is_in_loop = false;

struct InLoop {
    InLoop() { is_in_loop = true; }
    ~InLoop() { is_in_loop = false; }
};

class Pool {
public:
    /// False while another thread's loop runs.
    bool run(Loop& loop, int threads) {
        const std::unique_lock one_at_a_time(busy_, std::try_to_lock);
        if (!one_at_a_time) return false;
        need(threads - 1);
        open(loop, threads - 1);
        loop.take_blocks();
        close(loop);
        return true;
    }

private:
    /// Starts threads up to `count`; fewer if the system refuses.
    void need(int count) {
        if (static_cast<int>(workers_) >= count) return;
        sigset_t all, before;  // signals belong to the program's own threads
        sigfillset(&all);
        pthread_sigmask(SIG_SETMASK, &all, &before);
        try {
            for (; workers_ < count; ++workers_) std::thread([this, id = workers_] { serve(id); }).detach();
        } catch (const std::exception&) {  // no more available
        }
        pthread_sigmask(SIG_SETMASK, &before, nullptr);
    }

    void open(Loop& loop, int others) {
        int wake = 0;
        {
            const std::scoped_lock lock(mutex_);
            loop_ = &loop;
            others_ = others;
            round_.fetch_add(1, std::memory_order_release);
            wake = std::min(asleep_, others);
        }
        if (wake > 1 || others < workers_)  // if not all may join, notify everyone to reach those that may
            come_.notify_all();
        else if (wake == 1)
            come_.notify_one();
    }

    /// Closes the loop to further threads and waits for those inside.
    void close(Loop& loop) {
        {
            const std::scoped_lock lock(mutex_);
            loop_ = nullptr;
        }
        for (int k = 0; k < ready_looks && loop.inside.load(std::memory_order_acquire) > 0; ++k) look_again();
        std::unique_lock lock(mutex_);  // the last thread to leave holds it until it no longer uses the loop
        gone_.wait(lock, [&] { return loop.inside.load(std::memory_order_acquire) == 0; });
    }

    void serve(int id) {
        is_in_loop = true;
        for (unsigned seen = 0;;) {
            for (int k = 0; k < ready_looks && round_.load(std::memory_order_acquire) == seen; ++k) look_again();
            std::unique_lock lock(mutex_);
            ++asleep_;
            come_.wait(lock, [&] { return round_.load(std::memory_order_relaxed) != seen; });
            --asleep_;
            seen = round_.load(std::memory_order_relaxed);
            Loop* loop = loop_;
            if (!loop || id >= others_) continue;
            loop->inside.fetch_add(1, std::memory_order_relaxed);
            lock.unlock();
            loop->take_blocks();
            lock.lock();
            if (loop->inside.fetch_sub(1, std::memory_order_release) == 1) gone_.notify_one();
        }
    }

    std::mutex busy_;   ///< held by the thread whose loop runs
    std::mutex mutex_;  ///< of what follows
    std::condition_variable come_, gone_;
    std::atomic<unsigned> round_{0};
    Loop* loop_ = nullptr;
    int others_ = 0;  ///< threads that may join
    int asleep_ = 0;
    int workers_ = 0;  ///< changed under busy_
};

/// Never destroyed: threads wait in it until the process ends.
std::atomic<Pool*>& pool() {
    static std::atomic<Pool*> only = [] {
        // Threads do not survive fork(): the child gets its own pool and ignores this one, whatever its state.
        pthread_atfork(nullptr, nullptr, [] { pool().store(new Pool); });
        return new Pool;
    }();
    return only;
}

std::atomic<int>& wanted() {
    static std::atomic<int> threads = 0;
    return threads;
}

/// 0: not set.
int threads_of_environment() {
    const char* words = std::getenv("STRAKE_NUM_THREADS");
    if (!words || !*words) return 0;
    int number = 0;
    const char* end = words + std::strlen(words);
    const auto [after, error] = std::from_chars(words, end, number);
    if (error != std::errc() || after != end || number < 1 || number > max_threads)
        throw InvalidInput(text("STRAKE_NUM_THREADS = ", words, " must be a whole number from 1 to ", max_threads));
    return number;
}

}  // namespace

int num_processors() {
#ifdef __linux__
    cpu_set_t set;  // the process may be restricted to fewer processors
    if (sched_getaffinity(0, sizeof set, &set) == 0) return std::max(1, CPU_COUNT(&set));
#endif
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

int num_threads(int most) {
    if (const int threads = wanted(); threads > 0) return threads;
    static const int said = threads_of_environment(), processors = num_processors();
    return said > 0 ? said : std::min({most, processors, max_threads});
}

void set_num_threads(int threads) {
    if (threads < 0 || threads > max_threads)
        throw InvalidInput(text("threads = ", threads, " must be from 1 to ", max_threads, ", or 0 for the default"));
    wanted() = threads;
}

void detail::for_blocks(int n, int block, BlockCall call, const void* work, int threads) {
    if (n <= 0) return;
    if (n <= block) return call(work, 0, n);
    Loop loop{n, block, (n - 1) / block + 1, call, work};
    if (threads <= 0) threads = num_threads();
    threads = std::min({threads, loop.blocks, max_threads});
    if (is_in_loop || threads == 1) {
        for (int begin = 0; begin<n; begin = n - begin> block ? begin + block : n)
            call(work, begin, n - begin > block ? begin + block : n);
        return;
    }
    const InLoop here;
    if (!pool().load()->run(loop, threads)) loop.take_blocks();
    if (loop.failure) std::rethrow_exception(loop.failure);
}

}  // namespace strake
