#pragma once

namespace strake {

/// Kills all programs that run now, with their process groups: for a signal handler that ends this program at once.
void kill_programs();

}  // namespace strake
