#include "casefile/yaml/value.hpp"

#include "core/text/utf8.hpp"
#include "core/text/windows_path.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <sstream>

namespace strake {
namespace {

[[noreturn]] void fail(const std::string& file, const std::vector<std::string>& lines, const Place& place,
                       const std::string& message) {
    Diagnostics errors(file, lines);
    errors.add(place, message);
    errors.throw_if_any();
    throw CaseError(file, {});  // not reached: an error was added
}

int count_values(const Value& value, int budget) {
    int count = 1;
    for (const Entry& entry : value.entries) {
        if (count > budget) break;
        count += count_values(entry.value, budget - count);
    }
    return count;
}

/// Builds the tree from the parser's events. Aliases are expanded here, where their cost is counted and one that
/// contains itself is still visible as an anchor that has not ended.
class TreeBuilder : public YAML::EventHandler {
public:
    TreeBuilder(const std::string& file, const std::vector<std::string>& lines) : file_(file), lines_(lines) {}
    Value root;
    bool has_root = false;

    void OnDocumentStart(const YAML::Mark& mark) override {
        if (has_root) stop(mark, "a second document starts here; a case is one document");
    }
    void OnDocumentEnd() override {}
    void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
        Value value = scalar(mark, "");
        value.null = true;
        place_value(std::move(value), anchor);
    }
    void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
        const auto found = anchors_.find(anchor);
        if (found == anchors_.end())
            stop(mark, "this alias refers to a value that contains it; write the value out instead");
        values_ += count_values(found->second, max_case_values);
        count(mark);
        if (static_cast<int>(stack_.size()) + depth_of(found->second) > max_case_depth) too_deep(mark);
        Value copy = found->second;
        copy.place = place_of(mark);
        place_value(std::move(copy), YAML::NullAnchor);
    }
    void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  const std::string& text) override {
        if (tag != "?" && tag != "!" && !tag.empty()) refuse_tag(mark, tag);
        Value value = scalar(mark, text);
        value.quoted = tag == "!";
        place_value(std::move(value), anchor);
    }
    void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                         YAML::EmitterStyle::value) override {
        open(mark, tag, anchor, Value::Form::list);
    }
    void OnSequenceEnd() override { close(); }
    void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                    YAML::EmitterStyle::value) override {
        open(mark, tag, anchor, Value::Form::map);
    }
    void OnMapEnd() override { close(); }

private:
    struct Frame {
        Value value;
        YAML::anchor_t anchor;
        bool has_key = false;
        std::string key;
        Place key_place;
    };
    const std::string& file_;
    const std::vector<std::string>& lines_;
    std::vector<Frame> stack_;
    std::map<YAML::anchor_t, Value> anchors_;
    int values_ = 0;

    static Place place_of(const YAML::Mark& mark) { return {mark.line + 1, mark.column + 1}; }
    [[noreturn]] void stop(const YAML::Mark& mark, const std::string& message) {
        fail(file_, lines_, place_of(mark), message);
    }
    [[noreturn]] void too_deep(const YAML::Mark& mark) {
        stop(mark, text("nested deeper than ", max_case_depth, " levels"));
    }
    [[noreturn]] void refuse_tag(const YAML::Mark& mark, const std::string& tag) {
        stop(mark, text("the tag '", printable(tag), "' is not supported; write plain YAML"));
    }
    static int depth_of(const Value& value) {
        int depth = 0;
        for (const Entry& entry : value.entries) depth = std::max(depth, depth_of(entry.value));
        return depth + 1;
    }
    [[noreturn]] void too_many(const Place& place) {
        fail(file_, lines_, place,
             text("more than ", max_case_values, " values", anchors_.empty() ? "" : " once aliases are expanded"));
    }
    void count(const YAML::Mark& mark) {
        if (values_ > max_case_values) too_many(place_of(mark));
    }
    Value scalar(const YAML::Mark& mark, const std::string& content) {
        Value value;
        value.text = content;
        value.place = place_of(mark);
        ++values_;
        count(mark);
        return value;
    }
    void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, Value::Form form) {
        if (tag != "?" && tag != "!" && !tag.empty()) refuse_tag(mark, tag);
        if (static_cast<int>(stack_.size()) >= max_case_depth) too_deep(mark);
        if (wants_key()) stop(mark, "a key must be plain text");
        Value value = scalar(mark, "");
        value.form = form;
        stack_.push_back({std::move(value), anchor, false, "", {}});
    }
    bool wants_key() const {
        return !stack_.empty() && stack_.back().value.form == Value::Form::map && !stack_.back().has_key;
    }
    void close() {
        Frame frame = std::move(stack_.back());
        stack_.pop_back();
        place_value(std::move(frame.value), frame.anchor);
    }
    void place_value(Value value, YAML::anchor_t anchor) {
        if (anchor != YAML::NullAnchor) {
            values_ += count_values(value, max_case_values);  // the copy costs as much as an alias
            if (values_ > max_case_values) too_many(value.place);
            anchors_[anchor] = value;
        }
        if (stack_.empty()) {
            root = std::move(value);
            has_root = true;
            return;
        }
        Frame& frame = stack_.back();
        if (frame.value.form == Value::Form::list) {
            frame.value.entries.push_back({"", value.place, std::move(value)});
        } else if (!frame.has_key) {
            take_key(frame, value);
        } else {
            if (value.null) value.place = frame.key_place;  // an empty value has no place
            frame.value.entries.push_back({std::move(frame.key), frame.key_place, std::move(value)});
            frame.has_key = false;
        }
    }
    void take_key(Frame& frame, const Value& value) {
        if (value.form != Value::Form::scalar || value.null)
            fail(file_, lines_, value.place, "a key must be plain text");
        if (value.text == "<<" && !value.quoted)
            fail(file_, lines_, value.place, "merge keys (<<) are not supported; write the keys out");
        frame.has_key = true;
        frame.key = value.text;
        frame.key_place = value.place;
    }
};

/// Line and column of byte `at`, columns counted in characters.
Place place_of_byte(const std::string& bytes, std::size_t at) {
    Place place{1, 1};
    for (std::size_t i = 0; i < at; ++i) {
        if (bytes[i] == '\n')
            place = {place.line + 1, 1};
        else if ((static_cast<unsigned char>(bytes[i]) & 0xC0) != 0x80)
            ++place.column;
    }
    return place;
}

void check_encoding(const std::string& bytes, const std::string& file, const std::vector<std::string>& lines) {
    if (bytes.rfind("\xFF\xFE", 0) == 0 || bytes.rfind("\xFE\xFF", 0) == 0)
        fail(file, {}, {1, 1}, "the file is UTF-16; save it as UTF-8");
    for (std::size_t i = 0; i < bytes.size();) {
        if (bytes[i] == '\0') fail(file, lines, place_of_byte(bytes, i), "a NUL character; a case is UTF-8 text");
        const std::size_t length = utf8_at(bytes, i).length;
        if (length == 0) fail(file, {}, place_of_byte(bytes, i), "not UTF-8; save the file as UTF-8");
        i += length;
    }
}

/// yaml-cpp reports a tab at the start of a line as something else, so its message is replaced.
[[noreturn]] void explain(const YAML::Exception& e, const std::string& file, const std::vector<std::string>& lines) {
    const int line = e.mark.line;
    if (line >= 0 && line < static_cast<int>(lines.size())) {
        const std::string& source = lines[line];
        const std::size_t first = source.find_first_not_of(" \t");
        if (source.substr(0, first).find('\t') != std::string::npos)
            fail(file, lines, {line + 1, 1}, "this line is indented with a tab; YAML requires spaces");
    }
    fail(file, lines, {line + 1, e.mark.column + 1}, text("not YAML: ", e.msg));
}

/// Who gives a run's folder in place of a case wants its case, or to go on with it.
std::string run_folder_hint(const std::string& path) {
    std::error_code ignored;
    const std::filesystem::path folder = path, inside = folder / "case.yaml";
    if (!std::filesystem::is_regular_file(inside, ignored)) return "";
    const bool is_run = std::filesystem::exists(folder / "journal.sqlite", ignored);
    return text("; its case is ", printable(inside.string(), 400),
                is_run ? text(", and `strake resume ", printable(path, 400), "` continues the run") : "");
}

}  // namespace

std::vector<std::string> split_lines(const std::string& bytes) {
    std::vector<std::string> lines;
    std::istringstream in(bytes);
    for (std::string line; std::getline(in, line);) {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        lines.push_back(line);
    }
    return lines;
}

std::string read_case_file(const std::string& path) {
    const auto refuse = [&](const std::string& why) { fail(path, {}, {0, 0}, why); };
    // Not blocking on a FIFO; what is not a regular file is refused before anything is read.
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor < 0) {
        const int cause = errno;
        refuse(text("cannot be read: ", std::strerror(cause), cause == ENOENT ? windows_path_hint(path) : ""));
    }
    struct Closer {
        int fd;
        ~Closer() { ::close(fd); }
    } closer{descriptor};
    struct stat info {};
    if (::fstat(descriptor, &info) != 0) refuse(text("cannot be read: ", std::strerror(errno)));
    if (S_ISDIR(info.st_mode)) refuse("is a folder, not a case file" + run_folder_hint(path));
    if (!S_ISREG(info.st_mode)) refuse("is not a regular file");
    std::string bytes;
    char block[65536];
    for (;;) {
        const ssize_t got = ::read(descriptor, block, sizeof block);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) refuse(text("cannot be read: ", std::strerror(errno)));
        if (got == 0) break;
        bytes.append(block, static_cast<std::size_t>(got));
        if (bytes.size() > max_case_bytes)
            refuse(text("is larger than ", max_case_bytes, " bytes; a case file holds settings, not data"));
    }
    return bytes;
}

Value parse_yaml(const std::string& raw, const std::string& file) {
    if (raw.size() > max_case_bytes)
        fail(file, {}, {0, 0}, text("is larger than ", max_case_bytes, " bytes; a case file holds settings, not data"));
    const std::string bytes = raw.rfind("\xEF\xBB\xBF", 0) == 0 ? raw.substr(3) : raw;
    const std::vector<std::string> lines = split_lines(bytes);
    check_encoding(bytes, file, lines);
    TreeBuilder builder(file, lines);
    try {
        std::istringstream in(bytes);
        YAML::Parser parser(in);
        while (parser.HandleNextDocument(builder)) {
        }
    } catch (const YAML::Exception& e) {
        explain(e, file, lines);
    }
    if (!builder.has_root || builder.root.null) fail(file, lines, {0, 0}, "is empty");
    return std::move(builder.root);
}

}  // namespace strake
