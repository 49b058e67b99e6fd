#pragma once
#include "objectives/quantity.hpp"

#include <filesystem>
#include <memory>

/// Other people's programs (DESIGN section 7, External evaluation; for users docs/external.md).
namespace strake {

struct ProgramPoints;

struct ExternalCommand {
    std::string name;  ///< of the quantity; values are called name.value, or name where `gives` is empty
    std::vector<std::string> command;  ///< argument list, run without a shell; replaced in it: {surface} {request}
                                       ///< {result} {folder} {case_dir}
    std::vector<std::string> gives;    ///< names of the values; empty: one value
    double timeout_s = 3600;           ///< per evaluation, > 0; then TERM, grace, KILL to the process group
    /// Run after `command`, in the same folder, when gradients are wanted; `command` then gives values only. {request}
    /// is gradient_request.json, {result} gradient.json: as result.json, without values. Empty: `command` gives both.
    std::vector<std::string> gradient_command = {};
    std::optional<double> gradient_timeout_s = {};  ///< > 0; without it timeout_s
    /// The program's own points: handed over where they move to, and what its gradients belong to. Null: the vertices.
    std::shared_ptr<const ProgramPoints> points = {};
    double grace_s = 5;  ///< >= 0
    std::string format;  ///< of the surface handed over: as `format_named`, or su2-positions (`handed_over_bytes`)
    std::filesystem::path case_dir;         ///< program paths containing '/' are relative to it
    std::filesystem::path evaluations_dir;  ///< fresh folders 000001, 000002, … are made here
    bool own_folder = false;                ///< in 000001/<name>: where several programs share evaluations_dir
    bool has_gradients = true;              ///< false: never asked for sensitivities
    /// Own variables of the case that the values depend on; the derivatives by others are 0. Without it: all.
    std::optional<std::vector<std::string>> depends_on;
    bool may_lack_derivatives = false;  ///< by own variables: NaN then; else their lack is a failure
    double diagonal = 0;   ///< of the start surface; rows with coordinates are matched within 1e-5 of it, > 0
    std::string units;     ///< of length, as the case states it, for request.json
    int retries = 0;       ///< further attempts after a failure, >= 0; not where the program cannot be started
    double pause_s = 0.1;  ///< before the first of them, twice as long before each next one (10 s at most), >= 0
    /// What the values become after the last attempt has failed; nothing: the failure is the result. Without gradients.
    std::optional<double> value_after_failure;
    bool may_follow_others = false;  ///< a folder that exists is left alone, the next free of 000001, 000001-2, … taken
    int parallel = 1;                ///< as Quantity::parallel, >= 1
    bool by_hand = false;            ///< never run: the folder is handed out and its answer awaited (`strake step`)
    /// Options of sbatch: each evaluation is a job of Slurm. The timeout counts from its start. Not with by_hand.
    std::optional<std::vector<std::string>> slurm;
    double queue_s = 7 * 86400.0;              ///< longest wait for the start of a job, > 0
    double poll_s = 2;                         ///< shortest time between two questions to the queue, > 0
    std::filesystem::path cache;               ///< as Quantity::cache
    std::vector<std::filesystem::path> files;  ///< whose contents the cache's answers depend on
};

/// A quantity that runs `command` once an evaluation, in the fresh folder evaluations_dir/NNNNNN (or a
/// folder of its own within; further attempts in NNNNNN-2, NNNNNN-3, …). Whatever the program
/// does wrong is the result's `failure` (kinds spawn, exit, signal, timeout, no_result, unreadable, missing_key,
/// wrong_type, not_finite, wrong_count; of jobs also submit, never_starts, vanished; by hand also reported), whose
/// message ends with the program's last lines. `evaluate` may be called from several threads, each of which must live
/// as long as its program runs: that gets TERM when the thread ends.
/// @throws InvalidInput for wrong options; `evaluate` throws Interrupted when the request's stop is wanted, Awaited
/// where the answer of a folder that was handed out is not there, OutputError when the folder exists or cannot be
/// written, InvalidInput for an evaluation number < 0 or a variable that is not finite.
Quantity external(const ExternalCommand& command);

/// Why the command's program cannot be started (kind spawn), before anything runs; nothing when it can.
std::optional<Failure> check_program(const ExternalCommand& command);

}  // namespace strake
