#pragma once
#include <filesystem>
#include <string>
#include <string_view>

/// Files as bytes, of any format.
namespace strake {

/// The bytes of a regular file. Devices, directories and pipes are refused at once, without blocking.
/// @throws InputError `FILE: the system's reason`.
std::string read_bytes(const std::filesystem::path& file);

/// Writes a file: readers see the old one or the whole new one. @throws OutputError.
void write_atomically(const std::filesystem::path& file, const std::string& bytes);

/// A name or an excerpt of a file as it may appear in a message: control characters and bytes that are not UTF-8
/// as `\xNN`, cut after `limit` bytes.
std::string printable(std::string_view bytes, std::size_t limit = 1000);

}  // namespace strake
