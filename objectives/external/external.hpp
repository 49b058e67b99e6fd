#pragma once
#include "objectives/external/command.hpp"
#include "objectives/quantity/quantity.hpp"

/// External programs (docs/external.md).
namespace strake {

/// A quantity that runs `command` once per evaluation, in the new folder evaluations_dir/NNNNNN (or its own folder
/// within; further attempts in NNNNNN-2, NNNNNN-3, …). Any error of the program becomes the result's `failure` (kinds
/// spawn, exit, signal, timeout, no_result, unreadable, missing_key, wrong_type, not_finite, wrong_count; of jobs also
/// submit, never_starts, vanished; by hand also reported), whose message ends with the program's last lines. `evaluate`
/// may be called from several threads; each must outlive its program, which gets TERM when the thread ends.
/// @throws InvalidInput for wrong options; `evaluate` throws Interrupted when the request is stopped, Awaited while the
/// answer of a prepared folder is pending, OutputError when the folder exists or cannot be written, InvalidInput for an
/// evaluation number < 0 or a variable that is not finite.
Quantity external(const ExternalCommand& command);

/// Why the command's program cannot be started (kind spawn), checked before anything runs; empty if it can.
std::optional<Failure> check_program(const ExternalCommand& command);

}  // namespace strake
