#include "core/text/csv_columns.hpp"

#include <algorithm>

namespace strake {

void split_csv(std::string_view line, std::vector<std::string_view>& fields, std::size_t max_fields) {
    fields.clear();
    for (std::size_t begin = 0; begin <= line.size() && fields.size() <= max_fields;) {
        const std::size_t comma = std::min(line.find(',', begin), line.size());
        fields.push_back(line.substr(begin, comma - begin));
        begin = comma + 1;
    }
}

std::vector<std::string_view> csv_fields(std::string_view line, std::size_t max_fields) {
    std::vector<std::string_view> fields;
    split_csv(line, fields, max_fields);
    return fields;
}

std::string column_name(std::string_view field) {
    std::string out;
    for (const char c : field)
        if (c != '"' && c != ' ' && c != '\t' && c != '\r')
            out += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return out;
}

int column_named(const std::vector<std::string_view>& header, const std::string& name) {
    for (std::size_t i = 0; i < header.size(); ++i)
        if (column_name(header[i]) == name) return static_cast<int>(i);
    return -1;
}

int column_of_number(const std::vector<std::string_view>& header) {
    for (const char* name : {"pointid", "index", "point_id", "globalindex"})
        if (const int column = column_named(header, name); column >= 0) return column;
    return -1;
}

}  // namespace strake
