#pragma once
#include "objectives/external/attempt.hpp"

#include <chrono>
#include <map>
#include <mutex>

/// Programs as jobs of Slurm. Internal.
namespace strake {

/// The user's jobs as squeue tells them, asked at most once in `poll_s` however many calls follow theirs.
class SlurmQueue {
public:
    explicit SlurmQueue(double poll_s) : poll_(poll_s) {}
    struct Job {
        std::string name, state, reason;  ///< PENDING, PartitionConfig
        double seconds = 0;               ///< that it has run
    };
    struct View {
        std::chrono::steady_clock::time_point asked;
        bool is_known = false;  ///< squeue answered
        std::string words;      ///< why not
        std::map<std::string, Job> jobs;
    };
    /// Not older than `poll_s`. @param scratch folder in which files may be made meanwhile. @throws OutputError.
    View view(const std::filesystem::path& scratch);

private:
    std::chrono::duration<double> poll_;
    std::mutex busy_;
    View last_;
};

/// Attempt `number` at the task as a job: `job.sh` in its folder is submitted with sbatch; its number is kept in the
/// file `job`, its exit status comes in `exit` (with the call's prefix before these names). The first attempt of a
/// later start follows the job that an earlier one submitted for the same task. The job is cancelled at the timeout,
/// when it can never start, and when the request is given up; else it goes on when the run is interrupted. Failures:
/// submit, never_starts, vanished, timeout and those of any program.
/// @throws Interrupted (naming the job where it goes on); OutputError.
QuantityResult attempt_as_job(const Task& task, SlurmQueue& queue, int number);

}  // namespace strake
