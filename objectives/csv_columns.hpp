#pragma once
#include <string>
#include <string_view>
#include <vector>

/// Lines of comma-separated columns.
namespace strake {

/// At most `most` + 1 of them.
std::vector<std::string_view> csv_fields(std::string_view line, std::size_t most = 200);
/// The same into a vector that serves for many lines.
void split_csv(std::string_view line, std::vector<std::string_view>& fields, std::size_t most = 200);
/// A column's name as it is compared: without quotes and blanks, in small letters.
std::string column_name(std::string_view field);
/// Number of the column of that name, -1 where there is none.
int column_named(const std::vector<std::string_view>& header, const std::string& name);
/// That of the point's number: PointID (SU2), index, point_id, GlobalIndex; -1.
int column_of_number(const std::vector<std::string_view>& header);

}  // namespace strake
