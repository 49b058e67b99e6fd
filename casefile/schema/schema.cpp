#include "casefile/schema/schema_parts.hpp"

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
    const std::string right = when.substr(equal + 1);
    condition.kind = right == "[]" ? Condition::Kind::is_list : Condition::Kind::is_word;
    if (condition.key.ends_with("[]")) {
        condition.key.resize(condition.key.size() - 2);
        condition.kind = Condition::Kind::holds_word;
    }
    std::istringstream words(right);
    for (std::string word; std::getline(words, word, '|');) condition.words.push_back(word);
    return condition;
}

std::vector<Key> in_order(const std::vector<std::vector<Key>>& lists) {
    std::vector<Key> all;
    for (const std::vector<Key>& list : lists) all.insert(all.end(), list.begin(), list.end());
    return all;
}

const std::vector<Key>& schema() {
    static const std::vector<Key> keys =
        in_order({surface_keys(), repair_and_remesh_keys(), shell_keys(), planform_keys(), parameter_keys(),
                  user_variable_keys(), program_parameter_keys(), quantity_keys(), program_keys(), geometry_keys(),
                  aero_keys(), goal_keys(), run_keys()});
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
