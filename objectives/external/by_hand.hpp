#pragma once
#include "objectives/external/external.hpp"

/// A program that somebody else runs (`strake step`). Internal.
namespace strake {

/// Looks for the answer to attempt `number` at the evaluation. Its folder is made where there is none yet: with
/// surface, request, `command.sh`, which runs the command as Strake would, and `awaited`. It is answered once
/// `result.json`, or the file `failed` with some words, is there, and no file `running`.
/// @throws Awaited while it is not; OutputError.
QuantityResult attempt_by_hand(const ExternalCommand& command, const QuantityRequest& request, int number);

}  // namespace strake
