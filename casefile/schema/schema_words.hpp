#pragma once
#include "casefile/schema/schema.hpp"

/// A row of the table in words, for docs/cases.md and `strake explain`.
namespace strake {

std::string type_name(Type type);          ///< "length", "true or false", ...
std::string shape_of(const Key& key);      ///< type, legal words, count of a list
std::string limits_of(const Key& key);     ///< "> 0", "[0, 100%)"; empty: none
std::string default_of(const Key& key);    ///< "required", the default, or nothing
std::string condition_of(const Key& key);  ///< " Only with ...": Key::when; empty: none

}  // namespace strake
