#include "core/text/xml_scanner.hpp"

#include "core/error.hpp"
#include "core/text/file.hpp"

namespace strake {
namespace {

constexpr std::string_view blanks = " \t\r\n";

std::string unescaped(std::string_view words) {
    std::string out;
    while (!words.empty()) {
        bool found = false;
        for (const auto& [entity, c] :
             {std::pair{"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}})
            if (!found && words.starts_with(entity)) {
                out += c;
                words.remove_prefix(std::string_view(entity).size());
                found = true;
            }
        if (!found) {
            out += words[0];
            words.remove_prefix(1);
        }
    }
    return out;
}

}  // namespace

void XmlScanner::fail(const std::string& what) const {
    throw InputError(text(name_, ": byte ", position_, ": ", what));
}

std::string_view XmlScanner::own_text(const std::string& name) {
    const std::size_t end = text_.find("</" + name, position_), close = text_.find('>', std::min(end, text_.size()));
    if (close == std::string_view::npos) fail(text("no </", name, ">"));
    const std::string_view inside = text_.substr(position_, end - position_);
    position_ = close + 1;
    // VTK writes metadata (InformationKey) before or after the values.
    const std::string_view ahead = inside.substr(0, inside.find('<'));
    if (ahead.find_first_not_of(blanks) != std::string_view::npos) return ahead;
    return inside.substr(inside.rfind('>') + 1);
}

XmlScanner::Tag XmlScanner::next() {
    while (true) {
        const std::size_t begin = text_.find('<', position_);
        if (begin == std::string_view::npos) return {};
        position_ = begin;
        const bool is_comment = text_.substr(begin).starts_with("<!--");
        const std::string_view close = is_comment ? "-->" : ">";
        const std::size_t end = is_comment ? text_.find(close, begin + 4) : end_of_tag(begin + 1);
        if (end == std::string_view::npos) fail("a tag without its end");
        std::string_view inside = text_.substr(begin + 1, end - begin - 1);
        if (is_comment || inside.starts_with('?') || inside.starts_with('!')) {
            position_ = end + close.size();
            continue;
        }
        tag_begin_ = begin;
        Tag tag;
        tag.is_empty = inside.ends_with('/');
        if (tag.is_empty) inside.remove_suffix(1);
        const std::size_t name_end = std::min(inside.find_first_of(blanks), inside.size());
        tag.name = inside.substr(0, name_end);
        if (tag.name.empty()) fail("a tag without a name");
        read_attributes(inside.substr(name_end), tag);
        position_ = end + 1;
        return tag;
    }
}

/// The first unquoted '>' after `position`.
std::size_t XmlScanner::end_of_tag(std::size_t position) const {
    while ((position = text_.find_first_of("\"'>", position)) != std::string_view::npos && text_[position] != '>') {
        const std::size_t close = text_.find(text_[position], position + 1);
        if (close == std::string_view::npos) fail("a value in quotes without its end");
        position = close + 1;
    }
    return position;
}

void XmlScanner::read_attributes(std::string_view inside, Tag& tag) const {
    while (true) {
        const std::size_t begin = inside.find_first_not_of(blanks);
        if (begin == std::string_view::npos) return;
        const std::size_t equals = inside.find('=', begin);
        const std::size_t open =
            equals == std::string_view::npos ? equals : inside.find_first_not_of(blanks, equals + 1);
        if (open == std::string_view::npos || (inside[open] != '"' && inside[open] != '\''))
            fail(text("an attribute of <", printable(tag.name, 60), "> without its value"));
        const std::size_t close = inside.find(inside[open], open + 1);
        if (close == std::string_view::npos)
            fail(text("an attribute of <", printable(tag.name, 60), "> without its end"));
        std::string_view key = inside.substr(begin, equals - begin);
        key = key.substr(0, key.find_last_not_of(blanks) + 1);
        tag.attributes[std::string(key)] = unescaped(inside.substr(open + 1, close - open - 1));
        inside.remove_prefix(close + 1);
    }
}

}  // namespace strake
