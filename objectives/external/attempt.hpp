#pragma once
#include "objectives/external/external.hpp"

#include <array>

/// One attempt of a program at an evaluation: its place, what is written there, and what is read back. Internal.
namespace strake {

/// The words that are replaced in arguments.
inline constexpr std::array<const char*, 5> replaced_words{"surface", "request", "result", "folder", "case_dir"};

/// Gradients alone: of `gradient_command`, in the folder in which the command has given the values.
enum class Wanted { values, values_and_gradients, gradients };

/// What a program is asked.
struct Task {
    const ExternalCommand& command;
    const QuantityRequest& request;
    Wanted wanted = Wanted::values;
    std::filesystem::path folder_of_values = {};  ///< for gradients alone
};

/// Where one attempt takes place: for values a folder of its own, for gradients alone files of its own in theirs.
struct Call {
    Wanted wanted = Wanted::values;
    std::filesystem::path folder = {}, surface = {}, request = {}, result = {};
    std::string prefix = {};  ///< of the names of other files: "", "gradient-", "gradient-2-", …
    std::filesystem::path file(const std::string& name) const { return folder / (prefix + name); }
};

/// Places are numbered from 1: 000001, 000001-2, …; gradient.json, gradient-2.json, …
/// @throws InvalidInput: evaluation < 0.
Call place(const Task& task, int number);
/// An attempt has had the place.
bool is_taken(const Task& task, const Call& call);
/// Takes a place that nobody has had; false where somebody has. @throws OutputError.
bool take_place(const Task& task, const Call& call);
/// The first free place from `number` on. No attempt gets a place that another has had: what that one still writes must
/// not be taken for its result. @throws OutputError.
Call fresh_place(const Task& task, int number);

/// Bytes of the request.
std::string request_text(const Task& task, const Call& call);
/// Writes surface and points, except for gradients alone, then the request.
/// @throws OutputError; InvalidInput: a variable that is not finite.
void hand_over(const Task& task, const Call& call);
/// Writes down which surface it is, for `is_of`. For places to which a later start may come back. @throws OutputError.
void sign(const Task& task, const Call& call);
/// The place was handed over and signed for exactly this task, in this or an earlier start.
bool is_of(const Task& task, const Call& call);
/// The last folder in which the command has given the values that the request belongs to; empty: there is none.
std::filesystem::path find_folder_of_values(const ExternalCommand& command, const QuantityRequest& request);

/// Argument list with the words in braces replaced. A program path with '/' is relative to the case file.
std::vector<std::string> arguments_of(const ExternalCommand& command, const Call& call);
double timeout_of(const ExternalCommand& command, const Call& call);  ///< s
/// A line for a shell that runs exactly these arguments in the call's folder, with its logs.
std::string shell_line(const ExternalCommand& command, const Call& call);

/// Result and gradients. @throws Refused.
QuantityResult read_results(const Task& task, const Call& call);

/// The failure of an attempt, in words: which, where, and the program's last lines (may be empty).
QuantityResult failed(const Task& task, const Call& call, Failure failure, const std::string& last_lines);

std::vector<std::string> value_keys(const ExternalCommand& command);
/// The first line of a failure's message; the others name its folder and its log.
std::string headline(const Failure& failure);

/// The program's last lines from its logs, printable: of stderr.log, or of stdout.log where that is empty.
std::string last_lines_in(const Call& call);

}  // namespace strake
