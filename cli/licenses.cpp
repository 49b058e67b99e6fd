#include "cli/commands.hpp"
#include "core/version.hpp"

#include <fmt/format.h>
#include <array>

/// `strake --licenses`: what this binary contains, and under which terms it may be passed on.
namespace strake::cli {
namespace {

struct Part {
    const char* name;
    const char* license;
};
/// Linked or compiled in; docs/dependencies.md has the reasons.
constexpr std::array parts{
    Part{"Strake", "Apache-2.0"},
    Part{"Eigen", "MPL-2.0"},
    Part{"CGAL (exact predicates)", "LGPL-3.0-or-later"},
    Part{"GMP, MPFR, by CGAL", "LGPL-3.0-or-later"},
    Part{"METIS", "Apache-2.0"},
    Part{"OpenBLAS", "BSD-3-Clause"},
    Part{"NLopt", "MIT, LGPL-2.1-or-later"},
    Part{"yaml-cpp", "MIT"},
    Part{"CLI11", "BSD-3-Clause"},
    Part{"fmt", "MIT"},
    Part{"nlohmann-json", "MIT"},
    Part{"Embree", "Apache-2.0"},
    Part{"oneTBB, by Embree", "Apache-2.0"},
    Part{"SQLite", "blessing (public domain)"},
    Part{"zlib", "Zlib"},
    Part{"three.js, uPlot, CodeMirror (report and studio)", "MIT"},
    Part{"cpp-httplib", "MIT"},
    Part{"OpenSSL, by cpp-httplib", "Apache-2.0"},
    Part{"Brotli, by cpp-httplib", "MIT"},
    Part{"runtime libraries of GCC", "GPL-3.0-or-later WITH GCC-exception-3.1"},
};
#if STRAKE_GPL
constexpr std::array more_parts{
    Part{"Ceres", "BSD-3-Clause"},
    Part{"glog, gflags, by Ceres", "BSD-3-Clause"},
    Part{"CHOLMOD (core, Cholesky, Partition)", "LGPL-2.1-or-later"},
    Part{"CHOLMOD (Supernodal, Modify)", "GPL-2.0-or-later"},
    Part{"SPQR, by Ceres", "GPL-2.0-or-later"},
    Part{"CXSparse, by Ceres", "LGPL-2.1-or-later"},
    Part{"AMD, CAMD, COLAMD, CCOLAMD, by CHOLMOD", "BSD-3-Clause"},
    Part{"libunwind, by glog", "MIT"},
    Part{"liblzma, by libunwind", "public domain"},
    Part{"CGAL alpha wrap", "GPL-3.0-or-later"},
};
constexpr const char* terms =
    "This binary contains parts under the GPL: it may be passed on under the terms of the GPL, version 3. A build with "
    "-DSTRAKE_GPL=OFF contains none.";
#else
constexpr std::array<Part, 0> more_parts{};
constexpr const char* terms =
    "This binary contains no part under the GPL. Parts under the LGPL: their terms hold for them.";
#endif

std::string licenses() {
    std::string out = fmt::format("strake {} contains or links\n\n", version());
    for (const Part& part : parts) out += fmt::format("  {:<38} {}\n", part.name, part.license);
    for (const Part& part : more_parts) out += fmt::format("  {:<38} {}\n", part.name, part.license);
    return out + fmt::format("\nThe source of Strake is under the Apache License, version 2.0. {}\n", terms);
}

}  // namespace

void add_licenses(CLI::App& app) {
    app.add_flag_callback(
        "--licenses",
        [] {
            fmt::print("{}", licenses());
            throw CLI::Success();
        },
        "Print what this binary contains, and the terms under which it may be passed on");
}

}  // namespace strake::cli
