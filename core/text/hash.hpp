#pragma once
#include <cstdint>
#include <string>
#include <string_view>

/// FNV-1a, 64 bits: tells contents apart; no protection against forgery.
namespace strake {

inline constexpr std::uint64_t fnv1a_start = 0xcbf29ce484222325ull;

/// @param start the hash of the bytes before, to hash several pieces as one
std::uint64_t fnv1a(std::string_view bytes, std::uint64_t start = fnv1a_start);
std::string hash_digits(std::uint64_t hash);  ///< 16 hexadecimal digits

}  // namespace strake
