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

/// Writes the surface and the points, then the request. @throws OutputError; InvalidInput: a variable that is not
/// finite.
void hand_over(const ExternalCommand& command, const QuantityRequest& request, const Call& call, bool want_gradients);
/// The request alone.
void write_request(const ExternalCommand& command, const QuantityRequest& request, const Call& call,
                   bool want_gradients);

/// Argument list with the words in braces replaced. A program path with '/' is relative to the case file.
std::vector<std::string> arguments_of(const ExternalCommand& command, const Call& call);
std::vector<std::string> gradient_arguments_of(const ExternalCommand& command, const Call& call);

/// The result and the gradients. @param want_values false: after the gradient command. @throws Refused.
QuantityResult read_results(const ExternalCommand& command, const QuantityRequest& request, const Call& call,
                            bool want_gradients, bool want_values = true);

/// The failure of an attempt, in words: which, where, and the program's last lines (may be empty).
QuantityResult failed(const ExternalCommand& command, const QuantityRequest& request, const Call& call, Failure failure,
                      const std::string& last_lines);

std::vector<std::string> value_keys(const ExternalCommand& command);
/// The first line of a failure's message; the others name its folder and its log.
std::string headline(const Failure& failure);

/// `attempt(1)`, `attempt(2)`, … up to 1 + retries until one succeeds, with pauses; the failed ones become remarks.
QuantityResult with_retries(const ExternalCommand& command, const QuantityRequest& request,
                            const std::function<QuantityResult(int)>& attempt);

/// A process of our own: the command in a fresh folder.
QuantityResult attempt_as_process(const ExternalCommand& command, const QuantityRequest& request, int number,
                                  bool want_gradients);

/// Gradients by `gradient_command`, in the folder in which the command gave the values of this evaluation; where that
/// folder is gone, the command runs once more.
QuantityResult gradients_of(const ExternalCommand& command, const QuantityRequest& request);

}  // namespace strake
