#include "core/volume/foam_file.hpp"

#include "core/error.hpp"
#include "core/formats/formats.hpp"
#include "core/text/file.hpp"
#include "core/text/raw_number.hpp"

#include <charconv>
#include <cmath>
#include <limits>

namespace strake::foam {
namespace {

constexpr std::string_view blanks = " \t\r\n\v\f", marks = "(){};";
constexpr std::int64_t max_alike = 10'000'000;  // of entries that are all the same and take no room: 6{0}

}  // namespace

File::File(std::string_view bytes, std::string name) : bytes_(bytes), name_(std::move(name)) { read_header(); }

void File::fail(const std::string& what) const { throw InputError(text(name_, ": byte ", at_, ": ", what)); }

void File::skip_blanks() {
    while (true) {
        at_ = std::min(bytes_.find_first_not_of(blanks, at_), bytes_.size());
        const std::string_view rest = bytes_.substr(at_);
        const char* end = rest.starts_with("//") ? "\n" : rest.starts_with("/*") ? "*/" : nullptr;
        if (!end) return;
        const std::size_t found = bytes_.find(end, at_ + 2);
        if (found == bytes_.npos && *end == '*') fail("a comment without its end");
        at_ = found == bytes_.npos ? bytes_.size() : found + std::string_view(end).size();
    }
}

std::string_view File::token() {
    skip_blanks();
    if (at_ >= bytes_.size()) return {};
    std::size_t end = at_ + 1;
    if (bytes_[at_] == '"') {
        end = bytes_.find('"', end);
        if (end == bytes_.npos) fail("a string without its end");
        ++end;
    } else if (marks.find(bytes_[at_]) == marks.npos) {
        while (end < bytes_.size() && blanks.find(bytes_[end]) == blanks.npos && marks.find(bytes_[end]) == marks.npos)
            ++end;
    }
    const std::string_view found = bytes_.substr(at_, end - at_);
    at_ = end;
    return found;
}

bool File::meets(char mark) {
    skip_blanks();
    if (at_ >= bytes_.size() || bytes_[at_] != mark) return false;
    ++at_;
    return true;
}

void File::expect(char mark) {
    if (!meets(mark)) {
        const std::size_t end = std::min(bytes_.find_first_of(blanks, at_), bytes_.size());
        fail(text("expected '", mark, "', got '", printable(bytes_.substr(at_, end - at_), 60), "'"));
    }
}

void File::read_header() {
    if (token() != "FoamFile") fail("no OpenFOAM file: it does not begin with FoamFile");
    expect('{');
    std::string format, architecture;
    for (std::string_view key = token(); key != "}"; key = token()) {
        if (key.empty()) fail("a header without its end");
        std::string value;
        for (std::string_view word = token(); word != ";"; word = token()) {
            if (word.empty() || word == "}") fail("a line of the header without its ';'");
            value += word;
        }
        if (key == "format") format = value;
        if (key == "class") class_ = value;
        if (key == "arch") architecture = value;
    }
    if (format != "ascii" && format != "binary")
        fail(text("format '", printable(format, 60), "', must be ascii or binary"));
    is_binary_ = format == "binary";
    if (architecture.find("MSB") != architecture.npos && is_binary_)
        fail("big-endian binary; convert it by foamFormatConvert on such a machine");
    if (architecture.find("label=64") != architecture.npos) label_bytes_ = 8;
    if (architecture.find("scalar=32") != architecture.npos) scalar_bytes_ = 4;
}

std::int64_t File::integer(const char* what) {
    skip_blanks();
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(bytes_.data() + at_, bytes_.data() + bytes_.size(), value);
    if (error != std::errc()) {
        const std::size_t stop = std::min(bytes_.find_first_of(blanks, at_), bytes_.size());
        fail(text("expected ", what, ", got '", printable(bytes_.substr(at_, stop - at_), 60), "'"));
    }
    at_ = static_cast<std::size_t>(end - bytes_.data());
    return value;
}

int File::count(std::size_t bytes_each) {
    const std::int64_t n = integer("the length of a list");
    skip_blanks();
    if (n >= 0 && n <= max_alike && bytes_.substr(at_).starts_with('{')) return static_cast<int>(n);
    const auto room = static_cast<std::int64_t>((bytes_.size() - at_) / bytes_each);
    if (n < 0 || n > room || n > std::numeric_limits<int>::max() / 3)
        fail(text("a list of ", n, " entries; the rest of the file has room for ", room));
    return static_cast<int>(n);
}

double File::scalar(int point) {
    double value = 0;
    if (is_binary_) {
        if (bytes_.size() - at_ < static_cast<std::size_t>(scalar_bytes_)) fail("the list ends too early");
        value = scalar_bytes_ == 8 ? raw_number<double>(bytes_.data() + at_, false)
                                   : raw_number<float>(bytes_.data() + at_, false);
        at_ += static_cast<std::size_t>(scalar_bytes_);
    } else {
        skip_blanks();
        const auto [end, error] = std::from_chars(bytes_.data() + at_, bytes_.data() + bytes_.size(), value);
        if (error == std::errc::invalid_argument) fail(text("coordinate of point ", point, " is not a number"));
        at_ = static_cast<std::size_t>(end - bytes_.data());
    }
    if (!std::isfinite(value)) fail(text("point ", point, " is not finite"));
    return value;
}

std::vector<double> File::vectors(ListPlace& place) {
    const int n = count(is_binary_ ? 3 * static_cast<std::size_t>(scalar_bytes_) : 7);
    std::vector<double> out;
    out.reserve(3 * static_cast<std::size_t>(n));
    expect('(');
    place = {at_, at_, is_binary_, scalar_bytes_};
    for (int i = 0; i < n; ++i) {
        if (!is_binary_) expect('(');
        for (int k = 0; k < 3; ++k) out.push_back(scalar(i));
        if (!is_binary_) expect(')');
    }
    if (!is_binary_) skip_blanks();
    place.end = at_;
    expect(')');
    return out;
}

std::vector<int> File::binary_labels(int n) {
    std::vector<int> out(static_cast<std::size_t>(n));
    for (int& value : out) {
        const std::int64_t label = label_bytes_ == 4 ? raw_number<std::int32_t>(bytes_.data() + at_, false)
                                                     : raw_number<std::int64_t>(bytes_.data() + at_, false);
        if (label < -1 || label > std::numeric_limits<int>::max()) fail(text("label ", label, " is out of range"));
        value = static_cast<int>(label);
        at_ += static_cast<std::size_t>(label_bytes_);
    }
    return out;
}

std::vector<int> File::labels() {
    const int n = count(is_binary_ ? static_cast<std::size_t>(label_bytes_) : 1);
    std::vector<int> out;
    if (meets('{')) {  // all the same
        out.assign(static_cast<std::size_t>(n), static_cast<int>(integer("a label")));
        expect('}');
        return out;
    }
    expect('(');
    if (is_binary_) {
        if (bytes_.size() - at_ < static_cast<std::size_t>(n) * static_cast<std::size_t>(label_bytes_))
            fail("the list ends too early");
        out = binary_labels(n);
    } else {
        out.reserve(static_cast<std::size_t>(n));
        for (int i = 0; i < n; ++i) {
            const std::int64_t label = integer("a label");
            if (label < -1 || label > std::numeric_limits<int>::max()) fail(text("label ", label, " is out of range"));
            out.push_back(static_cast<int>(label));
        }
    }
    expect(')');
    return out;
}

void File::label_lists(std::vector<int>& first, std::vector<int>& entries) {
    if (is_binary_) fail(text("class ", printable(class_, 60), " in binary, expected faceCompactList"));
    const int n = count(3);
    first.assign(1, 0);
    expect('(');
    for (int i = 0; i < n; ++i) {
        const std::vector<int> one = labels();
        entries.insert(entries.end(), one.begin(), one.end());
        first.push_back(static_cast<int>(entries.size()));
    }
    expect(')');
}

std::string with_vectors(std::string_view bytes, const ListPlace& place, const double* points, int count) {
    std::string out(bytes.substr(0, place.begin));
    out.reserve(bytes.size() + 16 * static_cast<std::size_t>(count));
    if (!place.is_binary) out += '\n';
    for (int i = 0; i < count; ++i) {
        const double* row = points + 3 * static_cast<std::ptrdiff_t>(i);
        if (!place.is_binary) {
            formats::append_row(out, "(", row);
            out.back() = ')';
            out += '\n';
            continue;
        }
        for (int k = 0; k < 3; ++k) {
            const auto single = static_cast<float>(row[k]);
            if (place.scalar_bytes == 8)
                out.append(reinterpret_cast<const char*>(row + k), 8);
            else
                out.append(reinterpret_cast<const char*>(&single), 4);
        }
    }
    return out.append(bytes.substr(place.end));
}

}  // namespace strake::foam
