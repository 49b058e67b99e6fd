#pragma once
#include "objectives/external/attempt.hpp"

/// A program that somebody else runs (`strake step`). Internal.
namespace strake {

/// Returns the answer to attempt `number` of the task. Creates its place if necessary: surface, request, `command.sh`,
/// which runs the command like Strake, and `awaited`. The answer is complete when the result, or the file `failed` with
/// a message, exists and `running` does not (with the call's prefix before these names). @throws Awaited while pending;
/// OutputError.
QuantityResult attempt_by_hand(const Task& task, int number);

}  // namespace strake
