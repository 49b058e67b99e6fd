#include "objectives/external/log.hpp"

#include "core/error.hpp"
#include "core/text/utf8.hpp"

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

namespace strake {
namespace {

constexpr std::size_t tail_bytes = 64 * 1024;
constexpr std::size_t line_bytes = 200;

/// Length of the terminal escape that starts at bytes[i] (an ESC): CSI … letter, OSC … BEL, or two bytes.
std::size_t escape_length(std::string_view bytes, std::size_t i) {
    if (i + 1 >= bytes.size()) return 1;
    std::size_t end = i + 2;
    if (bytes[i + 1] == '[')
        while (end < bytes.size() && !(bytes[end] >= '@' && bytes[end] <= '~')) ++end;
    else if (bytes[i + 1] == ']')
        while (end < bytes.size() && bytes[end] != '\a' && bytes[end] != '\x1b') ++end;
    else
        return 2;
    return std::min(end + 1, bytes.size()) - i;
}

/// Length of the character at bytes[i]; 0 for what is not UTF-8, controls, and characters that reorder text.
std::size_t character_length(std::string_view bytes, std::size_t i) {
    const auto [length, code] = utf8_at(bytes, i);
    const bool reorders =
        (code >= 0x200e && code <= 0x200f) || (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
    return reorders || is_control(code) ? 0 : length;
}

}  // namespace

std::string printable_line(std::string_view line) {
    std::string shown;
    for (std::size_t i = 0; i < line.size() && shown.size() < line_bytes;) {
        if (line[i] == '\x1b') {
            i += escape_length(line, i);
        } else if (line[i] == '\t') {
            shown += "    ";
            ++i;
        } else if (const std::size_t length = character_length(line, i); length > 0) {
            shown += line.substr(i, length);
            i += length;
        } else {
            shown += '?';
            ++i;
        }
    }
    return shown.size() < line_bytes ? shown : shown + " ...";
}

std::string printable_tail(std::string_view bytes, int count) {
    std::vector<std::string> lines;
    while (!bytes.empty() && static_cast<int>(lines.size()) < count) {
        const std::size_t at = bytes.find_last_of("\n\r");
        const std::string_view line = at == std::string_view::npos ? bytes : bytes.substr(at + 1);
        std::string shown = printable_line(line);
        if (shown.find_first_not_of(' ') != std::string::npos) lines.push_back("    " + shown);
        bytes = at == std::string_view::npos ? std::string_view() : bytes.substr(0, at);
    }
    std::string joined;
    for (auto line = lines.rbegin(); line != lines.rend(); ++line) joined += (joined.empty() ? "" : "\n") + *line;
    return joined;
}

CappedLog::CappedLog(const std::filesystem::path& file, std::size_t limit) : file_(file), limit_(limit) {
    const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (fd < 0) throw OutputError(text(file.string(), ": cannot be created: ", std::strerror(errno)));
    fd_ = fd;
}

CappedLog::~CappedLog() {
    if (fd_ >= 0) ::close(fd_);
}

void CappedLog::write(std::string_view bytes) {
    while (!bytes.empty() && error_ == 0) {
        const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) continue;
        if (n < 0)
            error_ = errno;
        else
            bytes.remove_prefix(static_cast<std::size_t>(n));
    }
}

void CappedLog::append(std::string_view bytes) {
    seen_ += bytes.size();
    const std::size_t room = std::min(bytes.size(), limit_ - written_);
    write(bytes.substr(0, room));
    written_ += room;
    tail_ += bytes;
    if (tail_.size() > 2 * tail_bytes) tail_.erase(0, tail_.size() - tail_bytes);
}

void CappedLog::close() {
    if (fd_ < 0) return;
    if (seen_ > written_) {
        const std::size_t kept = std::min({seen_ - written_, tail_.size(), tail_bytes});
        write(text("\n[strake: ", seen_ - written_ - kept, " bytes omitted]\n"));
        write(std::string_view(tail_).substr(tail_.size() - kept));
    }
    if (::close(fd_) != 0 && error_ == 0) error_ = errno;
    fd_ = -1;
    if (error_ != 0) throw OutputError(text(file_.string(), ": cannot be written: ", std::strerror(error_)));
}

std::string CappedLog::last_lines(int count) const { return printable_tail(tail_, count); }

}  // namespace strake
