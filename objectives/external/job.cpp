#include "objectives/external/job.hpp"

#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/text/file.hpp"
#include "core/text/shell_word.hpp"
#include "objectives/external/attempt.hpp"
#include "objectives/external/refused.hpp"
#include "objectives/external/slurm_client.hpp"

#include <sys/stat.h>
#include <algorithm>
#include <charconv>
#include <cstring>
#include <string_view>
#include <thread>

namespace strake {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double settle_polls = 5;  ///< delay of the exit file on a network disk after the job's end, in polls
constexpr double patience_s = 600;  ///< limit without an answer of squeue

/// Reasons why a pending job can never start as submitted.
bool is_hopeless(const std::string& reason) {
    for (const char* known :
         {"PartitionConfig", "PartitionNodeLimit", "PartitionTimeLimit", "BadConstraints", "AccountNotAllowed",
          "QOSNotAllowed", "InvalidAccount", "InvalidQOS", "DependencyNeverSatisfied", "ReservationDeleted"})
        if (reason == known) return true;
    const bool is_limit = reason.starts_with("Assoc") || reason.starts_with("QOS");
    return is_limit && (reason.find("PerJob") != std::string::npos || reason.find("WallDuration") != std::string::npos);
}

class Job {
public:
    Job(const Task& task, SlurmQueue& queue)
        : task_(task), command_(task.command), queue_(queue), request_(task.request) {}

    QuantityResult run(int number) {
        try {
            if (!(number == 1 && command_.may_follow_others && adopt())) {
                call_ = fresh_place(task_, number);
                prepare();
                submit();
            }
            follow();
            const int status = exit_status();
            if (status != 0) throw Refused{failure_of(status)};
            return read_results(task_, call_);
        } catch (const Refused& refused) {
            std::error_code ignored;
            fs::rename(call_.file("job.sh"), call_.file("job.sh.ended"), ignored);  // so it is not resumed again
            return failed(task_, call_, refused.failure, last_lines_in(call_));
        }
    }

private:
    static std::string name_of(const Call& call) {
        struct stat info {};
        ::stat(call.folder.c_str(), &info);
        return text("strake-", info.st_ino, "-", call.prefix, call.folder.filename().string());
    }

    void prepare() {
        hand_over(task_, call_);
        sign(task_, call_);
        const std::string exit = call_.prefix + "exit";
        const std::string script =
            text("#!/bin/sh\ncd ", shell_word(call_.folder.string()), " || exit 1\necho \"$SLURM_JOB_ID\" > ",
                 call_.prefix, "job.started\n", shell_line(command_, call_), "\nstatus=$?\necho $status > ", exit,
                 ".new && mv ", exit, ".new ", exit, "\nexit $status\n");
        write_atomically(call_.file("job.sh"), script);  // last: marks the place as complete
    }

    void submit() {
        const auto plain = [](const fs::path& path) {  // sbatch replaces %j and the like
            std::string name;
            for (const char c : path.string()) name.append(c == '%' ? 2 : 1, c);
            return name;
        };
        std::vector<std::string> arguments{"sbatch",
                                           "--parsable",
                                           "--job-name=" + name_of(call_),
                                           "--chdir=" + call_.folder.string(),
                                           "--output=" + plain(call_.file("job.out")),
                                           "--no-requeue"};
        arguments.insert(arguments.end(), command_.slurm->begin(), command_.slurm->end());
        arguments.push_back(call_.file("job.sh").string());
        const ClientOutput output = slurm_client(arguments, call_.folder);
        id_ = output.words.substr(0, output.words.find_first_of(";\n"));  // with several clusters: id;cluster
        if (!output.is_done) throw Refused{{"submit", output.words}};
        if (id_.empty() || id_.find_first_not_of("0123456789") != std::string::npos)
            throw Refused{{"submit", text("sbatch returned no job number, but '", printable(output.words, 200), "'")}};
        write_atomically(call_.file("job"), id_ + "\n");
        submitted_ = Clock::now();
    }

    /// The job of an earlier start for this task, unless failed.
    bool adopt() {
        std::error_code ignored;
        int last = 0;
        while (is_taken(task_, place(task_, last + 1))) ++last;
        for (; last > 0; --last) {
            call_ = place(task_, last);
            if (!fs::exists(call_.file("job.sh"), ignored) || !is_of(task_, call_)) continue;
            submitted_ = Clock::now();
            if (!find_number()) submit();
            return true;
        }
        return false;
    }

    /// From our file, the job's file, or the queue: an earlier start may have been killed just after submission.
    bool find_number() {
        for (const char* name : {"job", "job.started"}) {
            std::error_code ignored;
            if (!fs::is_regular_file(call_.file(name), ignored)) continue;
            const std::string words = read_bytes(call_.file(name));
            id_ = words.substr(0, words.find('\n'));
            if (id_.empty()) continue;
            write_atomically(call_.file("job"), id_ + "\n");
            return true;
        }
        for (int look = 0; look < 2; ++look) {
            pause(command_.poll_s);  // a killed client's request may still arrive
            const SlurmQueue::View view = queue_.view(call_.folder);
            if (!view.is_known) throw Refused{{"submit", text("whether it was submitted is unknown: ", view.words)}};
            for (const auto& [id, job] : view.jobs)
                if (job.name == name_of(call_)) {
                    id_ = id;
                    write_atomically(call_.file("job"), id_ + "\n");
                    return true;
                }
        }
        return false;
    }

    void pause(double seconds) {
        const auto until = Clock::now() + std::chrono::duration<double>(seconds);
        do {
            if (request_.stop_wanted && request_.stop_wanted()) stop();
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        } while (Clock::now() < until && !has_ended());
    }

    [[noreturn]] void stop() {
        if (request_.is_cancelled && request_.is_cancelled()) {
            cancel();
            throw Interrupted{};
        }
        throw Interrupted{{text("job ", id_, " (", command_.name, ", evaluation ", request_.evaluation, ")")}};
    }

    void cancel() {
        slurm_client({"scancel", id_}, call_.folder);
        std::error_code ignored;
        fs::rename(call_.file("job.sh"), call_.file("job.sh.ended"), ignored);
    }

    /// On a network disk, or a full one, the file may be there before its number, or for ever without it.
    bool has_ended() const {
        std::error_code ignored;
        const auto size = fs::file_size(call_.file("exit"), ignored);
        return !ignored && size > 0;
    }

    double waited() const {  // in all starts together
        struct stat info {};
        if (::stat(call_.file("job.sh").c_str(), &info) != 0) return 0;
        return std::max(0.0, static_cast<double>(::time(nullptr) - info.st_mtime));
    }

    void follow() {
        auto known = Clock::now();
        int missing = 0, hopeless = 0;
        while (!has_ended()) {
            pause(interval());
            if (has_ended()) return;
            const SlurmQueue::View view = queue_.view(call_.folder);
            if (view.asked <= std::max(submitted_, looked_)) continue;  // nothing new
            if (!view.is_known) {
                if (Clock::now() - known > std::chrono::duration<double>(patience_s))
                    throw Refused{{"vanished", text("job ", id_, ": its state is unknown; ", view.words)}};
                continue;
            }
            known = looked_ = view.asked;
            const auto job = view.jobs.find(id_);
            missing = job == view.jobs.end() ? missing + 1 : 0;
            if (missing > 1) return wait_for_late_exit();
            if (missing == 0) hopeless = judge(job->second) ? hopeless + 1 : 0;
            if (hopeless > 1) give_up(job->second);
        }
    }

    /// Short at first, longer for jobs of hours.
    double interval() {
        const double age = std::chrono::duration<double>(Clock::now() - submitted_).count();
        return std::clamp(age / 20, 0.25, std::max(10.0, command_.poll_s));
    }

    /// Whether it waits in vain. @throws Refused at the limits.
    bool judge(const SlurmQueue::Job& job) {
        if (job.state == "PENDING") {
            if (waited() > command_.queue_s) {
                cancel();
                throw Refused{{"timeout", text("job ", id_, " did not start within ", command_.queue_s,
                                               " s, pending for ", job.reason, "; it was cancelled")}};
            }
            return is_hopeless(job.reason);
        }
        if (job.seconds > timeout_of(command_, call_)) {
            cancel();
            throw Refused{{"timeout", text("job ", id_, " has run longer than the timeout of ",
                                           timeout_of(command_, call_), " s; it was cancelled")}};
        }
        return false;
    }

    [[noreturn]] void give_up(const SlurmQueue::Job& job) {
        cancel();
        throw Refused{{"never_starts", text("job ", id_, " can never start as submitted (", job.reason,
                                            "); it was cancelled; change scheduler.slurm")}};
    }

    void wait_for_late_exit() {
        const auto until = Clock::now() + std::chrono::duration<double>(settle_polls * command_.poll_s);
        while (!has_ended() && Clock::now() < until) pause(0.2);
        if (has_ended()) return;
        std::error_code ignored;
        if (fs::exists(call_.file("exit"), ignored))
            throw Refused{{"vanished", text("job ", id_, " is gone, and its file ", call_.prefix,
                                            "exit is empty: is the disk full?", accounting())}};
        throw Refused{{"vanished", text("job ", id_, " is gone, and its command has not ended: cancelled, or its node ",
                                        "failed", accounting())}};
    }

    std::string accounting() const {
        const ClientOutput told = slurm_client(
            {"sacct", "--noheader", "--allocations", "--parsable2", "--format=State,ExitCode", "--jobs", id_},
            call_.folder);
        const std::string words = printable(told.words.substr(0, told.words.find('\n')), 200);
        return told.is_done && !words.empty() ? text(" (sacct: ", words, ")") : "";
    }

    int exit_status() const {
        const std::string words = read_bytes(call_.file("exit"));
        int status = 0;
        const auto [end, error] = std::from_chars(words.data(), words.data() + words.size(), status);
        if (error != std::errc() || std::string_view(end, words.data() + words.size()) != "\n")
            throw Refused{{"exit", text("its file ", call_.prefix, "exit holds '", printable(words, 40),
                                        "' and no exit status")}};
        return status;
    }

    static Failure failure_of(int status) {
        const char* name = status > 128 && status < 193 ? ::sigabbrev_np(status - 128) : nullptr;
        if (name != nullptr)
            return {"signal", text("exit status ", status, ": ended by signal SIG", name, ", or said so")};
        return {"exit", text("exit status ", status)};
    }

    const Task& task_;
    const ExternalCommand& command_;
    SlurmQueue& queue_;
    const QuantityRequest& request_;
    Call call_;
    std::string id_;
    Clock::time_point submitted_, looked_;
};

}  // namespace

QuantityResult attempt_as_job(const Task& task, SlurmQueue& queue, int number) { return Job(task, queue).run(number); }

}  // namespace strake
