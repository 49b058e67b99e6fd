#include "report/report_page.hpp"

#include <string_view>

#ifdef STRAKE_PAGE_SCRIPT
// The bundle that CMake built, byte for byte.
__asm__(
    ".section .rodata\n"
    "strake_page_script: .incbin \"" STRAKE_PAGE_SCRIPT
    "\"\nstrake_page_script_end: .byte 0\n"
    "strake_page_style: .incbin \"" STRAKE_PAGE_STYLE
    "\"\nstrake_page_style_end: .byte 0\n"
    ".text\n");
extern "C" const char strake_page_script[], strake_page_script_end[], strake_page_style[], strake_page_style_end[];
#endif

namespace strake {
namespace {

#ifdef STRAKE_PAGE_SCRIPT
std::string_view script() {
    return {strake_page_script, static_cast<std::size_t>(strake_page_script_end - strake_page_script)};
}
std::string_view style() {
    return {strake_page_style, static_cast<std::size_t>(strake_page_style_end - strake_page_style)};
}
#else
std::string_view script() { return {}; }
std::string_view style() { return {}; }
#endif

}  // namespace

bool has_report_page() { return !script().empty(); }

std::string report_page_missing() {
    return "this program was built without the report page, because node and npm, or npm's packages, were missing. "
           "Install them (scripts/setup.sh run), configure again (cmake -U 'STRAKE_PAGE*' …) and rebuild";
}

std::string page::html_escaped(const std::string& words) {
    std::string out;
    for (const char c : words)
        if (c == '&')
            out += "&amp;";
        else if (c == '<')
            out += "&lt;";
        else if (c == '>')
            out += "&gt;";
        else if (c == '"')
            out += "&quot;";
        else
            out += c;
    return out;
}

std::string page::html(const std::string& title, const Json& data, const Blobs& blobs) {
    std::string json = data.dump(-1, ' ', false, Json::error_handler_t::replace), safe;
    for (const char c : json)  // no "</script>" or "<!--" inside the element
        if (c == '<')
            safe += "\\u003c";
        else
            safe += c;
    std::string out =
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        // Nothing is fetched, whatever the page contains.
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
        "style-src 'unsafe-inline'; img-src data: blob:; font-src data:\">\n<title>";
    out += html_escaped(title) + " · Strake</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>";
    out += style();
    out +=
        "</style>\n</head>\n<body>\n<noscript>This report needs JavaScript.</noscript>\n<main id=\"report\"></main>\n";
    for (const auto& [name, packed] : blobs)
        out += "<script type=\"text/plain\" id=\"blob-" + html_escaped(name) + "\">" + packed + "</script>\n";
    out += "<script type=\"application/json\" id=\"data\">" + safe + "</script>\n<script>";
    out += script();
    return out + "</script>\n</body>\n</html>\n";
}

}  // namespace strake
