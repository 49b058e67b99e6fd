#include "cli/outputs.hpp"

#include "core/error.hpp"
#include "core/text/file.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

namespace strake::cli {
namespace {

namespace fs = std::filesystem;

bool is_same(const fs::path& a, const fs::path& b) {
    std::error_code failed;
    if (fs::equivalent(a, b, failed) && !failed) return true;
    const fs::path one = fs::weakly_canonical(a, failed), other = fs::weakly_canonical(b, failed);
    return !failed && one == other;
}

}  // namespace

void check_outputs(const std::vector<fs::path>& outputs, const std::vector<fs::path>& inputs) {
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        if (outputs[i].empty()) continue;
        for (const fs::path& input : inputs)
            if (is_same(outputs[i], input))
                throw InvalidInput(text(outputs[i].string(), ": would overwrite an input; choose another output"));
        for (std::size_t j = 0; j < i; ++j)
            if (!outputs[j].empty() && is_same(outputs[i], outputs[j]))
                throw InvalidInput(text(outputs[i].string(), ": two outputs have the same name"));
    }
}

void write_output(const fs::path& out, const TriMesh& surface, SurfaceFormat like) {
    SurfaceFormat format = format_of(out);
    const bool is_text = like == SurfaceFormat::stl_ascii || like == SurfaceFormat::ply_ascii;
    if (is_text && extension_of(like) == extension_of(format)) format = like;
    write_surface(out, surface, format);
    if (!surface.group.empty() && !keeps_parts(format))
        fmt::print(stderr, "strake: note: {}: this format has no part names; the names of {} part(s) are lost\n",
                   printable(out.native()), surface.group_names.size());
}

bool is_lost_output(const std::exception_ptr& thrown) {
    try {
        std::rethrow_exception(thrown);
    } catch (const fs::filesystem_error&) {
        return false;
    } catch (const std::system_error&) {  // what fmt throws
        return std::ferror(stdout) != 0;
    } catch (...) {
        return false;
    }
}

std::string lost_output() {
    errno = 0;
    if (std::fflush(stdout) == 0) {
        if (std::ferror(stdout) == 0) return "";
        [[maybe_unused]] const ssize_t tried =
            ::write(STDOUT_FILENO, "\n", 1);  // for errno: the first failure's is lost
    }
    return text("strake: standard output: cannot write", errno != 0 ? text(": ", std::strerror(errno)) : "",
                "; the printed output is lost, files are not");
}

}  // namespace strake::cli
