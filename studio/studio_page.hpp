#pragma once
#include <string_view>

/// The page of `strake studio`, bundled when Strake was built.
namespace strake {

bool has_studio_page();
std::string_view studio_html();  ///< refers to studio.js and studio.css beside it
std::string_view studio_script();
std::string_view studio_style();

}  // namespace strake
