#pragma once
#include <filesystem>
#include <string>

namespace strake {

/// Empty, or what is missing of an ELF file (a shared library) by the sizes that its own header states: loading a
/// file that is cut short ends the program with SIGBUS. Empty also for what is no ELF file of 64 bits.
std::string cut_short(const std::filesystem::path& library);

}  // namespace strake
