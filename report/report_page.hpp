#pragma once
#include "report/report_parts.hpp"

namespace strake::page {

/// The page with its data in it. Whatever stands in the data stays text: it cannot end the element that holds it.
std::string html(const std::string& title, const Json& data, const Blobs& blobs);

/// Text between tags and in attributes.
std::string html_escaped(const std::string& words);

}  // namespace strake::page
