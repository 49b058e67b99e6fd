#pragma once
#include <string>
#include <vector>

/// Changes of a case file as text, which keep its comments and its order.
namespace strake {

struct RegionText {
    std::string name, value;  ///< "plane: {normal: [0, 1, 0], at: 0.3}, side: below" without braces, or a formula
    bool is_formula = false;
};

/// "name: {plane: ...}" or "name: wing + body", as it stands in a case.
std::string region_line(const RegionText& region);

/// With this region in the block `regions:`, replacing one of the same name.
/// @throws InvalidInput where the block is written in a way that cannot be changed line by line; says how it can.
std::string with_region(const std::string& yaml, const RegionText& region);
/// With the name in the list `fixed:`, if it is not there.
std::string with_fixed(const std::string& yaml, const std::string& name);
/// The top-level block of that key, its line included; empty: there is none.
std::string block_of(const std::string& yaml, const std::string& key);

}  // namespace strake
