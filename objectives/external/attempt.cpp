#include "objectives/external/attempt.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/io.hpp"
#include "objectives/external/gradient.hpp"
#include "objectives/external/hand_over.hpp"
#include "objectives/external/handed_over.hpp"
#include "objectives/external/refused.hpp"
#include "objectives/external/result.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace strake {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t result_limit = std::size_t{16} << 20;
constexpr double match_rel = 1e-5;  // of the diagonal, DESIGN section 7

/// Each word in braces replaced within its own argument, once: what is put in is not looked at again.
std::string replaced(const std::string& argument, const Call& call, const ExternalCommand& command) {
    const std::array<std::string, 5> values{call.surface.string(), call.request.string(), call.result.string(),
                                            call.folder.string(), fs::absolute(command.case_dir).string()};
    std::string done;
    for (std::size_t at = 0; at < argument.size();) {
        std::size_t k = 0, length = 0;
        for (; argument[at] == '{' && k < replaced_words.size(); ++k) {
            const std::string key = text("{", replaced_words[k], "}");
            if (argument.compare(at, key.size(), key) != 0) continue;
            length = key.size();
            break;
        }
        done += length > 0 ? values[k] : argument.substr(at, 1);
        at += std::max<std::size_t>(length, 1);
    }
    return done;
}

std::vector<std::string> all_replaced(const std::vector<std::string>& words, const Call& call,
                                      const ExternalCommand& command) {
    std::vector<std::string> arguments;
    for (const std::string& argument : words) arguments.push_back(replaced(argument, call, command));
    std::string& program = arguments.front();  // a plain name is looked up on PATH
    if (program.find('/') != std::string::npos)
        program = (fs::absolute(command.case_dir) / program).lexically_normal().string();
    return arguments;
}

/// Own variables by which the values have to be differentiated.
std::vector<std::string> wanted_variables(const ExternalCommand& command, const QuantityRequest& request) {
    std::vector<std::string> names;
    for (const auto& [name, value] : request.own)
        if (!command.depends_on ||
            std::find(command.depends_on->begin(), command.depends_on->end(), name) != command.depends_on->end())
            names.push_back(name);
    return names;
}

std::string request_json(const ExternalCommand& command, const QuantityRequest& request, const Call& call,
                         bool want_gradients) {
    using json = nlohmann::ordered_json;
    json variables = json::object();
    for (const auto* list : {&request.own, &request.variables})
        for (const auto& [name, value] : *list) {
            if (!std::isfinite(value)) throw InvalidInput(text(command.name, ": variable ", name, " = ", value));
            variables[name] = value;
        }
    json wanted = json::object();
    wanted["values"] = value_keys(command);
    wanted["gradients"] = want_gradients ? value_keys(command) : std::vector<std::string>{};
    wanted["variables"] = want_gradients ? wanted_variables(command, request) : std::vector<std::string>{};
    json file = json::object();
    file["quantity"] = command.name;
    file["evaluation"] = request.evaluation;
    file["level"] = request.level;
    file["wanted"] = wanted;
    file["surface"] = call.surface.filename().string();
    if (command.points) {
        file["points"] =
            command.format == "su2-positions" ? call.surface.filename().string() : points_name(*command.points);
        file["num_points"] = command.points->map.num_points();
    }
    file["result"] = call.result.filename().string();
    file["vertices"] = request.surface.num_vertices();
    file["triangles"] = request.surface.num_triangles();
    file["units"] = {{"length", command.units}, {"angle", "rad"}};
    file["variables"] = variables;
    return file.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

Points vertex_normals(const TriMesh& surface) {
    Points normals = Points::Zero(surface.num_vertices(), 3);
    for (int t = 0; t < surface.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) normals.row(surface.triangles(t, k)) += area_vector(surface, t).transpose();
    for (int v = 0; v < surface.num_vertices(); ++v)
        normals.row(v) = Eigen::RowVector3d(normals.row(v)).normalized();  // zero stays zero
    return normals;
}

/// Whose gradients the program gives: the vertices', or those of its own points.
GradientPlaces places_of(const ExternalCommand& command, const TriMesh& surface) {
    GradientPlaces places = vertices_of(surface, match_rel * command.diagonal);
    if (!command.points) {
        places.normals = vertex_normals(surface);
        return places;
    }
    places.at = command.points->map.moved(surface.vertices);
    places.ids = command.points->rest.ids;
    places.whole = "the list of points";
    places.one = "point";
    places.many = "points";
    return places;
}

}  // namespace

fs::path first_folder(const ExternalCommand& command, int evaluation) {
    if (evaluation < 0) throw InvalidInput(text(command.name, ": evaluation = ", evaluation, " must be >= 0"));
    char number[16];
    std::snprintf(number, sizeof number, "%06d", evaluation);
    fs::path first = fs::absolute(command.evaluations_dir).lexically_normal() / number;
    if (command.own_folder) first /= command.name;
    return first;
}

fs::path attempt_folder(const fs::path& first, int attempt) {
    fs::path folder = first;
    if (attempt > 1) folder += text("-", attempt);
    return folder;
}

Call call_in(const ExternalCommand& command, const fs::path& folder) {
    return {folder, folder / handed_over_name(command.format), folder / "request.json", folder / "result.json"};
}

bool make_call_folder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder.parent_path(), error);
    if (error) throw OutputError(text(folder.parent_path().string(), ": cannot be created: ", error.message()));
    const bool made = fs::create_directory(folder, error);
    if (error) throw OutputError(text(folder.string(), ": cannot be created: ", error.message()));
    return made;
}

Call fresh_call(const ExternalCommand& command, int evaluation, int attempt) {
    const fs::path first = first_folder(command, evaluation);
    for (;; ++attempt) {
        const fs::path folder = attempt_folder(first, attempt);
        if (make_call_folder(folder)) return call_in(command, folder);
        if (!command.may_follow_others)
            throw OutputError(text(folder.string(), ": exists already; the folder of an evaluation must be fresh"));
    }
}

std::vector<std::string> value_keys(const ExternalCommand& command) {
    return command.gives.empty() ? std::vector<std::string>{"value"} : command.gives;
}

void hand_over(const ExternalCommand& command, const QuantityRequest& request, const Call& call, bool want_gradients) {
    const ProgramPoints* points = command.points.get();
    write_atomically(call.surface, handed_over_bytes(request.surface, command.format, points));
    if (points && command.format != "su2-positions")
        write_points(call.folder / points_name(*points),
                     {points->map.moved(request.surface.vertices), points->rest.ids});
    write_request(command, request, call, want_gradients);
}

void write_request(const ExternalCommand& command, const QuantityRequest& request, const Call& call,
                   bool want_gradients) {
    write_atomically(call.request, request_json(command, request, call, want_gradients));
}

std::vector<std::string> arguments_of(const ExternalCommand& command, const Call& call) {
    return all_replaced(command.command, call, command);
}

std::vector<std::string> gradient_arguments_of(const ExternalCommand& command, const Call& call) {
    return all_replaced(command.gradient_command, call, command);
}

QuantityResult read_results(const ExternalCommand& command, const QuantityRequest& request, const Call& call,
                            bool want_gradients, bool want_values) {
    QuantityResult result;
    const std::string bytes = read_handed_over(call.folder, call.result.filename().string(), result_limit);
    const std::vector<std::string> by = wanted_variables(command, request);
    const ProgramResult found = parse_result(bytes, command.gives, want_gradients, by, command.may_lack_derivatives,
                                             call.result.filename().string(), want_values);
    GradientPlaces places;
    if (want_gradients) places = places_of(command, request.surface);
    const std::size_t limit = result_limit + 1024 * static_cast<std::size_t>(places.at.rows());
    for (std::size_t i = 0; i < found.gradient_files.size(); ++i) {
        const std::string& file = found.gradient_files[i];
        const std::string content = read_handed_over(call.folder, file, limit, true);
        const Points gradient = parse_gradient(content, file, places, found.gradient_fields[i]);
        result.dJ_dv.push_back(command.points ? command.points->map.transpose(gradient) : gradient);
    }
    for (const std::vector<double>& derivatives : found.by_variable) {
        Eigen::VectorXd& all = result.dJ_down.emplace_back(Eigen::VectorXd::Zero(static_cast<int>(request.own.size())));
        for (std::size_t j = 0, k = 0; j < request.own.size() && k < by.size(); ++j)
            if (request.own[j].first == by[k]) all[static_cast<int>(j)] = derivatives[k++];
    }
    result.values = found.values;
    return result;
}

QuantityResult failed(const ExternalCommand& command, const QuantityRequest& request, const Call& call, Failure failure,
                      const std::string& last_lines) {
    failure.message =
        text(command.name, ", evaluation ", request.evaluation, ": ", failure.message, "\n  in ", call.folder.string());
    if (!last_lines.empty()) failure.message += "\n  the program's last lines:\n" + last_lines;
    return {{}, {}, failure};
}

}  // namespace strake
