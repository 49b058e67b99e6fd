#include "cases/schema_words.hpp"
#include "core/error.hpp"

namespace strake {
namespace {

const char* introduction = R"(# Case file reference

This page is made from the tables in `cases/schema_*.cpp`; a test compares the two.

A case is one YAML document in UTF-8. Paths are relative to the case file. In the table `*` is a name of your own
and `[]` an entry of a list; several rows of one key are its alternative forms. Unknown keys, keys given twice and wrong
values are errors, all told at once as `file:line:column: message`.

- **length**: a plain number is in the surface's unit; `5 mm` (m, cm, mm, um, in, ft) is converted to it and needs
  `surface.units`; `5%` is of the diagonal of the start surface's bounding box. A **coordinate** takes no percentage.
- **angle**: every number carries `deg` or `rad`; a plain 0 is accepted. **time**: `s`, `min` or `h`.
- **number**: decimal point, no thousands separators, no leading zeros, finite; text in quotes is not a number.
- **name**: letters, digits, `_` and `-`. Aliases (`&`, `*`) work; merge keys (`<<`), tags and a second document do not.

| key | form | limits | default | meaning |
|---|---|---|---|---|
)";

}  // namespace

std::string schema_reference() {
    std::string out = introduction;
    for (const Key& key : schema())
        out += text("| `", key.path, "` | ", shape_of(key), " | ", limits_of(key), " | ", default_of(key), " | ",
                    key.doc, condition_of(key), " |\n");
    return out;
}

}  // namespace strake
