#include "casefile/read/settings.hpp"

#include <algorithm>
#include <optional>

namespace strake {
namespace {

/// A part of a key's path.
struct Step {
    std::string name;
    bool is_index = false;   ///< written as [3]
    bool is_quoted = false;  ///< never joined with its neighbours
};

bool is_number(const std::string& word) {
    return !word.empty() && word.size() < 10 && word.find_first_not_of("0123456789") == std::string::npos;
}

void set_places(Value& value, const Place& place) {
    value.place = place;
    for (Entry& entry : value.entries) {
        entry.key_place = place;
        set_places(entry.value, place);
    }
}

/// One setting on its way into the tree. A refusal is an exception between its functions.
class Setting {
public:
    Setting(const std::string& words, const Place& place) : words_(words), place_(place) {}

    void apply(Value& root) {
        const std::size_t equal = end_of_key();
        if (equal == std::string::npos || equal == 0)
            throw InvalidInput("must be KEY=VALUE, for example optimize.budget.evaluations=20");
        read_steps(words_.substr(0, equal));
        if (steps_.size() > static_cast<std::size_t>(max_case_depth))
            throw InvalidInput(text("a key with more than ", max_case_depth, " parts"));
        put(root, 0, "", value_of(words_.substr(equal + 1)));
    }

private:
    const std::string& words_;
    Place place_;
    std::vector<Step> steps_;

    std::size_t end_of_key() const {
        bool in_quotes = false;
        for (std::size_t i = 0; i < words_.size(); ++i) {
            in_quotes ^= words_[i] == '"';
            if (words_[i] == '=' && !in_quotes) return i;
        }
        return std::string::npos;
    }

    void read_steps(const std::string& key) {
        const auto refuse = [] {
            throw InvalidInput("the key must be names joined by dots and [NUMBER], for example loads[0].traction");
        };
        std::size_t i = 0;
        while (i < key.size()) {
            Step step;
            if (key[i] == '[') {
                const std::size_t end = key.find(']', i);
                if (end == std::string::npos || !is_number(key.substr(i + 1, end - i - 1))) refuse();
                step = {key.substr(i + 1, end - i - 1), true, false};
                i = end + 1;
            } else if (key[i] == '"') {
                const std::size_t end = key.find('"', i + 1);
                if (end == std::string::npos) refuse();
                step = {key.substr(i + 1, end - i - 1), false, true};
                i = end + 1;
            } else {
                const std::size_t end = std::min(key.find_first_of(".[\"", i), key.size());
                step.name = key.substr(i, end - i);
                i = end;
            }
            if (step.name.empty()) refuse();
            steps_.push_back(step);
            if (i < key.size() && key[i] == '.' && ++i == key.size()) refuse();
        }
    }

    Value value_of(const std::string& yaml) const {
        Value value;
        if (yaml.find_first_not_of(" \t\n") == std::string::npos) {
            value.null = true;
        } else {
            try {
                value = parse_yaml(yaml, "");
            } catch (const CaseError& error) {
                throw InvalidInput(text("the value is not valid YAML: ", error.diagnostics.front().message));
            }
        }
        set_places(value, place_);
        return value;
    }

    /// The entry that steps `at`... name, and the first step behind its name. A name may hold dots.
    std::pair<Entry*, std::size_t> existing(Value& map, std::size_t at) const {
        std::size_t end = at + 1;
        while (end < steps_.size() && !steps_[at].is_quoted && !steps_[end].is_index && !steps_[end].is_quoted) ++end;
        for (; end > at; --end)
            for (Entry& entry : map.entries)
                if (entry.key == name_of(at, end)) return {&entry, end};
        return {nullptr, at};
    }
    std::string name_of(std::size_t at, std::size_t end) const {
        std::string name = steps_[at].name;
        for (std::size_t i = at + 1; i < end; ++i) name += "." + steps_[i].name;
        return name;
    }

    void put(Value& node, std::size_t at, const std::string& path, Value value) {
        if (at == steps_.size()) {
            node = std::move(value);
            return;
        }
        if (node.null) {
            node = Value{};
            node.form = steps_[at].is_index ? Value::Form::list : Value::Form::map;
            node.place = place_;
        }
        const std::string shown = path.empty() ? "the case" : "'" + printable(path) + "'";
        if (node.form == Value::Form::scalar)
            throw InvalidInput(
                text(shown, " is '", printable(node.text), "', which has no keys below it; set it as a whole"));
        if (node.form == Value::Form::list) return put_in_list(node, at, path, std::move(value));
        if (steps_[at].is_index) throw InvalidInput(text(shown, " is a map, not a list"));
        auto [entry, next] = existing(node, at);
        if (!entry) {
            // The only names with dots: `constraints` of values of quantities.
            const bool is_constraint = path == "constraints" && !steps_[at].is_quoted && steps_.size() > at + 2;
            next = is_constraint ? steps_.size() - 1 : at + 1;
            Value empty;
            empty.null = true;
            empty.place = place_;
            node.entries.push_back({name_of(at, next), place_, std::move(empty)});
            entry = &node.entries.back();
        }
        put(entry->value, next, path.empty() ? entry->key : path + "." + entry->key, std::move(value));
    }

    void put_in_list(Value& list, std::size_t at, const std::string& path, Value value) {
        const std::size_t n = list.entries.size();
        if (!is_number(steps_[at].name) || steps_[at].is_quoted)
            throw InvalidInput(text("'", printable(path), "' is a list of ", n, "; its entries are [0], [1], ..."));
        const std::size_t k = std::stoul(steps_[at].name);
        if (k > n)
            throw InvalidInput(
                text("'", printable(path), "' is a list of ", n, "; [", n, "] appends, [", k, "] is beyond its end"));
        if (k == n) {
            Value empty;
            empty.null = true;
            empty.place = place_;
            list.entries.push_back({"", place_, std::move(empty)});
        }
        put(list.entries[k].value, at + 1, text(path, "[", k, "]"), std::move(value));
    }
};

}  // namespace

void apply_settings(Value& root, const std::vector<std::string>& settings, Diagnostics& errors) {
    if (root.form != Value::Form::map) return;  // `validate` refuses it
    for (std::size_t k = 0; k < settings.size(); ++k) {
        const Place place = place_of_setting(k);
        try {
            Setting(settings[k], place).apply(root);
        } catch (const InvalidInput& refused) {
            errors.add(place, refused.what());
        }
    }
}

}  // namespace strake
