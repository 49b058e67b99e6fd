#pragma once
#include "objectives/external/job.hpp"

/// How a command is run: in which way, and how often. Internal.
namespace strake {

/// Attempts up to 1 + retries until one succeeds, with pauses; the failed ones become remarks.
/// @param queue of the command's jobs; null where it has none. @throws as `external`.
QuantityResult run_attempts(const Task& task, SlurmQueue* queue);

/// Gradients by `gradient_command`, in the folder in which the command gave the values of this request; where there is
/// none any more, the command runs once more.
QuantityResult gradients_of(const ExternalCommand& command, SlurmQueue* queue, const QuantityRequest& request);

}  // namespace strake
