#include "casefile/schema/explain.hpp"

#include "casefile/schema/quantity_types.hpp"
#include "casefile/schema/renamed.hpp"
#include "casefile/schema/schema_words.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <optional>
#include <sstream>

namespace strake {
namespace {

/// "loads[].region" as {"loads", "region"}; "*" stays.
std::vector<std::string> steps_of(const std::string& path) {
    std::vector<std::string> steps;
    std::istringstream parts(path);
    for (std::string step; std::getline(parts, step, '.');) {
        steps.push_back(step.substr(0, step.find('[')));
    }
    return steps;
}

bool matches(const std::vector<std::string>& pattern, const std::vector<std::string>& asked, bool may_name) {
    if (pattern.size() != asked.size()) return false;
    for (std::size_t i = 0; i < pattern.size(); ++i)
        if (pattern[i] != asked[i] && !(may_name && pattern[i] == "*")) return false;
    return true;
}

bool ends_with(const std::vector<std::string>& path, const std::vector<std::string>& end) {
    return end.size() <= path.size() && std::equal(end.rbegin(), end.rend(), path.rbegin());
}

std::string without_quotes(std::string words) {
    words.erase(std::remove(words.begin(), words.end(), '`'), words.end());
    return words;
}

/// Rows below `path`: keys of the map, or of the entries of the list.
std::vector<KeyBelow> below(const std::string& path) {
    std::vector<KeyBelow> list;
    for (const std::string& parent : {path, path + "[]"}) {
        const auto found = schema_index().children.find(parent);
        if (found == schema_index().children.end()) continue;
        for (const std::string& name : found->second)
            list.push_back({name, schema_index().rows.at(parent + "." + name).front()->doc});
    }
    return list;
}

KeyExplanation explanation(const std::string& path) {
    KeyExplanation found{path, {}, below(path), {}, ""};
    for (const Key* key : schema_index().rows.at(path))
        found.forms.push_back({without_quotes(shape_of(*key)), limits_of(*key),
                               key->required ? "" : without_quotes(default_of(*key)), key->doc,
                               without_quotes(condition_of(*key)), key->required});
    return found;
}

std::vector<std::string> keys_that_take(const std::string& word) {
    std::vector<std::string> keys;
    for (const Key& key : schema())
        for (const auto* words : {&key.words, &key.aliases})
            if (std::find(words->begin(), words->end(), word) != words->end() &&
                std::find(keys.begin(), keys.end(), key.path) == keys.end())
                keys.push_back(key.path);
    return keys;
}

/// A type of quantities with the keys that it takes.
std::optional<KeyExplanation> type_explanation(const std::string& word) {
    for (const QuantityType& type : quantity_types()) {
        if (type.word != word) continue;
        KeyExplanation found{word, {}, {}, {"quantities.*.type"}, "", type.doc, type.values};
        const std::string prefix = "quantities.*.";
        for (const std::string& path : key_paths()) {
            const Key& row = *schema_index().rows.at(path).front();
            if (!path.starts_with(prefix) || row.when.empty()) continue;
            const Condition condition = parse_condition(row.when);
            if (condition.key == "type" && condition.kind == Condition::Kind::is_word &&
                std::find(condition.words.begin(), condition.words.end(), word) != condition.words.end())
                found.below.push_back({path.substr(prefix.size()), row.doc, without_quotes(default_of(row))});
        }
        return found;
    }
    return {};
}

std::vector<std::string> same_end(const std::vector<std::string>& asked) {
    std::vector<std::string> found;
    for (const std::string& path : key_paths())
        if (!path.ends_with("[]") && ends_with(steps_of(path), asked)) found.push_back(path);
    return found;
}

/// Of a key or word that had another name before.
std::vector<KeyExplanation> under_present_name(const std::vector<std::string>& asked) {
    std::vector<KeyExplanation> found;
    for (const RenamedKey& renamed : renamed_keys()) {
        std::vector<std::string> before = steps_of(renamed.path());
        before.back() = renamed.before;
        const std::size_t shared = std::min(before.size(), asked.size());
        const std::vector<std::string> end(before.end() - static_cast<std::ptrdiff_t>(shared), before.end());
        if (shared < asked.size() || !matches(end, asked, true)) continue;
        found.push_back(explanation(renamed.path()));
        found.back().asked_as = renamed.before;
    }
    for (const RenamedWord& renamed : renamed_words())
        if (asked.size() == 1 && renamed.before == asked[0])
            found.push_back({renamed.now, {}, {}, keys_that_take(renamed.now), renamed.before});
    return found;
}

[[noreturn]] void refuse(const std::string& asked) {
    std::vector<std::string> candidates;
    for (const std::string& path : key_paths()) {
        candidates.push_back(path);
        candidates.push_back(steps_of(path).back());
        if (path.find('[') != std::string::npos) {
            std::string plain = path;
            for (std::size_t at; (at = plain.find("[]")) != std::string::npos;) plain.erase(at, 2);
            candidates.push_back(plain);
        }
    }
    const std::string near = nearest(asked, candidates), hint = quantity_hint(asked);
    if (!hint.empty()) throw InvalidInput(text("explain: '", printable(asked, 100), "' is no key of a case; ", hint));
    throw InvalidInput(text("explain: there is no key '", printable(asked, 100), "'",
                            near.empty() ? "; `strake explain` lists all" : text("; did you mean '", near, "'?")));
}

}  // namespace

std::vector<std::string> key_paths() {
    std::vector<std::string> paths;
    for (const Key& key : schema())
        if (std::find(paths.begin(), paths.end(), key.path) == paths.end()) paths.push_back(key.path);
    return paths;
}

std::vector<KeyExplanation> explain(const std::string& asked) {
    const std::vector<std::string> steps = steps_of(asked);
    if (steps.empty()) refuse(asked);
    for (const bool may_name : {false, true})
        for (const std::string& path : key_paths())
            if (!path.ends_with("[]") && matches(steps_of(path), steps, may_name)) return {explanation(path)};
    std::vector<KeyExplanation> found;
    for (const std::string& path : same_end(steps)) found.push_back(explanation(path));
    if (const auto type = type_explanation(asked)) found.push_back(*type);
    if (!found.empty()) return found;
    const std::vector<std::string> keys = keys_that_take(asked);
    if (!keys.empty()) return {{asked, {}, {}, keys, ""}};
    found = under_present_name(steps);
    if (found.empty()) refuse(asked);
    return found;
}

}  // namespace strake
