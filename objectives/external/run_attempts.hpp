#pragma once
#include "objectives/external/job.hpp"

/// Runs a command with retries: as a process, by hand or as a job. Internal.
namespace strake {

/// Up to 1 + retries attempts until one succeeds, with pauses; failed ones become log messages.
/// @param queue of the command's jobs; null: it has none. @throws like `external`.
QuantityResult run_attempts(const Task& task, SlurmQueue* queue);

/// Gradients by `gradient_command`, in the folder of this request's values; if that is gone, the command runs again.
QuantityResult gradients_of(const ExternalCommand& command, SlurmQueue* queue, const QuantityRequest& request);

}  // namespace strake
