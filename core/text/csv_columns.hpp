#pragma once
#include <string>
#include <string_view>
#include <vector>

/// Lines of comma-separated columns.
namespace strake {

/// At most `max_fields` + 1 fields.
std::vector<std::string_view> csv_fields(std::string_view line, std::size_t max_fields = 200);
/// The same into a vector reused for many lines.
void split_csv(std::string_view line, std::vector<std::string_view>& fields, std::size_t max_fields = 200);
/// A column's name for comparison: without quotes and blanks, in lower case.
std::string column_name(std::string_view field);
/// Number of the column of that name; -1: none.
int column_named(const std::vector<std::string_view>& header, const std::string& name);
/// Number of the column of point numbers: PointID (SU2), index, point_id, GlobalIndex; -1: none.
int column_of_number(const std::vector<std::string_view>& header);

}  // namespace strake
