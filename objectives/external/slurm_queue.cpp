#include "core/error.hpp"
#include "core/text/file.hpp"
#include "objectives/external/job.hpp"
#include "objectives/external/slurm_client.hpp"

#include <unistd.h>
#include <charconv>
#include <sstream>

namespace strake {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// "[days-][hours:]minutes:seconds" in seconds.
double seconds_of(const std::string& words) {
    double days = 0, total = 0, part = 0;
    for (const char c : words) {
        if (c == '-') days = part, part = 0;
        if (c == ':') total = 60 * (total + part), part = 0;
        if (c >= '0' && c <= '9') part = 10 * part + (c - '0');
    }
    return 86400 * days + total + part;
}

std::map<std::string, SlurmQueue::Job> jobs_in(const std::string& list) {
    std::map<std::string, SlurmQueue::Job> jobs;
    std::istringstream lines(list);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream fields(line);
        std::string id, used;
        SlurmQueue::Job job;
        std::getline(fields, id, '|') && std::getline(fields, job.state, '|') &&
            std::getline(fields, job.reason, '|') && std::getline(fields, used, '|') && std::getline(fields, job.name);
        job.seconds = seconds_of(used);
        if (!id.empty()) jobs[id] = job;
    }
    return jobs;
}

}  // namespace

ClientOutput slurm_client(const std::vector<std::string>& arguments, const fs::path& scratch) {
    std::string folder = (scratch / "client-XXXXXX").string();
    if (::mkdtemp(folder.data()) == nullptr) throw OutputError(text(folder, ": cannot be created"));
    ProcessCommand process;
    process.arguments = arguments;
    process.folder = folder;
    process.timeout_s = 60;
    const ProcessEnd end = run_process(process);
    ClientOutput output;
    output.is_done = !end.failure;
    if (output.is_done) output.words = read_bytes(fs::path(folder) / "stdout.log");
    if (end.failure)
        output.words =
            text(arguments.front(), ": ", end.failure->message, end.last_lines.empty() ? "" : "\n", end.last_lines);
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    return output;
}

SlurmQueue::View SlurmQueue::view(const fs::path& scratch) {
    const std::lock_guard lock(busy_);
    if (last_.asked != Clock::time_point() && Clock::now() - last_.asked < poll_) return last_;
    last_.asked = Clock::now();
    // Queries all our jobs: a query for a single missing job would look like any other error.
    const ClientOutput output =
        slurm_client({"squeue", "--noheader", text("--user=", ::geteuid()), "--format=%i|%T|%r|%M|%j"}, scratch);
    last_.is_known = output.is_done;
    last_.words = output.is_done ? "" : output.words;
    last_.jobs = output.is_done ? jobs_in(output.words) : std::map<std::string, Job>();
    return last_;
}

}  // namespace strake
