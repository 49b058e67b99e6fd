#include "casefile/schema/renamed.hpp"

namespace strake {
namespace {

std::string child_path(const std::string& path, const std::string& name) {
    const auto& rows = schema_index().rows;
    const std::string exact = path.empty() ? name : path + "." + name, any = path.empty() ? "*" : path + ".*";
    return rows.contains(exact) || !rows.contains(any) ? exact : any;
}

class Renamer {
public:
    explicit Renamer(Diagnostics& errors) : errors_(errors) {}

    void value(Value& value, const std::string& path) {
        if (value.form == Value::Form::scalar) return word(value, path);
        if (value.form == Value::Form::map) keys(value, path);
        for (Entry& entry : value.entries)
            this->value(entry.value, value.form == Value::Form::map ? child_path(path, entry.key) : path + "[]");
    }

private:
    Diagnostics& errors_;

    void word(Value& value, const std::string& path) {
        for (const RenamedWord& renamed : renamed_words())
            if (renamed.path == path && value.text == renamed.before) {
                note(value.place, renamed.before, renamed.now);
                value.text = renamed.now;
            }
    }

    void keys(Value& map, const std::string& path) {
        for (const RenamedKey& renamed : renamed_keys())
            if (renamed.map == path) key(map, renamed);
    }

    /// Two entries of one name are left to `validate`; of both names the second one goes.
    void key(Value& map, const RenamedKey& renamed) {
        const Entry* first = nullptr;
        std::string first_name;
        for (std::size_t i = 0; i < map.entries.size(); ++i) {
            Entry& entry = map.entries[i];
            if (entry.key != renamed.before && entry.key != renamed.now) continue;
            const std::string name = entry.key;
            if (first && name != first_name) {
                errors_.add(entry.key_place,
                            text("'", name, "' and '", first_name, "' (", line_words(first->key_place),
                                 ") are the same key; '", renamed.before, "' is now called '", renamed.now, "'"));
                map.entries.erase(map.entries.begin() + static_cast<std::ptrdiff_t>(i--));
                continue;
            }
            if (name == renamed.before) note(entry.key_place, renamed.before, renamed.now);
            entry.key = renamed.now;
            if (!first) first = &entry, first_name = name;
        }
    }

    void note(const Place& place, const std::string& before, const std::string& now) {
        errors_.note(place, text("'", before, "' is now called '", now, "'"));
    }
};

}  // namespace

const std::vector<RenamedKey>& renamed_keys() {
    static const std::vector<RenamedKey> table{
        {"quantities.*", "gives", "outputs"},
        {"quantities.*", "wanted", "target"},
        {"quantities.*", "points_reach", "support_radius"},
        {"quantities.*", "lee", "leeward"},
        {"quantities.*", "about", "moment_center"},
        {"quantities.*", "layer", "boundary_layer"},
        {"parameters", "freeze", "frozen"},
        {"parameters", "on", "variables_on"},
        {"parameters", "core", "free_border"},
        {"parameters", "split_share", "marking_fraction"},
        {"parameters", "growth", "max_variable_ratio"},
        {"optimize", "associations", "icp_iterations"},
        {"optimize.refine_when", "promise_below", "min_expected_gain"},
    };
    return table;
}

const std::vector<MovedKey>& moved_keys() {
    static const std::vector<MovedKey> table{{"quantities.*.forward", "axes.downstream"},
                                             {"quantities.*.up", "axes.up"}};
    return table;
}

const std::vector<RenamedWord>& renamed_words() {
    static const std::vector<RenamedWord> table{
        {"parameters.variables[]", "load_normal", "normal"},
        {"optimize.method", "slsqp", "sqp"},
    };
    return table;
}

void rename_old(Value& root, Diagnostics& errors) { Renamer(errors).value(root, ""); }

}  // namespace strake
