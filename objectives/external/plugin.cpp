#include "objectives/external/plugin.hpp"

#include "core/error.hpp"
#include "core/floating_point_mode.hpp"
#include "core/text/file.hpp"
#include "objectives/external/running_plugin.hpp"
#include "objectives/external/shared_library.hpp"
#include "objectives/quantity/finite.hpp"
#include "strake/plugin.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>

namespace strake {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// What plug-in code is being run, for a handler of exit(): the only state that it can reach.
std::atomic<const char*> running{nullptr};

struct Running {
    std::string words;
    const char* before;
    explicit Running(std::string what) : words(std::move(what)), before(running.exchange(words.c_str())) {}
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;
    ~Running() { running = before; }
};

/// A plug-in that changes the working directory would redirect what others open by relative names.
struct KeepWorkingDirectory {
    int fd = ::open(".", O_PATH | O_DIRECTORY | O_CLOEXEC);
    KeepWorkingDirectory() = default;
    KeepWorkingDirectory(const KeepWorkingDirectory&) = delete;
    KeepWorkingDirectory& operator=(const KeepWorkingDirectory&) = delete;
    ~KeepWorkingDirectory() {
        if (fd < 0) return;
        [[maybe_unused]] const int tried = ::fchdir(fd);
        ::close(fd);
    }
};

using ErrorText = std::array<char, 2048>;
std::string words(ErrorText& error) {
    error.back() = '\0';
    return error[0] == '\0' ? "gives no reason" : printable(error.data());
}

/// A loaded library with its state. Never unloaded: its threads and destructors may outlive us.
class Library {
public:
    explicit Library(const PluginLibrary& plugin)
        : shown_(text(plugin.name, ": ", printable(plugin.library.string()))) {
        const KeepFloatingPointMode keep;  // loading a library built with -ffast-math disables subnormal numbers
        const KeepWorkingDirectory stay;
        const Running now(shown_);
        const std::string file = std::filesystem::absolute(plugin.library).string();  // else PATH-like search
        if (const std::string cut = cut_short(file); !cut.empty()) refuse(cut);
        handle_ = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
        if (!handle_) refuse("cannot be loaded: ", printable(::dlerror()));
        const auto abi = symbol<decltype(&strake_plugin_abi)>("strake_plugin_abi", true);
        evaluate_ = symbol<decltype(evaluate_)>("strake_plugin_evaluate", true);
        close_ = symbol<decltype(close_)>("strake_plugin_close", false);
        const std::uint32_t version = abi();
        if (version != STRAKE_PLUGIN_ABI)
            refuse("was built for version ", version, " of plugin.h, this Strake needs ", STRAKE_PLUGIN_ABI,
                   "; compile it again with include/strake/plugin.h");
        const auto open = symbol<decltype(&strake_plugin_open)>("strake_plugin_open", false);
        if (open) begin(open, plugin.options);
    }
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;
    ~Library() {
        if (close_) close_(state_);
    }

    std::optional<Failure> evaluate(const strake_plugin_request& request, strake_plugin_result& result) {
        const std::lock_guard one_at_a_time(mutex_);
        const KeepFloatingPointMode keep;
        const KeepWorkingDirectory stay;
        const Running now(text(shown_, ", evaluation ", request.evaluation));
        ErrorText error{};
        result.error = error.data();
        result.error_size = error.size();
        try {
            if (evaluate_(state_, &request, &result) != 0)
                return Failure{"plugin", text(shown_, ", evaluation ", request.evaluation, ": ", words(error))};
        } catch (const std::exception& e) {
            return Failure{"exception", text(shown_, ": threw ", printable(e.what()))};
        } catch (...) {
            return Failure{"exception", text(shown_, ": threw an unknown exception")};
        }
        return {};
    }

private:
    void begin(decltype(&strake_plugin_open) open, const std::string& options) {
        ErrorText error{};
        std::string why;
        try {
            if (open(options.c_str(), &state_, error.data(), error.size()) == 0) return;
            why = words(error);
        } catch (const std::exception& e) {
            why = text("strake_plugin_open threw ", printable(e.what()));
        } catch (...) {
            why = "strake_plugin_open threw an unknown exception";
        }
        close_ = nullptr;
        refuse("failed to open: ", why);
    }
    template <class... Parts>
    [[noreturn]] void refuse(const Parts&... parts) const {
        throw InvalidInput(text(shown_, " ", parts...));
    }
    template <class Function>
    Function symbol(const char* name, bool required) const {
        auto* found = reinterpret_cast<Function>(::dlsym(handle_, name));
        if (!found && required)
            refuse("has no function ", name, "; is it a plug-in, and in C++ inside of extern \"C\"?");
        return found;
    }

    std::string shown_;
    void* handle_ = nullptr;
    void* state_ = nullptr;
    decltype(&strake_plugin_evaluate) evaluate_ = nullptr;
    decltype(&strake_plugin_close) close_ = nullptr;
    std::mutex mutex_;
};

std::vector<const char*> pointers(const std::vector<std::string>& names) {
    std::vector<const char*> out;
    for (const std::string& name : names) out.push_back(name.c_str());
    return out;
}

/// Buffers of one evaluation.
struct Answer {
    std::vector<double> values, gradients, by_variable;
};

std::string shown(double x) { return std::isnan(x) ? "NaN" : text(x); }  // of either sign

/// Description of the first value that is not finite; "" if all are.
std::string not_finite(const Answer& a, const PluginLibrary& plugin, const std::vector<std::string>& values,
                       const QuantityRequest& request) {
    const std::size_t n = 3 * static_cast<std::size_t>(request.surface.num_vertices());
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!std::isfinite(a.values[i])) return text("the value ", values[i], " = ", shown(a.values[i]));
        if (a.gradients.empty()) continue;
        for (std::size_t k = 0; k < n; ++k)
            if (!std::isfinite(a.gradients[i * n + k]))
                return text("d ", values[i], " / d vertex ", k / 3, " = ", shown(a.gradients[i * n + k]));
        for (std::size_t j = 0; j < request.parameters.size(); ++j) {
            const double derivative = a.by_variable[i * request.parameters.size() + j];
            const auto& names = plugin.depends_on;
            const bool matters =
                !names || std::find(names->begin(), names->end(), request.parameters[j].first) != names->end();
            const bool may_lack = plugin.may_lack_derivatives && std::isnan(derivative);
            if (matters && !may_lack && !std::isfinite(derivative))
                return text("d ", values[i], " / d ", request.parameters[j].first, " = ", shown(derivative));
        }
    }
    return "";
}

QuantityResult evaluate(Library& library, const PluginLibrary& plugin, const QuantityRequest& request) {
    if (auto failure = vertices_finite(plugin.name, request.surface)) return {{}, {}, failure};
    const std::vector<std::string> values = plugin.outputs.empty() ? std::vector<std::string>{"value"} : plugin.outputs;
    const std::vector<const char*> value_names = pointers(values);
    std::vector<const char*> variable_names;
    std::vector<double> variables;
    for (const auto& [name, value] : request.parameters)
        variable_names.push_back(name.c_str()), variables.push_back(value);
    const bool gradients = request.want_sensitivities && plugin.has_gradients;
    const std::size_t n = static_cast<std::size_t>(request.surface.num_vertices());
    Answer a{std::vector<double>(values.size(), nan), std::vector<double>(gradients ? values.size() * n * 3 : 0, nan),
             std::vector<double>(gradients ? values.size() * variables.size() : 0, nan)};
    const strake_plugin_request asked{sizeof asked,
                                      request.evaluation,
                                      request.level,
                                      n,
                                      request.surface.vertices.data(),
                                      static_cast<std::size_t>(request.surface.num_triangles()),
                                      request.surface.triangles.data(),
                                      variables.size(),
                                      variable_names.data(),
                                      variables.data(),
                                      values.size(),
                                      value_names.data(),
                                      gradients ? 1 : 0};
    strake_plugin_result result{sizeof result,
                                a.values.data(),
                                gradients ? a.gradients.data() : nullptr,
                                gradients ? a.by_variable.data() : nullptr,
                                nullptr,
                                0};
    if (auto failure = library.evaluate(asked, result)) return {{}, {}, failure};
    if (const std::string what = not_finite(a, plugin, values, request); !what.empty())
        return {{}, {}, Failure{"not_finite", text(plugin.name, ": the plug-in gave ", what)}};
    QuantityResult found;
    found.values = a.values;
    for (std::size_t i = 0; gradients && i < values.size(); ++i) {
        found.dJ_dv.push_back(
            Eigen::Map<const Points>(a.gradients.data() + i * n * 3, static_cast<Eigen::Index>(n), 3));
        Eigen::VectorXd& down = found.dJ_dp.emplace_back(Eigen::VectorXd::Zero(static_cast<int>(variables.size())));
        for (std::size_t j = 0; j < variables.size(); ++j) {
            const auto& names = plugin.depends_on;
            if (!names || std::find(names->begin(), names->end(), request.parameters[j].first) != names->end())
                down[static_cast<int>(j)] = a.by_variable[i * variables.size() + j];
        }
    }
    return found;
}

}  // namespace

const char* running_plugin() { return running; }

Quantity plugin(const PluginLibrary& wanted) {
    const auto library = std::make_shared<Library>(wanted);
    Quantity quantity;
    if (wanted.outputs.empty()) quantity.names = {wanted.name};
    for (const std::string& value : wanted.outputs) quantity.names.push_back(wanted.name + "." + value);
    quantity.evaluate = [library, wanted](const QuantityRequest& request) {
        return evaluate(*library, wanted, request);
    };
    quantity.has_sensitivities = wanted.has_gradients;
    quantity.program = "plugin " + wanted.library.filename().string() + '\0' + wanted.options;
    return quantity;
}

}  // namespace strake
