#pragma once
#include <string>
#include <vector>

/// What `strake explain` says about a key of the case file, from the same table as everything else.
namespace strake {

struct KeyForm {
    std::string form, limits, fallback, doc, condition;  ///< without backquotes; empty where there is none
    bool required = false;
};
struct KeyBelow {
    std::string name, doc;      ///< name relative to the explained key
    std::string fallback = {};  ///< of options of a type: the default, or "required"
};
struct KeyExplanation {
    std::string path;                             ///< as in the table, "regions.*.box"
    std::vector<KeyForm> forms;                   ///< alternatives
    std::vector<KeyBelow> below;                  ///< keys of a map or of a list's entries; options of a type
    std::vector<std::string> used_by;             ///< of a word: keys that take it; then `forms` is empty
    std::string asked_as;                         ///< the name that this key or word had before, if that was asked for
    std::string type_doc = {}, type_values = {};  ///< of a type of quantities: what it measures, and its values
};

/// Every path of the table, once, in its order.
std::vector<std::string> key_paths();

/// One per match. `asked` is a path ("optimize.method", "regions.tip.box", "loads[0].region"), the end of one
/// ("budget.evaluations", "method") or a word that keys take ("sqp"), among them the types of quantities ("wave_drag");
/// names of earlier versions are understood.
/// @throws InvalidInput for anything else, with the nearest name.
std::vector<KeyExplanation> explain(const std::string& asked);

}  // namespace strake
