#pragma once
#include "objectives/external/command.hpp"
#include "objectives/quantity/quantity.hpp"

#include <array>

/// One attempt to evaluate with a program: its folder, request and results. Internal.
namespace strake {

/// Placeholders in arguments.
inline constexpr std::array<const char*, 5> replaced_words{"surface", "request", "result", "folder", "case_dir"};

/// `gradients`: by `gradient_command`, in the folder of the command's values.
enum class Wanted { values, values_and_gradients, gradients };

/// A task for a program.
struct Task {
    const ExternalCommand& command;
    const QuantityRequest& request;
    Wanted wanted = Wanted::values;
    std::filesystem::path folder_of_values = {};  ///< only for `gradients`
};

/// Place of one attempt: its own folder for values; its own files in the values' folder for gradients.
struct Call {
    Wanted wanted = Wanted::values;
    std::filesystem::path folder = {}, surface = {}, request = {}, result = {};
    std::string prefix = {};  ///< of other file names: "", "gradient-", "gradient-2-", …
    std::filesystem::path file(const std::string& name) const { return folder / (prefix + name); }
};

/// Places are numbered from 1: 000001, 000001-2, …; gradient.json, gradient-2.json, …
/// @throws InvalidInput: evaluation < 0.
Call place(const Task& task, int number);
/// Whether an attempt has used the place.
bool is_taken(const Task& task, const Call& call);
/// Claims an unused place; false if used. @throws OutputError.
bool take_place(const Task& task, const Call& call);
/// The first unused place from `number` on. Places are never reused: late output of an earlier attempt must not count
/// as a result. @throws OutputError.
Call fresh_place(const Task& task, int number);

/// Bytes of the request.
std::string request_text(const Task& task, const Call& call);
/// Writes surface and points (not for `gradients`), then the request.
/// @throws OutputError; InvalidInput: a variable that is not finite.
void hand_over(const Task& task, const Call& call);
/// Records the surface for `is_of`, in places that a later start may return to. @throws OutputError.
void sign(const Task& task, const Call& call);
/// Whether the place was prepared and signed for exactly this task, in this or an earlier start.
bool is_of(const Task& task, const Call& call);
/// The last folder with the command's values for this request; empty: none.
std::filesystem::path find_folder_of_values(const ExternalCommand& command, const QuantityRequest& request);

/// Argument list with placeholders replaced. A program path with '/' is relative to the case file.
std::vector<std::string> arguments_of(const ExternalCommand& command, const Call& call);
double timeout_of(const ExternalCommand& command, const Call& call);  ///< s
/// A shell line that runs exactly these arguments in the call's folder, with its logs.
std::string shell_line(const ExternalCommand& command, const Call& call);

/// Result and gradients. @throws Refused.
QuantityResult read_results(const Task& task, const Call& call);

/// The failure of an attempt with its place and the program's last lines (may be empty).
QuantityResult failed(const Task& task, const Call& call, Failure failure, const std::string& last_lines);

std::vector<std::string> value_keys(const ExternalCommand& command);
/// The first line of a failure's message; the others name its folder and its log.
std::string headline(const Failure& failure);

/// The program's last lines from its logs, printable: of stderr.log, or of stdout.log if that is empty.
std::string last_lines_in(const Call& call);

}  // namespace strake
