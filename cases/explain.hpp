#pragma once
#include <string>
#include <vector>

/// What `strake explain` tells of a key of the case file, from the same table as everything else.
namespace strake {

struct KeyForm {
    std::string form, limits, fallback, doc, condition;  ///< without backquotes; empty where there is none
    bool required = false;
};
struct KeyBelow {
    std::string name, doc;  ///< name relative to the explained key
};
struct KeyExplanation {
    std::string path;                  ///< as in the table, "regions.*.box"
    std::vector<KeyForm> forms;        ///< alternatives
    std::vector<KeyBelow> below;       ///< keys of a map or of a list's entries
    std::vector<std::string> used_by;  ///< of a word: keys that take it; then `forms` is empty
};

/// Every path of the table, once, in its order.
std::vector<std::string> key_paths();

/// One a match. `wanted` is a path ("optimize.method", "regions.tip.box", "loads[0].region"), the end of one
/// ("budget.evaluations", "method") or a word that keys take ("slsqp").
/// @throws InvalidInput for what is none of these, with the nearest.
std::vector<KeyExplanation> explain(const std::string& wanted);

}  // namespace strake
