#include "report/report_page.hpp"

#include "viewer/embedded_page.hpp"

STRAKE_EMBEDDED_PAGE(strake_page)

namespace strake {

bool has_report_page() { return !page_script().empty(); }

std::string report_page_missing() { return page_missing("the report page"); }

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
    out += page_style();
    out +=
        "</style>\n</head>\n<body>\n<noscript>This report needs JavaScript.</noscript>\n<main id=\"report\"></main>\n";
    for (const auto& [name, packed] : blobs)
        out += "<script type=\"text/plain\" id=\"blob-" + html_escaped(name) + "\">" + packed + "</script>\n";
    out += "<script type=\"application/json\" id=\"data\">" + safe + "</script>\n<script>";
    out += page_script();
    return out + "</script>\n</body>\n</html>\n";
}

}  // namespace strake
