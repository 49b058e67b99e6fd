#pragma once
#include <filesystem>
#include <string>

/// The address that the studio of a folder had last, so that a page that is open finds its way back after a restart.
namespace strake {

struct KeptAddress {
    std::string token;  ///< empty: none is kept
    int port = 0;
};

/// In the user's cache folder, readable by the user alone; none after a day without a studio there, or where the file
/// belongs to others.
KeptAddress kept_address(const std::filesystem::path& folder);
/// That it cannot be kept is no error.
void keep_address(const std::filesystem::path& folder, const KeptAddress& address);

}  // namespace strake
