#include "casefile/schema/renamed.hpp"
#include "casefile/schema/schema_words.hpp"
#include "core/error.hpp"

namespace strake {
namespace {

const char* introduction = R"(# Case file reference

`strake schema` writes this page from the tables in `casefile/schema/`; a test compares the two.

A case is one YAML document in UTF-8. Paths are relative to the case file. In the table, `*` is a name of your choice
and `[]` an entry of a list; several rows with the same key are alternative forms. Unknown keys, keys given twice and
wrong values are errors; all errors are reported together as `file:line:column: message`.

- **length**: a plain number is in the surface's unit; `5 mm` (m, cm, mm, um, in, ft) is converted to it and requires
  `surface.units`; `5%` is relative to the diagonal of the start surface's bounding box. A **coordinate** cannot be a
  percentage.
- **angle**: every number has the unit `deg` or `rad`; a plain 0 is allowed. **time**: `s`, `min` or `h`.
- **number**: decimal point, no thousands separators, no leading zeros, finite; text in quotes is not a number.
- **name**: letters, digits, `_` and `-`. YAML aliases (`&`, `*`) work; merge keys (`<<`), tags and a second document do
  not.

| key | form | limits | default | meaning |
|---|---|---|---|---|
)";

const char* renamed_introduction = R"(
## Renamed keys

Until version 1.0 the old names are read, with a note.

| key | old name | new name |
|---|---|---|
)";

}  // namespace

std::string schema_reference() {
    std::string out = introduction;
    for (const Key& key : schema())
        out += text("| `", key.path, "` | ", shape_of(key), " | ", limits_of(key), " | ", default_of(key), " | ",
                    key.doc, condition_of(key), " |\n");
    out += renamed_introduction;
    for (const RenamedKey& key : renamed_keys())
        out += text("| `", key.path(), "` | `", key.before, "` | `", key.now, "` |\n");
    for (const MovedKey& key : moved_keys())
        out += text("| `", key.path, "` | `", key.path.substr(key.path.rfind('.') + 1), "` | `", key.now, "` |\n");
    for (const RenamedWord& word : renamed_words())
        out += text("| value of `", word.path, "` | `", word.before, "` | `", word.now, "` |\n");
    return out;
}

}  // namespace strake
