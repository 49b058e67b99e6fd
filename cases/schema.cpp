#include "cases/schema_parts.hpp"

#include <algorithm>
#include <sstream>

namespace strake {

Condition parse_condition(const std::string& when) {
    const std::size_t equal = when.find('=');
    Condition condition{when.substr(0, equal), Condition::Kind::present, {}};
    if (equal == std::string::npos) {
        std::istringstream keys(when);
        for (std::string key; std::getline(keys, key, '|');) condition.words.push_back(key);
        condition.key = condition.words.front();
        return condition;
    }
    const std::string wanted = when.substr(equal + 1);
    condition.kind = wanted == "[]" ? Condition::Kind::is_list : Condition::Kind::is_word;
    if (condition.key.ends_with("[]")) {
        condition.key.resize(condition.key.size() - 2);
        condition.kind = Condition::Kind::holds_word;
    }
    std::istringstream words(wanted);
    for (std::string word; std::getline(words, word, '|');) condition.words.push_back(word);
    return condition;
}

const std::vector<Key>& schema() {
    static const std::vector<Key> keys = [] {
        std::vector<Key> all;
        for (const auto& part : {surface_keys(), mending_keys(), shell_keys(), parameter_keys(), given_keys(),
                                 variable_keys(), goal_keys(), run_keys()})
            all.insert(all.end(), part.begin(), part.end());
        // Those of the families of quantities stand with the other keys of quantities.
        const auto objective =
            std::find_if(all.begin(), all.end(), [](const Key& key) { return key.path == "objective"; });
        std::vector<Key> families = form_keys();
        for (const Key& key : aero_keys()) families.push_back(key);
        all.insert(objective, families.begin(), families.end());
        return all;
    }();
    return keys;
}

const SchemaIndex& schema_index() {
    static const SchemaIndex index = [] {
        SchemaIndex built;
        for (const Key& key : schema()) {
            built.rows[key.path].push_back(&key);
            const std::size_t dot = key.path.rfind('.');
            const std::string parent = dot == std::string::npos ? "" : key.path.substr(0, dot);
            const std::string name = dot == std::string::npos ? key.path : key.path.substr(dot + 1);
            if (name.ends_with("[]")) continue;
            auto& names = built.children[parent];
            if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
        }
        return built;
    }();
    return index;
}

}  // namespace strake
