#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

/// Output of programs: bounded in size and sanitized for display.
namespace strake {

/// A new file of at most `limit` bytes plus, after a line with the omitted size, the last 64 KiB. Memory is bounded
/// too.
class CappedLog {
public:
    CappedLog(const std::filesystem::path& file, std::size_t limit);  ///< @throws OutputError; the file must not exist
    ~CappedLog();
    CappedLog(const CappedLog&) = delete;
    CappedLog& operator=(const CappedLog&) = delete;

    void append(std::string_view bytes);      ///< never throws: an error is kept for close()
    void close();                             ///< @throws OutputError with the first error of all writes
    std::string last_lines(int count) const;  ///< printable, without empty lines

private:
    void write(std::string_view bytes);
    std::filesystem::path file_;
    std::size_t limit_, written_ = 0, seen_ = 0;
    int fd_ = -1, error_ = 0;
    std::string tail_;
};

/// The last `count` lines that are not blank, each indented and cut to 200 bytes; terminal escapes, control characters
/// and broken UTF-8 removed or shown as '?'.
std::string printable_tail(std::string_view bytes, int count);
std::string printable_line(std::string_view line);  ///< one line of that

}  // namespace strake
