#include "casefile/yaml/diagnostics.hpp"

#include "core/text/utf8.hpp"

#include <algorithm>
#include <tuple>

namespace strake {
namespace {

std::string one_line(const std::string& file, const Diagnostic& d) {
    if (!d.setting.empty()) return text(d.setting, ": ", d.message);
    if (d.place.line == 0) return text(printable(file, 400), ": ", d.message);
    return text(printable(file, 400), ":", d.place.line, ":", d.place.column, ": ", d.message);
}

std::string all_lines(const std::string& file, const std::vector<Diagnostic>& diagnostics) {
    std::string all;
    for (const Diagnostic& d : diagnostics) all.append(all.empty() ? "" : "\n").append(one_line(file, d));
    return all;
}

std::vector<Diagnostic> sorted(std::vector<Diagnostic> all) {
    std::stable_sort(all.begin(), all.end(), [](const Diagnostic& a, const Diagnostic& b) {
        return std::tie(a.place.line, a.place.column) < std::tie(b.place.line, b.place.column);
    });
    return all;
}

}  // namespace

std::string line_words(const Place& place) { return place.line < 0 ? "--set" : text("line ", place.line); }

CaseError::CaseError(const std::string& case_file, std::vector<Diagnostic> found, std::vector<std::string> noted)
    : InvalidInput(all_lines(case_file, found)),
      diagnostics(std::move(found)),
      notes(std::move(noted)),
      file(case_file) {}

std::string CaseError::quoted() const {
    std::string all;
    for (const Diagnostic& d : diagnostics) {
        all.append(all.empty() ? "" : "\n").append(one_line(file, d));
        if (!d.source_line.empty()) all += text("\n  ", d.place.line, " | ", d.source_line);
    }
    for (const std::string& note : notes) all.append("\n").append(note);
    return all;
}

void Diagnostics::add(const Place& place, const std::string& message) {
    for (const Diagnostic& d : found_)
        if (d.place.line == place.line && d.place.column == place.column && d.message == message) return;
    Diagnostic diagnostic{place, message, "", setting_of(place)};
    if (place.line >= 1 && place.line <= static_cast<int>(lines_.size()))
        diagnostic.source_line = printable(lines_[place.line - 1], 120);
    found_.push_back(std::move(diagnostic));
}

void Diagnostics::note(const Place& place, const std::string& message) {
    for (const Diagnostic& d : notes_)
        if (d.place.line == place.line && d.place.column == place.column && d.message == message) return;
    notes_.push_back({place, message, "", setting_of(place)});
}

std::string Diagnostics::setting_of(const Place& place) const {
    const auto k = static_cast<std::size_t>(-1 - place.line);
    return place.line < 0 && k < settings_.size() ? "--set " + printable(settings_[k], 120) : "";
}

std::vector<std::string> Diagnostics::notes() const {
    std::vector<std::string> lines;
    for (const Diagnostic& d : sorted(notes_))
        lines.push_back(one_line(file_, {d.place, "note: " + d.message, "", d.setting}));
    return lines;
}

bool Diagnostics::suggests(const std::string& key) const {
    const std::string hint = "did you mean '" + key + "'?";
    return std::any_of(found_.begin(), found_.end(),
                       [&](const Diagnostic& d) { return d.message.find(hint) != std::string::npos; });
}

void Diagnostics::throw_if_any() const {
    if (found_.empty()) return;
    throw CaseError(file_, sorted(found_), notes());
}

std::string printable(const std::string& raw, std::size_t limit) {
    static const char* digits = "0123456789ABCDEF";
    std::string out;
    for (std::size_t i = 0; i < raw.size();) {
        if (out.size() >= limit) return out + "...";
        const Utf8Character character = utf8_at(raw, i);
        const bool is_shown = character.length > 0 && !is_control(character.code);
        for (const std::size_t end = i + std::max<std::size_t>(1, character.length); i < end; ++i) {
            const auto c = static_cast<unsigned char>(raw[i]);
            if (is_shown)
                out += raw[i];
            else
                out += {'\\', 'x', digits[c >> 4], digits[c & 15]};
        }
    }
    return out;
}

int damerau_distance(const std::string& a, const std::string& b) {
    const int n = static_cast<int>(a.size()), m = static_cast<int>(b.size());
    std::vector<std::vector<int>> d(n + 1, std::vector<int>(m + 1));
    for (int i = 0; i <= n; ++i) d[i][0] = i;
    for (int j = 0; j <= m; ++j) d[0][j] = j;
    for (int i = 1; i <= n; ++i)
        for (int j = 1; j <= m; ++j) {
            const int change = a[i - 1] == b[j - 1] ? 0 : 1;
            d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + change});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
        }
    return d[n][m];
}

std::string nearest(const std::string& word, const std::vector<std::string>& candidates) {
    constexpr std::size_t longest = 100;  // nobody mistypes more, and the distance is quadratic
    if (word.empty() || word.size() > longest) return "";
    std::string best;
    int best_distance = std::max(2, static_cast<int>(word.size()) / 3) + 1;
    for (const std::string& candidate : candidates) {
        if (candidate.size() > longest) continue;
        const int distance = damerau_distance(word, candidate);
        // Two letters changed of two letters is another word, not a mistyped one.
        if (distance >= static_cast<int>(std::min(word.size(), candidate.size()))) continue;
        if (distance < best_distance) {
            best_distance = distance;
            best = candidate;
        }
    }
    return best;
}

std::string joined(const std::vector<std::string>& words, const std::string& separator) {
    std::string all;
    for (std::size_t i = 0; i < words.size(); ++i) all.append(i ? separator : "").append(words[i]);
    return all;
}

}  // namespace strake
