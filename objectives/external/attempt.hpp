#pragma once
#include "objectives/external/external.hpp"

#include <array>

/// One attempt of a program at an evaluation: its folder, what is written there, and what is read back. Internal.
namespace strake {

/// The words that are replaced in arguments.
inline constexpr std::array<const char*, 5> replaced_words{"surface", "request", "result", "folder", "case_dir"};

struct Call {
    std::filesystem::path folder, surface, request, result;
};

/// The folder of the first attempt at the evaluation, and that of a further one. @throws InvalidInput: evaluation < 0.
std::filesystem::path first_folder(const ExternalCommand& command, int evaluation);
std::filesystem::path attempt_folder(const std::filesystem::path& first, int attempt);
Call call_in(const ExternalCommand& command, const std::filesystem::path& folder);

/// An attempt never gets a folder that another has had: what that one still writes must not be taken for its result.
/// @throws OutputError.
Call fresh_call(const ExternalCommand& command, int evaluation, int attempt);
/// Makes the folder; false where there is one. @throws OutputError.
bool make_call_folder(const std::filesystem::path& folder);

/// Writes the surface, then the request. @throws OutputError; InvalidInput: a variable that is not finite.
void hand_over(const ExternalCommand& command, const QuantityRequest& request, const Call& call, bool want_gradients);

/// Writes down which request it is, for `is_of`. For folders to which a later start may come back. @throws OutputError.
void sign(const QuantityRequest& request, const Call& call);
/// The folder was handed over for exactly this request, in this or an earlier start.
bool is_of(const ExternalCommand& command, const QuantityRequest& request, const Call& call, bool want_gradients);

/// Argument list with the words in braces replaced. A program path with '/' is relative to the case file.
std::vector<std::string> arguments_of(const ExternalCommand& command, const Call& call);
/// A line for a shell that runs exactly these arguments.
std::string shell_words(const std::vector<std::string>& arguments);
std::string shell_words(const std::string& argument);

/// result.json and the gradients. @throws Refused.
QuantityResult read_results(const ExternalCommand& command, const QuantityRequest& request, const Call& call,
                            bool want_gradients);

/// The failure of an attempt, in words: which, where, and the program's last lines (may be empty).
QuantityResult failed(const ExternalCommand& command, const QuantityRequest& request, const Call& call, Failure failure,
                      const std::string& last_lines);

std::vector<std::string> value_keys(const ExternalCommand& command);

/// The program's last lines from the logs in its folder, printable: of stderr.log, or of stdout.log where that is
/// empty.
std::string last_lines_in(const std::filesystem::path& folder);

}  // namespace strake
