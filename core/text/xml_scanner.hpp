#pragma once
#include <map>
#include <string>
#include <string_view>

namespace strake {

/// Reads the tags of an XML text in order; the subset of XML in VTK's files (only the five standard entities, no
/// CDATA).
class XmlScanner {
public:
    struct Tag {
        std::string name;                               ///< "/name" at its end; empty: no further tag
        std::map<std::string, std::string> attributes;  ///< by name
        bool is_empty = false;                          ///< without content
        std::string value(const std::string& key, const std::string& fallback = "") const {
            const auto at = attributes.find(key);
            return at == attributes.end() ? fallback : at->second;
        }
    };
    /// `name` of the file for messages; `text` outlives the scanner.
    XmlScanner(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

    Tag next();  ///< skips text, comments and declarations. @throws InputError
    /// Text of the element that the last tag opened, before its child elements or else after them; then moves past its
    /// end.
    std::string_view own_text(const std::string& name);
    std::string_view rest() const { return text_.substr(position_); }  ///< after the last tag
    std::size_t position() const { return position_; }                 ///< after the last tag
    std::size_t tag_begin() const { return tag_begin_; }               ///< of the last tag
    /// @throws InputError `NAME: byte N: what`.
    [[noreturn]] void fail(const std::string& what) const;

private:
    std::size_t end_of_tag(std::size_t position) const;
    void read_attributes(std::string_view inside, Tag& tag) const;
    std::string_view text_;
    std::string name_;
    std::size_t position_ = 0, tag_begin_ = 0;
};

}  // namespace strake
