#pragma once
#include "core/error.hpp"

#include <string>
#include <vector>

/// Errors and notes about a case file, with places. Nothing here knows YAML.
namespace strake {

/// 1-based, as editors count; {0, 0}: the file as a whole; negative lines: settings of the command line.
struct Place {
    int line = 0, column = 0;
};
inline Place place_of_setting(std::size_t k) { return {-1 - static_cast<int>(k), 1}; }
/// "line 7" or "--set".
std::string line_words(const Place& place);

struct Diagnostic {
    Place place;
    std::string message;
    std::string source_line;   ///< the line that `place` points at, cut to 120 characters; may be empty
    std::string setting = {};  ///< "--set KEY=VALUE" in place of a line of the file; empty: of the file
};

/// A case file that cannot be used. what() is one line `file:line:column: message` a diagnostic, by line.
struct CaseError : InvalidInput {
    CaseError(const std::string& file, std::vector<Diagnostic> diagnostics, std::vector<std::string> notes = {});
    std::vector<Diagnostic> diagnostics;
    std::vector<std::string> notes;  ///< see Diagnostics::notes
    std::string file;
    /// what(), each message followed by the quoted source line; then the notes.
    std::string quoted() const;
};

/// Collects the errors of one file, to report them together.
class Diagnostics {
public:
    /// @param settings KEY=VALUE of the command line, for places by `place_of_setting`
    Diagnostics(std::string file, std::vector<std::string> lines, std::vector<std::string> settings = {})
        : file_(std::move(file)), lines_(std::move(lines)), settings_(std::move(settings)) {}
    /// The same message at the same place is kept once.
    void add(const Place& place, const std::string& message);
    /// A remark that is no error.
    void note(const Place& place, const std::string& message);
    bool empty() const { return found_.empty(); }
    /// Lines "case.yaml:14:5: note: ...", by line.
    std::vector<std::string> notes() const;
    bool suggests(const std::string& key) const;  ///< a message already suggests this key: it is misspelt, not missing
    const std::string& file() const { return file_; }
    const std::vector<std::string>& lines() const { return lines_; }
    void throw_if_any() const;  ///< @throws CaseError sorted by line and column

private:
    std::string file_;
    std::vector<std::string> lines_, settings_;
    std::string setting_of(const Place& place) const;
    std::vector<Diagnostic> found_, notes_;
};

/// Safe to print: control characters and bytes that are not UTF-8 as `\xNN`, cut after `limit` bytes.
std::string printable(const std::string& raw, std::size_t limit = 80);

/// Number of insertions, deletions, substitutions and swaps of neighbours between two words.
int damerau_distance(const std::string& a, const std::string& b);
/// The candidate nearest to `word` within 2 edits or a third of its length (tie: the first); empty: none.
std::string nearest(const std::string& word, const std::vector<std::string>& candidates);
std::string joined(const std::vector<std::string>& words, const std::string& separator = ", ");

}  // namespace strake
