#pragma once
#include "core/error.hpp"

#include <string>
#include <vector>

/// What is wrong with a case file, with places. Nothing here knows YAML.
namespace strake {

/// 1-based, as editors count; {0, 0}: the file as a whole.
struct Place {
    int line = 0, column = 0;
};

struct Diagnostic {
    Place place;
    std::string message;
    std::string source_line;  ///< the line that `place` points at, cut to 120 characters; may be empty
};

/// A case file that cannot be used. what() is one line `file:line:column: message` a diagnostic, by line.
struct CaseError : InvalidInput {
    CaseError(const std::string& file, std::vector<Diagnostic> diagnostics);
    std::vector<Diagnostic> diagnostics;
    std::string file;
    /// what(), each message followed by the quoted source line.
    std::string quoted() const;
};

/// Collects the errors of one file, so that all are told at once.
class Diagnostics {
public:
    Diagnostics(std::string file, std::vector<std::string> lines) : file_(std::move(file)), lines_(std::move(lines)) {}
    /// The same message at the same place is kept once.
    void add(const Place& place, const std::string& message);
    bool empty() const { return found_.empty(); }
    bool suggests(const std::string& key) const;  ///< some message asks "did you mean" this key: it is not missing
    const std::string& file() const { return file_; }
    const std::vector<std::string>& lines() const { return lines_; }
    void throw_if_any() const;  ///< @throws CaseError sorted by line and column

private:
    std::string file_;
    std::vector<std::string> lines_;
    std::vector<Diagnostic> found_;
};

/// Control characters and bytes that are no text as \xNN, at most `limit` characters: safe to print.
std::string printable(const std::string& raw, std::size_t limit = 80);

/// Number of insertions, deletions, substitutions and swaps of neighbours between two words.
int damerau_distance(const std::string& a, const std::string& b);
/// The candidate nearest to `word` within 2 edits or a third of its length (tie: the first); empty: none.
std::string nearest(const std::string& word, const std::vector<std::string>& candidates);
std::string joined(const std::vector<std::string>& words, const std::string& separator = ", ");

}  // namespace strake
