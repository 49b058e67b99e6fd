#include "objectives/external/handed_over.hpp"

#include "core/error.hpp"
#include "core/text/edit_distance.hpp"
#include "objectives/external/log.hpp"
#include "objectives/external/refused.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <vector>

namespace strake {
namespace {

[[noreturn]] void refuse(const char* kind, const std::string& message) { throw Refused{{kind, message}}; }

/// @throws Refused unless folder/name stays in the folder after every link but the last has been followed.
void require_inside(const std::filesystem::path& folder, const std::string& name) {
    const std::filesystem::path file(name);
    const bool climbs = std::any_of(file.begin(), file.end(), [](const auto& part) { return part == ".."; });
    if (file.is_absolute() || climbs)
        refuse("unreadable", text("file name '", printable_line(name), "' must be relative to the evaluation's folder",
                                  " and stay in it"));
    std::error_code error;
    const auto home = std::filesystem::canonical(folder, error);
    if (error) refuse("no_result", text("the evaluation's folder is gone: ", error.message()));
    const auto parent = std::filesystem::canonical((folder / file).parent_path(), error);
    if (error) refuse("no_result", text("'", printable_line(name), "' was not written"));
    if (std::mismatch(home.begin(), home.end(), parent.begin(), parent.end()).first != home.end())
        refuse("unreadable", text("'", printable_line(name), "' leads out of the evaluation's folder"));
}

const char* kind_of_file(mode_t mode) {
    return S_ISDIR(mode) ? "a directory" : S_ISFIFO(mode) ? "a FIFO" : S_ISSOCK(mode) ? "a socket" : "a device";
}

std::string read_all(int fd, const std::string& name, std::size_t size) {
    std::string bytes(size, '\0');
    std::size_t have = 0;
    while (have < size) {
        const ssize_t n = ::read(fd, bytes.data() + have, size - have);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) refuse("unreadable", text("'", name, "': ", std::strerror(errno)));
        if (n == 0) break;
        have += static_cast<std::size_t>(n);
    }
    bytes.resize(have);
    return bytes;
}

}  // namespace

void require_text(const std::string& bytes, const std::string& name) {
    if (bytes.find('\0') != std::string::npos || bytes.rfind("\xFF\xFE", 0) == 0 || bytes.rfind("\xFE\xFF", 0) == 0)
        refuse("unreadable", text("'", printable_line(name), "' is not text (binary, or UTF-16?); write UTF-8"));
}

std::string read_handed_over(const std::filesystem::path& folder, const std::string& name, std::size_t limit,
                             bool may_be_binary) {
    require_inside(folder, name);
    const std::string shown = printable_line(name);
    // O_NONBLOCK: opening a FIFO must not wait for its writer.
    const int fd = ::open((folder / name).c_str(), O_RDONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC);
    if (fd < 0 && errno == ENOENT)
        refuse("no_result", text("'", shown, "' was not written",
                                 name.ends_with(".json") ? ": the program ended without writing to {result}"
                                                         : "; result.json names it"));
    if (fd < 0 && errno == ELOOP) refuse("unreadable", text("'", shown, "' is a link, must be a file of its own"));
    if (fd < 0) refuse("unreadable", text("'", shown, "': ", std::strerror(errno)));
    struct Closer {
        int fd;
        ~Closer() { ::close(fd); }
    } closer{fd};
    struct stat info {};
    if (::fstat(fd, &info) != 0) refuse("unreadable", text("'", shown, "': ", std::strerror(errno)));
    if (!S_ISREG(info.st_mode))
        refuse("unreadable", text("'", shown, "' is ", kind_of_file(info.st_mode), ", must be a regular file"));
    if (info.st_uid != ::geteuid() && info.st_uid != 0)  // root: what a container leaves
        refuse("unreadable", text("'", shown, "' belongs to user ", info.st_uid, ", not to us"));
    const auto size = static_cast<std::uintmax_t>(info.st_size);
    if (size > limit) refuse("unreadable", text("'", shown, "' has ", size, " bytes, the limit is ", limit));
    std::string bytes = read_all(fd, shown, static_cast<std::size_t>(size));
    if (bytes.rfind("\xEF\xBB\xBF", 0) == 0) bytes.erase(0, 3);
    if (!may_be_binary) require_text(bytes, name);
    return bytes;
}

NumberIs parse_number(std::string_view text, double& value) {
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
    // Most numbers are plain; only others are copied.
    if (const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        error == std::errc() && end == text.data() + text.size())
        return std::isfinite(value) ? NumberIs::finite : NumberIs::not_finite;
    std::string number(text);
    for (char& c : number)
        if (c == 'd' || c == 'D') c = 'e';
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
    if (error == std::errc::invalid_argument || end != number.data() + number.size()) return NumberIs::not_a_number;
    if (error == std::errc::result_out_of_range) {
        // Underflow reads as zero; from_chars reports it like overflow, so check the exponent's sign.
        value = 0;
        return number.find("e-") != std::string::npos || number.find("E-") != std::string::npos ? NumberIs::finite
                                                                                                : NumberIs::not_finite;
    }
    return std::isfinite(value) ? NumberIs::finite : NumberIs::not_finite;
}

bool similar(const std::string& wanted, const std::string& candidate) {
    if (wanted.size() > 64 || candidate.size() > 64) return false;
    const auto distance = static_cast<std::size_t>(edit_distance(wanted, candidate));
    return distance <= std::max<std::size_t>(2, wanted.size() / 3) && distance < wanted.size();
}

}  // namespace strake
