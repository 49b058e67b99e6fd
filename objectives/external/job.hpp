#pragma once
#include "objectives/external/attempt.hpp"

#include <chrono>
#include <map>
#include <mutex>

/// Programs as Slurm jobs. Internal.
namespace strake {

/// The user's jobs from squeue, queried at most once per `poll_s` for all calls.
class SlurmQueue {
public:
    explicit SlurmQueue(double poll_s) : poll_(poll_s) {}
    struct Job {
        std::string name, state, reason;  ///< PENDING, PartitionConfig
        double seconds = 0;               ///< running time so far
    };
    struct View {
        std::chrono::steady_clock::time_point asked;
        bool is_known = false;  ///< squeue has answered
        std::string words;      ///< reason if not
        std::map<std::string, Job> jobs;
    };
    /// A view not older than `poll_s`. @param scratch folder for temporary files @throws OutputError.
    View view(const std::filesystem::path& scratch);

private:
    std::chrono::duration<double> poll_;
    std::mutex busy_;
    View last_;
};

/// Attempt `number` of the task as a job: submits `job.sh` in its folder with sbatch; the file `job` keeps its number,
/// the file `exit` its exit status (with the call's prefix before these names). The first attempt of a later start
/// resumes the job of an earlier start for the same task. The job is cancelled at the timeout, when it can never start,
/// and when the request is cancelled; if the run is interrupted, it stays in the queue. Failures: submit, never_starts,
/// vanished, timeout and those of any program.
/// @throws Interrupted (naming the pending job); OutputError.
QuantityResult attempt_as_job(const Task& task, SlurmQueue& queue, int number);

}  // namespace strake
