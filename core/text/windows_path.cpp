#include "core/text/windows_path.hpp"

#include "core/error.hpp"
#include "core/text/file.hpp"

#include <algorithm>

namespace strake {
namespace {

bool is_drive_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// `\\wsl$\Debian\home` and `\\wsl.localhost\Debian\home` are /home of that distribution: what follows the third slash.
std::string inside_wsl(const std::string& path) {
    for (const char* share : {"//wsl$/", "//wsl.localhost/"}) {
        if (!path.starts_with(share)) continue;
        const std::size_t at = path.find('/', std::string(share).size());
        return at == std::string::npos ? "/" : path.substr(at);
    }
    return "";
}

}  // namespace

std::string windows_path_hint(const std::string& path) {
    const bool is_on_drive =
        path.size() > 2 && is_drive_letter(path[0]) && path[1] == ':' && (path[2] == '\\' || path[2] == '/');
    if (!is_on_drive && path.find('\\') == std::string::npos) return "";
    std::string here = path;
    std::replace(here.begin(), here.end(), '\\', '/');
    if (is_on_drive) {
        const char drive = here[0] >= 'a' ? here[0] : static_cast<char>(here[0] - 'A' + 'a');
        return text("; in WSL this path of Windows is ", printable(text("/mnt/", drive, here.substr(2)), 400));
    }
    const std::string inside = inside_wsl(here);
    return text("; in Linux folders are separated by '/': ", printable(inside.empty() ? here : inside, 400));
}

}  // namespace strake
