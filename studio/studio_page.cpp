#include "studio/studio_page.hpp"

#include "viewer/embedded_page.hpp"

STRAKE_EMBEDDED_PAGE(strake_studio)

namespace strake {

std::string_view studio_script() { return page_script(); }
std::string_view studio_style() { return page_style(); }
bool has_studio_page() { return !studio_script().empty(); }

std::string_view studio_html() {
    return "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Strake studio</title>\n"
           "<link rel=\"icon\" href=\"data:,\">\n<link rel=\"stylesheet\" href=\"studio.css\">\n</head>\n<body>\n"
           "<noscript>The studio needs JavaScript.</noscript>\n<main id=\"studio\"></main>\n"
           "<script src=\"studio.js\"></script>\n</body>\n</html>\n";
}

}  // namespace strake
