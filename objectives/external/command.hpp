#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// A quantity that a program of the user measures: how it is called, and what it answers with. `process.hpp` starts it.
namespace strake {

struct ProgramPoints;

struct ExternalCommand {
    std::string name;                  ///< of the quantity; values are named name.value, or name if `outputs` is empty
    std::vector<std::string> command;  ///< argument list, run without a shell; placeholders: {surface} {request}
                                       ///< {result} {folder} {case_dir}
    std::vector<std::string> outputs;  ///< names of the values; empty: one value
    double timeout_s = 3600;           ///< per evaluation, > 0; then TERM, grace, KILL to the process group
    /// Runs after `command` in the same folder when gradients are requested; `command` then returns values only.
    /// {request} is gradient_request.json; {result} is gradient.json, like result.json without values. Empty: `command`
    /// returns both.
    std::vector<std::string> gradient_command = {};
    std::optional<double> gradient_timeout_s = {};  ///< > 0; default: timeout_s
    /// The program's own points: it receives their moved positions, and its gradients refer to them. Null: the
    /// vertices.
    std::shared_ptr<const ProgramPoints> points = {};
    double grace_s = 5;  ///< >= 0
    std::string format;  ///< of the surface file: as in `format_named`, or su2-positions (`handed_over_bytes`)
    std::filesystem::path case_dir;         ///< program paths containing '/' are relative to it
    std::filesystem::path evaluations_dir;  ///< new folders 000001, 000002, … are created here
    bool own_folder = false;                ///< run in 000001/NAME, when several programs share evaluations_dir
    bool has_gradients = true;              ///< false: never asked for sensitivities
    /// Parameters that the values depend on; derivatives by others are 0. Default: all.
    std::optional<std::vector<std::string>> depends_on;
    bool may_lack_derivatives = false;  ///< by parameters: NaN if missing; false: a missing one is a failure
    double diagonal = 0;   ///< of the start surface; rows with coordinates are matched within 1e-5 of it, > 0
    std::string units;     ///< of length in the case, for request.json
    int retries = 0;       ///< further attempts after a failure, >= 0; none if the program cannot be started
    double pause_s = 0.1;  ///< before the first retry, doubled before each next one (at most 10 s), >= 0
    /// Substitute value after the last failed attempt; empty: the failure is the result. Without gradients.
    std::optional<double> value_after_failure;
    bool may_follow_others = false;  ///< skip existing folders and take the next free one of 000001, 000001-2, …
    int parallel = 1;                ///< like Quantity::parallel, >= 1
    bool by_hand = false;            ///< never run: prepare the folder and wait for its answer (`strake step`)
    /// Options of sbatch: each evaluation is a job of Slurm. The timeout counts from its start. Not with by_hand.
    std::optional<std::vector<std::string>> slurm;
    double queue_s = 7 * 86400.0;              ///< maximum wait for the start of a job, > 0
    double poll_s = 2;                         ///< minimum time between two queries of the queue, > 0
    std::filesystem::path cache;               ///< like Quantity::cache
    std::vector<std::filesystem::path> files;  ///< the cache's answers depend on their contents
};

}  // namespace strake
