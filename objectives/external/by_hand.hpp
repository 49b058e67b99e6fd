#pragma once
#include "objectives/external/attempt.hpp"

/// A program that somebody else runs (`strake step`). Internal.
namespace strake {

/// Looks for the answer to attempt `number` at the task. Its place is made where there is none yet: with surface,
/// request, `command.sh`, which runs the command as Strake would, and `awaited`. It is answered once the result, or the
/// file `failed` with some words, is there, and no file `running` (with the call's prefix before these names).
/// @throws Awaited while it is not; OutputError.
QuantityResult attempt_by_hand(const Task& task, int number);

}  // namespace strake
