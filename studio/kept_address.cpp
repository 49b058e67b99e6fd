#include "studio/kept_address.hpp"

#include "core/text/hash.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <ctime>

namespace strake {
namespace {

namespace fs = std::filesystem;

fs::path file_of(const fs::path& folder) {
    const char* cache = std::getenv("XDG_CACHE_HOME");
    const char* home = std::getenv("HOME");
    fs::path base;
    if (cache != nullptr && *cache == '/')
        base = cache;
    else if (home != nullptr && *home == '/')
        base = fs::path(home) / ".cache";
    if (base.empty()) return {};
    return base / "strake" / ("studio-" + hash_digits(fnv1a(folder.string())));
}

}  // namespace

KeptAddress kept_address(const fs::path& folder) {
    const fs::path file = file_of(folder);
    if (file.empty()) return {};
    const int handle = ::open(file.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
    if (handle < 0) return {};
    struct stat facts {};
    std::array<char, 64> bytes{};
    const bool is_known = ::fstat(handle, &facts) == 0;
    const ssize_t count = ::read(handle, bytes.data(), bytes.size());
    ::close(handle);
    constexpr std::size_t digits = 32;
    constexpr std::time_t day = 86400;
    const bool is_ours =
        is_known && S_ISREG(facts.st_mode) && facts.st_uid == ::geteuid() && (facts.st_mode & 077) == 0;
    if (!is_ours || facts.st_mtime + day < std::time(nullptr) || count <= static_cast<ssize_t>(digits)) return {};
    KeptAddress found{{bytes.data(), digits}, 0};
    const auto is_digit = [](unsigned char c) { return std::isdigit(c) || (c >= 'a' && c <= 'f'); };
    const bool is_token = std::all_of(found.token.begin(), found.token.end(), is_digit);
    const char* end = bytes.data() + count;
    std::from_chars(bytes.data() + digits + 1, end, found.port);
    if (!is_token || found.port < 1024 || found.port > 65535) return {};
    return found;
}

void keep_address(const fs::path& folder, const KeptAddress& address) {
    const fs::path file = file_of(folder);
    if (file.empty()) return;
    std::error_code ignored;
    fs::create_directories(file.parent_path(), ignored);
    ::unlink(file.c_str());
    const int handle = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (handle < 0) return;
    const std::string bytes = address.token + " " + std::to_string(address.port) + "\n";
    if (::write(handle, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) ::unlink(file.c_str());
    ::close(handle);
}

}  // namespace strake
