#pragma once
#include "report/report_parts.hpp"

namespace strake::page {

/// The page with its data. The data stay text whatever they contain: they cannot end the element that holds them.
std::string html(const std::string& title, const Json& data, const Blobs& blobs);

/// Escapes text for use between tags and in attributes.
std::string html_escaped(const std::string& words);

}  // namespace strake::page
