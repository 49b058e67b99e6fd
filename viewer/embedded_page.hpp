#pragma once
#include <string>
#include <string_view>

/// A page in the program, byte for byte as CMake has bundled it (viewer/page/bundle.cmake).
namespace strake {

/// What a program without the page says. @param what "the report page"
inline std::string page_missing(std::string_view what) {
    return "this program was built without " + std::string(what) +
           ", because node and npm, or npm's packages, were missing. Install them (scripts/setup.sh run), configure "
           "again (cmake -U 'STRAKE_PAGE*' …) and rebuild";
}

}  // namespace strake

/// Defines page_script() and page_style() of one source: its bundle, empty where there is none.
#ifdef STRAKE_PAGE_SCRIPT
#define STRAKE_EMBEDDED_PAGE(name)                                                                  \
    __asm__(".section .rodata\n" #name "_script: .incbin \"" STRAKE_PAGE_SCRIPT "\"\n" #name        \
            "_script_end: .byte 0\n" #name "_style: .incbin \"" STRAKE_PAGE_STYLE "\"\n" #name      \
            "_style_end: .byte 0\n.text\n");                                                        \
    extern "C" const char name##_script[], name##_script_end[], name##_style[], name##_style_end[]; \
    static std::string_view page_script() { return {name##_script, name##_script_end}; }            \
    static std::string_view page_style() { return {name##_style, name##_style_end}; }
#else
#define STRAKE_EMBEDDED_PAGE(name)                       \
    static std::string_view page_script() { return {}; } \
    static std::string_view page_style() { return {}; }
#endif
