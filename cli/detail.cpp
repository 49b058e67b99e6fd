#include "cli/detail.hpp"

#include "casefile/yaml/diagnostics.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/geometry.hpp"
#include "core/parallel.hpp"
#include "core/text/file.hpp"
#include "core/version.hpp"

#include <cxxabi.h>
#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>
#include <Eigen/Core>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <utility>

namespace strake::cli {
namespace {

struct State {
    bool more = false, debug = false, has_begun = false;
    std::string step;
    std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
};
State& state() {
    static State only;
    return only;
}

double seconds_since_start() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - state().begin).count();
}

std::string program_words() {
    return fmt::format("strake {} (gcc {}, Eigen {}.{}.{}), threads: {}", version(), __VERSION__, EIGEN_WORLD_VERSION,
                       EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION, num_threads());
}

std::string machine_words() {
    struct utsname system {};
    ::uname(&system);
    const double memory = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
    return fmt::format("{} {} {}, {} processors, {:.3g} GB", system.sysname, system.release, system.machine,
                       ::sysconf(_SC_NPROCESSORS_ONLN), memory / 1e9);
}

/// The command line after the shell's parsing: each argument in brackets.
std::string arguments_words() {
    std::ifstream file("/proc/self/cmdline", std::ios::binary);
    std::string all, argument;
    while (std::getline(file, argument, '\0') && all.size() < 4000)
        all += (all.empty() ? "[" : " [") + printable(argument, 400) + "]";
    std::error_code ignored;
    return all + ", in " + printable(std::filesystem::current_path(ignored).string(), 400);
}

std::string cost_words() {
    struct rusage used {};
    ::getrusage(RUSAGE_SELF, &used);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return fmt::format("{:.2f} s, {:.2f} s of CPU time, at most {:.0f} MB", seconds_since_start(),
                       seconds(used.ru_utime) + seconds(used.ru_stime), static_cast<double>(used.ru_maxrss) / 1024);
}

/// Escapes bytes that are not text; file names may contain them.
std::string harmless(const std::string& words) { return printable(std::string_view(words), 4000); }

void print_detail(const std::string& words) {
    fmt::print(stderr, "strake: {:8.2f} s  {}\n", seconds_since_start(), harmless(words));
}

std::string type_of(const std::exception& e) {
    int status = 0;
    char* name = abi::__cxa_demangle(typeid(e).name(), nullptr, nullptr, &status);
    const std::string words = status == 0 && name ? name : typeid(e).name();
    std::free(name);
    return words;
}

/// The error's type and message, then those of its cause, and so on.
void add_types(const std::exception_ptr& thrown, std::string& out) {
    try {
        std::rethrow_exception(thrown);
    } catch (const std::exception& e) {
        out += fmt::format("debug: thrown       {}: {}\n", type_of(e), harmless(e.what()));
        try {
            std::rethrow_if_nested(e);
        } catch (...) {
            add_types(std::current_exception(), out);
        }
    } catch (const ExitStatus& end) {
        out += fmt::format("debug: thrown       end with status {}\n", end.status);
    } catch (...) {
        out += "debug: thrown       something that is not an exception of the library\n";
    }
}

}  // namespace

void add_threads_option(CLI::App& app) {
    for (const char* name : {"deform", "run", "fit", "sample", "resume", "step", "sweep", "gradient-check"})
        app.get_subcommand(name)
            ->add_option_function<int>(
                "--threads", &set_num_threads,
                "threads of the solver (default: STRAKE_NUM_THREADS, otherwise at most 2); the result is the same")
            ->check(CLI::Range(1, max_threads));
}

void add_detail_options(CLI::App& app) {
    for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) {
        command->add_flag("-v,--verbose", state().more, "print steps, times and memory on standard error");
        command->add_flag("--debug", state().debug,
                          "print details of an error: its type, the last step, versions, machine");
    }
}

bool wants_detail() { return state().more; }

void log_step(const std::string& words) {
    state().step = words;
    if (!state().more) return;
    if (!std::exchange(state().has_begun, true)) {
        print_detail(program_words());
        print_detail(machine_words());
        print_detail(arguments_words());
    }
    print_detail(words);
}

void log_end(int status) {
    if (!state().more) return;
    log_step(fmt::format("ends with status {}: {}", status, cost_words()));
}

std::string debug_words(const std::exception_ptr& thrown) {
    if (!state().debug) return "";
    std::string out;
    if (thrown) add_types(thrown, out);
    return out + fmt::format(
                     "debug: last step    {}\ndebug: program      {}\ndebug: machine      {}\n"
                     "debug: command line {}\ndebug: cost         {}",
                     state().step.empty() ? "none" : harmless(state().step), program_words(), machine_words(),
                     harmless(arguments_words()), cost_words());
}

SurfaceFile read_logged(const std::filesystem::path& file) {
    const std::string name = printable(file.string(), 400);
    log_step("reading " + name);
    SurfaceFile read = read_surface(file);
    check_coordinates(file, read.mesh);
    log_step(fmt::format("{}: {} vertices, {} triangles", name, read.mesh.num_vertices(), read.mesh.num_triangles()));
    return read;
}

void check_area(const std::filesystem::path& file, const TriMesh& surface) {
    const double area = surface_area(surface);
    if (!(area > 0 && std::isfinite(area)))
        throw InputError(fmt::format("{}: {} triangles of total area {}", printable(file.string(), 400),
                                     surface.num_triangles(), area));
}

}  // namespace strake::cli
