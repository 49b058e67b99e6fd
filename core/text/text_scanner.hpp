#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace strake {

/// Words and numbers of a text, with their line. Line ends may be LF, CRLF or CR. Numbers do not
/// depend on the locale and must fill their word: "1,5", "1.0.0", "1e400", "nan" are refused.
class TextScanner {
public:
    struct Syntax {
        char comment = '\0';        ///< starts a comment that runs to the end of the line
        bool continuation = false;  ///< a backslash at the end of a line joins the next one
        bool fortran = false;       ///< exponents may be written with D
    };
    /// `name` is the file as messages show it; `text` outlives the scanner.
    TextScanner(std::string_view text, std::string name, Syntax syntax, long first_line = 1);

    bool next_line();             ///< to the next line that holds a word; false at the end
    std::string_view word();      ///< the next word of this line; empty at its end
    std::string_view any_word();  ///< the next word on this or a later line; empty at the end of the text
    std::string_view rest();      ///< the rest of this line, without surrounding blanks
    /// The whole current line, including leading blanks, words already read, and comments.
    std::string_view whole_line() const { return text_.substr(line_begin_, line_end_ - line_begin_); }
    std::size_t bytes_left() const { return text_.size() - position_; }
    long line() const { return line_; }

    /// `word` as a finite number; `what` names it in the message ("x of vertex 12").
    double number(std::string_view word, std::string_view what) const;
    double number_or_nan(std::string_view word, std::string_view what) const;  ///< for unused values
    std::int64_t integer(std::string_view word, std::string_view what) const;
    /// @throws InputError `FILE:LINE: what`.
    [[noreturn]] void fail(const std::string& what) const { fail_at(line_, what); }
    [[noreturn]] void fail_at(long line, const std::string& what) const;
    /// Refuses a missing or unexpected word: `expected WHAT, got 'word'`.
    [[noreturn]] void unexpected(std::string_view word, std::string_view what) const;
    /// Refuses a count that the rest of the text has no room for, before anything is allocated.
    void check_room(std::int64_t count, std::size_t bytes_each, std::string_view what) const;

private:
    bool enter_line();  ///< makes the line at `position_` the current one
    std::string_view text_;
    std::string name_;
    Syntax syntax_;
    std::size_t position_ = 0, line_begin_ = 0, line_end_ = 0, next_begin_ = 0;
    long line_;
    bool joined_ = false;  ///< the current line continues in the next
};

}  // namespace strake
