#include "core/text/text_scanner.hpp"

#include "core/error.hpp"
#include "core/text/file.hpp"

#include <charconv>
#include <cmath>
#include <limits>

namespace strake {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

enum class Parsed { good, malformed, too_large };

/// The whole word as a double. Underflow reads as zero, like in other languages.
Parsed parse(std::string_view word, double& value) {
    if (word.size() > 1 && word[0] == '+' && word[1] != '-' && word[1] != '+') word.remove_prefix(1);
    const char* end = word.data() + word.size();
    const auto [last, error] = std::from_chars(word.data(), end, value);
    if (last != end || error == std::errc::invalid_argument) return Parsed::malformed;
    if (error == std::errc::result_out_of_range) {
        const std::size_t e = word.find_first_of("eE");
        const bool tiny = e == word.npos ? word.find_first_not_of("-0.") > 2 : word.substr(e + 1).starts_with('-');
        if (!tiny) return Parsed::too_large;
        value = 0;
    }
    return Parsed::good;
}

}  // namespace

TextScanner::TextScanner(std::string_view text, std::string name, Syntax syntax, long first_line)
    : text_(text), name_(std::move(name)), syntax_(syntax), line_(first_line - 1) {}

bool TextScanner::enter_line() {
    position_ = line_begin_ = next_begin_;
    if (position_ >= text_.size()) {
        position_ = line_end_ = next_begin_ = text_.size();
        joined_ = false;
        return false;
    }
    ++line_;
    line_end_ = text_.find_first_of("\r\n", position_);
    if (line_end_ == text_.npos) line_end_ = text_.size();
    next_begin_ = line_end_ + 1;
    if (line_end_ + 1 < text_.size() && text_[line_end_] == '\r' && text_[line_end_ + 1] == '\n') ++next_begin_;
    joined_ = syntax_.continuation && line_end_ > position_ && text_[line_end_ - 1] == '\\';
    if (joined_) --line_end_;
    return true;
}

bool TextScanner::next_line() {
    while (joined_ && enter_line()) {
    }
    while (enter_line()) {
        while (position_ < line_end_ && is_blank(text_[position_])) ++position_;
        if (position_ < line_end_ && (text_[position_] != syntax_.comment || !syntax_.comment)) return true;
    }
    return false;
}

std::string_view TextScanner::word() {
    while (true) {
        while (position_ < line_end_ && is_blank(text_[position_])) ++position_;
        if (position_ < line_end_ && syntax_.comment && text_[position_] == syntax_.comment) {
            position_ = line_end_;
            joined_ = false;
        }
        if (position_ < line_end_) break;
        if (!joined_ || !enter_line()) return {};
    }
    const std::size_t begin = position_;
    while (position_ < line_end_ && !is_blank(text_[position_]) &&
           !(syntax_.comment && text_[position_] == syntax_.comment))
        ++position_;
    return text_.substr(begin, position_ - begin);
}

std::string_view TextScanner::any_word() {
    std::string_view w = word();
    while (w.empty() && next_line()) w = word();
    return w;
}

std::string_view TextScanner::rest() {
    while (position_ < line_end_ && is_blank(text_[position_])) ++position_;
    std::size_t end = line_end_;
    while (end > position_ && is_blank(text_[end - 1])) --end;
    const std::string_view r = text_.substr(position_, end - position_);
    position_ = line_end_;
    return r;
}

double TextScanner::number(std::string_view word, std::string_view what) const {
    const double value = number_or_nan(word, what);
    if (!std::isfinite(value)) fail(text(what, ": '", printable(word, 40), "' is not a finite number"));
    return value;
}

double TextScanner::number_or_nan(std::string_view word, std::string_view what) const {
    if (word.empty()) unexpected(word, what);
    double value = 0;
    Parsed parsed;
    const std::size_t d = syntax_.fortran ? word.find_first_of("dD") : word.npos;
    if (d == word.npos) {
        parsed = parse(word, value);
    } else {
        std::string with_e(word);
        with_e[d] = 'e';
        parsed = parse(with_e, value);
    }
    if (parsed == Parsed::too_large)
        fail(text(what, ": '", printable(word, 40), "' is outside the range of double precision (1.8e308)"));
    if (parsed == Parsed::malformed) {
        const bool comma = word.find(',') != word.npos;
        fail(text("expected a number (", what, "), got '", printable(word, 40), "'",
                  comma ? "; decimals are written with a point" : ""));
    }
    return value;
}

std::int64_t TextScanner::integer(std::string_view word, std::string_view what) const {
    if (word.empty()) unexpected(word, what);
    std::string_view digits = word;
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
    std::int64_t value = 0;
    const char* end = digits.data() + digits.size();
    const auto [last, error] = std::from_chars(digits.data(), end, value);
    if (last != end || error == std::errc::invalid_argument)
        fail(text("expected a whole number (", what, "), got '", printable(word, 40), "'"));
    if (error != std::errc()) fail(text(what, ": '", printable(word, 40), "' is too large"));
    return value;
}

void TextScanner::fail_at(long line, const std::string& what) const {
    throw InputError(text(name_, ":", std::max(line, 1L), ": ", what));
}

void TextScanner::unexpected(std::string_view word, std::string_view what) const {
    if (!word.empty()) fail(text("expected ", what, ", got '", printable(word, 40), "'"));
    const bool at_end = next_begin_ >= text_.size();
    fail(text("expected ", what, ", got ", at_end ? "the end of the file" : "the end of the line"));
}

void TextScanner::check_room(std::int64_t count, std::size_t bytes_each, std::string_view what) const {
    if (count < 0) fail(text(count, " ", what, ": a count cannot be negative"));
    if (count > std::numeric_limits<int>::max()) fail(text(count, " ", what, ": at most 2147483647 are possible"));
    const std::size_t room = (bytes_left() + 1) / bytes_each;  // the last line may lack its end
    if (static_cast<std::size_t>(count) > room)
        fail(text("the header announces ", count, " ", what, ", the ", bytes_left(),
                  " bytes that follow have room for at most ", room));
}

}  // namespace strake
