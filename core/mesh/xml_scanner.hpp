#pragma once
#include <map>
#include <string>
#include <string_view>

namespace strake {

/// Tags of an XML text one after the other: as much of XML as VTK's files use (no entities beyond the five, no CDATA).
class XmlScanner {
public:
    struct Tag {
        std::string name;                               ///< "/name" at its end; empty: no further tag
        std::map<std::string, std::string> attributes;  ///< by name
        bool is_empty = false;                          ///< <name/>
        std::string value(const std::string& key, const std::string& fallback = "") const {
            const auto at = attributes.find(key);
            return at == attributes.end() ? fallback : at->second;
        }
    };
    /// `name` of the file for messages; `text` outlives the scanner.
    XmlScanner(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

    Tag next();  ///< skips text, comments and declarations. @throws InputError
    /// The text in the element whose tag was the last, before the elements in it or else behind them; then behind its
    /// end.
    std::string_view own_text(const std::string& name);
    std::string_view rest() const { return text_.substr(position_); }  ///< behind the last tag
    std::size_t position() const { return position_; }                 ///< behind the last tag
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
