#include "casefile/schema/explain.hpp"

#include "casefile/schema/schema.hpp"
#include "cli/commands.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

/// `strake explain`: a key of the case file, from the loader's own table.
namespace strake::cli {
namespace {

using Json = nlohmann::ordered_json;

Json as_json(const KeyExplanation& found) {
    Json j{{"key", found.path}, {"forms", Json::array()}, {"below", Json::array()}};
    for (const KeyForm& form : found.forms)
        j["forms"].push_back({{"form", form.form},
                              {"limits", form.limits},
                              {"required", form.required},
                              {"default", form.fallback},
                              {"meaning", form.doc},
                              {"condition", form.condition}});
    for (const KeyBelow& key : found.below) {
        j["below"].push_back({{"key", key.name}, {"meaning", key.doc}});
        if (!found.type_doc.empty()) j["below"].back()["default"] = key.fallback;
    }
    if (!found.type_doc.empty()) j["meaning"] = found.type_doc;
    if (!found.type_values.empty()) j["values"] = found.type_values;
    if (!found.used_by.empty()) j["value_of"] = found.used_by;
    if (!found.asked_as.empty()) j["was"] = found.asked_as;
    return j;
}

/// The first sentence, for lists.
std::string brief(const std::string& doc) {
    const std::size_t end = doc.find(". ");
    const std::string sentence = end == std::string::npos ? doc : doc.substr(0, end + 1);
    return sentence.size() > 90 ? sentence.substr(0, 87) + "..." : sentence;
}

/// `doc` in lines of at most 76 characters, each after `margin`.
std::string wrapped(const std::string& doc, const std::string& margin) {
    std::string out, line;
    for (std::size_t from = 0; from < doc.size();) {
        const std::size_t space = std::min(doc.find(' ', from), doc.size());
        const std::string word = doc.substr(from, space - from);
        if (!line.empty() && line.size() + 1 + word.size() > 76) out += margin + line + "\n", line.clear();
        line += (line.empty() ? "" : " ") + word;
        from = space + 1;
    }
    return line.empty() ? out : out + margin + line + "\n";
}

void print_type(const KeyExplanation& found) {
    fmt::print("{}: a type of quantities\n{}", found.path, wrapped(found.type_doc, "    "));
    std::string keys = found.path;
    for (const KeyBelow& key : found.below)
        if (key.fallback == "required") keys += ", " + key.name + ": ...";
    fmt::print("  in a case  quantities: {{NAME: {{type: {}}}}}\n", keys);
    if (found.type_values.empty())
        fmt::print("  value      NAME\n");
    else
        fmt::print("  values     NAME. followed by {}\n", found.type_values);
    if (!found.below.empty()) fmt::print("  options:\n");
    std::size_t width = 0;
    for (const KeyBelow& key : found.below) width = std::max(width, key.name.size());
    for (const KeyBelow& key : found.below)
        fmt::print("    {:<{}}  {}{}\n", key.name, width, brief(key.doc),
                   key.fallback.empty()         ? ""
                   : key.fallback == "required" ? " [required]"
                                                : " [" + key.fallback + "]");
    fmt::print("see docs/objectives.md\n");
}

void print_words(const KeyExplanation& found) {
    if (!found.type_doc.empty()) return print_type(found);
    if (!found.asked_as.empty()) fmt::print("'{}' is now called:\n", found.asked_as);
    fmt::print("{}\n", found.path);
    for (const std::string& key : found.used_by) fmt::print("  is a value of {}\n", key);
    if (!found.used_by.empty()) fmt::print("see `strake explain {}`\n", found.used_by.front());
    for (const KeyForm& form : found.forms) {
        fmt::print("  form     {}{}\n", form.form, form.limits.empty() ? "" : ", " + form.limits);
        if (form.required) fmt::print("  default  none: the key is required\n");
        if (!form.fallback.empty()) fmt::print("  default  {}\n", form.fallback);
        fmt::print("{}", wrapped(form.doc + form.condition, "    "));
    }
    std::size_t width = 0;
    for (const KeyBelow& key : found.below) width = std::max(width, key.name.size());
    if (!found.below.empty()) fmt::print("  keys below it:\n");
    for (const KeyBelow& key : found.below)
        fmt::print("    {:<{}}  {}\n", key.name == "*" ? "NAME" : key.name, width, brief(key.doc));
}

void list_all() {
    std::size_t width = 0;
    for (const std::string& path : key_paths()) width = std::max(width, path.size());
    for (const std::string& path : key_paths())
        if (!path.ends_with("[]"))
            fmt::print("{:<{}}  {}\n", path, width, brief(schema_index().rows.at(path).front()->doc));
}

void explain_key(const std::string& key, bool json) {
    if (key.empty() && !json) return list_all();
    std::vector<KeyExplanation> found;
    if (!key.empty())
        found = explain(key);
    else
        for (const std::string& path : key_paths())
            if (!path.ends_with("[]")) found.push_back(explain(path).front());
    if (json) {
        Json j = Json::array();
        for (const KeyExplanation& one : found) j.push_back(as_json(one));
        fmt::print("{}\n", j.dump(2));
        return;
    }
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (i > 0) fmt::print("\n");
        print_words(found[i]);
    }
}

}  // namespace

void add_explain(CLI::App& app) {
    struct Arguments {
        std::string key;
        bool json = false;
    };
    auto args = std::make_shared<Arguments>();
    CLI::App* command = app.add_subcommand("explain", "explain a key of the case file; without KEY, list all of them");
    command
        ->add_option("KEY", args->key,
                     "for example optimize.method or regions.tip.box, or just its end, for example method")
        ->type_name("");
    command->add_flag("--json", args->json, "print a JSON array instead of words");
    command->callback([args] { explain_key(args->key, args->json); });
}

}  // namespace strake::cli
