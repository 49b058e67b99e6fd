#include "studio/studio_page.hpp"

#include <cstddef>

#ifdef STRAKE_PAGE_SCRIPT
// The bundle that CMake built, byte for byte.
__asm__(
    ".section .rodata\n"
    "strake_studio_script: .incbin \"" STRAKE_PAGE_SCRIPT
    "\"\nstrake_studio_script_end: .byte 0\n"
    "strake_studio_style: .incbin \"" STRAKE_PAGE_STYLE
    "\"\nstrake_studio_style_end: .byte 0\n"
    ".text\n");
extern "C" const char strake_studio_script[], strake_studio_script_end[], strake_studio_style[],
    strake_studio_style_end[];
#endif

namespace strake {

#ifdef STRAKE_PAGE_SCRIPT
std::string_view studio_script() {
    return {strake_studio_script, static_cast<std::size_t>(strake_studio_script_end - strake_studio_script)};
}
std::string_view studio_style() {
    return {strake_studio_style, static_cast<std::size_t>(strake_studio_style_end - strake_studio_style)};
}
#else
std::string_view studio_script() { return {}; }
std::string_view studio_style() { return {}; }
#endif

bool has_studio_page() { return !studio_script().empty(); }

std::string_view studio_html() {
    return "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Strake studio</title>\n"
           "<link rel=\"icon\" href=\"data:,\">\n<link rel=\"stylesheet\" href=\"studio.css\">\n</head>\n<body>\n"
           "<noscript>The studio needs JavaScript.</noscript>\n<main id=\"studio\"></main>\n"
           "<script src=\"studio.js\"></script>\n</body>\n</html>\n";
}

}  // namespace strake
