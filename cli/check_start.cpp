#include "cli/check_start.hpp"

#include "cli/build_case.hpp"
#include "cli/commands.hpp"
#include "cli/work_folder.hpp"
#include "optimize/check/start_check.hpp"
#include "report/json_number.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <nlohmann/json.hpp>

namespace strake::cli {
namespace {

using Json = nlohmann::ordered_json;

struct SeenFile {
    std::string name;  ///< below the folder of evaluations
    std::uintmax_t bytes = 0;
};

std::vector<SeenFile> files_in(const std::filesystem::path& folder) {
    std::vector<SeenFile> files;
    std::error_code why;
    for (std::filesystem::recursive_directory_iterator at(folder, why), end; !why && at != end; at.increment(why))
        if (at->is_regular_file(why)) files.push_back({at->path().lexically_relative(folder), at->file_size(why)});
    std::sort(files.begin(), files.end(), [](const SeenFile& a, const SeenFile& b) { return a.name < b.name; });
    return files;
}

Json json_of(const StartAnswer::Value& value) {
    Json j{{"name", value.name}, {"value", json_number(value.value)}};
    j["gradient"] = nullptr;
    if (value.has_gradient)
        j["gradient"] = {{"norm", json_number(value.gradient_norm)},
                         {"largest", json_number(value.largest_gradient)},
                         {"largest_vertex", value.largest_vertex}};
    for (const auto& [name, derivative] : value.by_variable) j["variables"][name] = json_number(derivative);
    return j;
}

Json json_of(const StartAnswer& answer, const std::vector<SeenFile>& files, const std::filesystem::path& folder) {
    Json j;
    j["status"] = answer.status;
    j["reason"] = answer.reason;
    j["level"] = answer.level;
    j["variables"] = answer.variables;
    j["quantities"] = Json::array();
    for (const auto& quantity : answer.quantities) {
        Json& q = j["quantities"].emplace_back();
        q["values"] = Json::array();
        for (const auto& value : quantity.values) q["values"].push_back(json_of(value));
        q["program"] = quantity.is_program;
        q["seconds"] = json_number(quantity.seconds);
        if (quantity.gradient_seconds > 0) q["gradient_seconds"] = json_number(quantity.gradient_seconds);
        if (quantity.failure) q["failure"] = {{"kind", quantity.failure->kind}, {"message", quantity.failure->message}};
    }
    j["constraints"] = Json::array();
    for (const auto& row : answer.constraints)
        j["constraints"].push_back({{"quantity", row.quantity},
                                    {"value", json_number(row.value)},
                                    {"limit", json_number(row.limit)},
                                    {"scale", json_number(std::abs(row.scale))},
                                    {"scaled", json_number(row.scaled)},
                                    {"equality", row.is_equality}});
    j["folder"] = folder.string();
    j["files"] = Json::array();
    for (const SeenFile& file : files) j["files"].push_back({{"name", file.name}, {"bytes", file.bytes}});
    j["remarks"] = answer.remarks;
    return j;
}

void print_quantity(const StartAnswer::Quantity& quantity) {
    for (const auto& value : quantity.values) {
        if (!std::isfinite(value.value)) {
            fmt::print("value       {}: none\n", value.name);
            continue;
        }
        fmt::print("value       {} = {:.10g}, ", value.name, value.value);
        if (value.has_gradient)
            fmt::print("gradient of norm {:.4g}, largest {:.4g} at vertex {}\n", value.gradient_norm,
                       value.largest_gradient, value.largest_vertex);
        else
            fmt::print("{}\n", quantity.was_asked_for_gradients && value.is_gradient_needed ? "gradient missing"
                                                                                            : "gradient not requested");
        for (const auto& [name, derivative] : value.by_variable)
            if (std::isfinite(derivative))
                fmt::print("            by {}: {:.6g}\n", name, derivative);
            else
                fmt::print("            by {}: unknown\n", name);
    }
    if (!quantity.is_program) return;
    fmt::print("seconds     {:.3f}", quantity.seconds);
    if (quantity.gradient_seconds > 0) fmt::print(", gradients {:.3f}", quantity.gradient_seconds);
    fmt::print("\n");
}

void print_words(const StartAnswer& answer, const std::vector<SeenFile>& files) {
    fmt::print("start       level {}, {} variables\n", answer.level, answer.variables);
    for (const auto& quantity : answer.quantities) print_quantity(quantity);
    for (const auto& row : answer.constraints)
        fmt::print("constraint  {} = {:.6g} {} {:.6g}: {:+.3e} of {:.4g}, {}\n", row.quantity, row.value,
                   row.is_equality ? "="
                   : row.scale < 0 ? ">="
                                   : "<=",
                   row.limit, row.scaled + 0.0, std::abs(row.scale),
                   (row.is_equality ? std::abs(row.scaled) : row.scaled) <= 1e-6 ? "met" : "violated");
    for (const SeenFile& file : files) fmt::print("file        {} ({} bytes)\n", file.name, file.bytes);
    for (const std::string& remark : answer.remarks) fmt::print("note        {}\n", remark);
}

}  // namespace

void check_start_of(Case the_case, const std::string& out, bool json) {
    WorkFolder folder(out, "check");
    the_case.output.dir = folder.path();
    const BuiltProblem built = build_case(the_case);
    const StartAnswer answer = check_start(built.problem);
    const std::vector<SeenFile> files = files_in(folder.path() / "evaluations");
    if (json)
        fmt::print("{}\n", json_of(answer, files, folder.path()).dump(2, ' ', false, Json::error_handler_t::replace));
    else
        print_words(answer, files);
    if (answer.status == "ok") return;
    folder.keep();
    fmt::print(stderr, "strake: check: {}: {}\n", answer.status, answer.reason);
    bool program_failed = false;
    for (const auto& quantity : answer.quantities) program_failed |= quantity.is_program && quantity.failure;
    throw ExitStatus{program_failed ? external_failed : run_failed};
}

}  // namespace strake::cli
