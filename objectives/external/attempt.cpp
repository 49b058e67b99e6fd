#include "objectives/external/attempt.hpp"

#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/geometry.hpp"
#include "core/text/file.hpp"
#include "objectives/external/gradient.hpp"
#include "objectives/external/hand_over.hpp"
#include "objectives/external/handed_over.hpp"
#include "objectives/external/log.hpp"
#include "objectives/external/refused.hpp"
#include "objectives/external/result.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

namespace strake {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t result_limit = std::size_t{16} << 20;
constexpr double match_rel = 1e-5;  // of the diagonal

/// Parameters that the values depend on.
std::vector<std::string> wanted_variables(const ExternalCommand& command, const QuantityRequest& request) {
    std::vector<std::string> names;
    for (const auto& [name, value] : request.parameters)
        if (!command.depends_on ||
            std::find(command.depends_on->begin(), command.depends_on->end(), name) != command.depends_on->end())
            names.push_back(name);
    return names;
}

Points vertex_normals(const TriMesh& surface) {
    Points normals = Points::Zero(surface.num_vertices(), 3);
    for (int t = 0; t < surface.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) normals.row(surface.triangles(t, k)) += area_vector(surface, t).transpose();
    for (int v = 0; v < surface.num_vertices(); ++v)
        normals.row(v) = Eigen::RowVector3d(normals.row(v)).normalized();  // zero stays zero
    return normals;
}

/// The places of the program's gradients: the vertices, or its own points.
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

std::vector<std::string> value_keys(const ExternalCommand& command) {
    return command.outputs.empty() ? std::vector<std::string>{"value"} : command.outputs;
}

std::string request_text(const Task& task, const Call& call) {
    const ExternalCommand& command = task.command;
    const QuantityRequest& request = task.request;
    const bool want_gradients = task.wanted != Wanted::values;
    using json = nlohmann::ordered_json;
    json variables = json::object();
    for (const auto* list : {&request.parameters, &request.variables})
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

void hand_over(const Task& task, const Call& call) {
    const ProgramPoints* points = task.command.points.get();
    const std::string& format = task.command.format;
    const TriMesh& surface = task.request.surface;
    if (task.wanted != Wanted::gradients) {
        write_atomically(call.surface, handed_over_bytes(surface, format, points));
        if (points && format != "su2-positions")
            write_points(call.folder / points_name(*points), {points->map.moved(surface.vertices), points->rest.ids});
    }
    write_atomically(call.request, request_text(task, call));
}

void sign(const Task& task, const Call& call) {
    write_atomically(call.folder / "surface.hash", task.request.surface_hash + "\n");
}

bool is_of(const Task& task, const Call& call) {
    try {
        return read_bytes(call.folder / "surface.hash") == task.request.surface_hash + "\n" &&
               read_bytes(call.request) == request_text(task, call);
    } catch (const InputError&) {
        return false;
    }
}

QuantityResult read_results(const Task& task, const Call& call) {
    const ExternalCommand& command = task.command;
    const QuantityRequest& request = task.request;
    const bool want_gradients = task.wanted != Wanted::values;
    QuantityResult result;
    const std::string name = call.result.filename().string(), bytes = read_handed_over(call.folder, name, result_limit);
    const std::vector<std::string> by = wanted_variables(command, request);
    const ProgramResult found = parse_result(bytes, command.outputs, want_gradients, by, command.may_lack_derivatives,
                                             name, task.wanted != Wanted::gradients);
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
        Eigen::VectorXd& all =
            result.dJ_dp.emplace_back(Eigen::VectorXd::Zero(static_cast<int>(request.parameters.size())));
        for (std::size_t j = 0, k = 0; j < request.parameters.size() && k < by.size(); ++j)
            if (request.parameters[j].first == by[k]) all[static_cast<int>(j)] = derivatives[k++];
    }
    result.values = found.values;
    return result;
}

std::string last_lines_in(const Call& call) {
    constexpr std::streamoff tail = 64 * 1024;
    constexpr int lines = 10;
    for (const char* name : {"stderr.log", "stdout.log"}) {
        std::error_code ignored;
        if (!fs::is_regular_file(fs::symlink_status(call.file(name), ignored))) continue;
        std::ifstream log(call.file(name), std::ios::binary);
        log.seekg(0, std::ios::end);
        log.seekg(std::max<std::streamoff>(0, static_cast<std::streamoff>(log.tellg()) - tail));
        const std::string end{std::istreambuf_iterator<char>(log), {}};
        if (const std::string shown = printable_tail(end, lines); !shown.empty()) return shown;
    }
    return "";
}

QuantityResult failed(const Task& task, const Call& call, Failure failure, const std::string& last_lines) {
    failure.message =
        text(task.command.name, ", evaluation ", task.request.evaluation, ": ",
             task.wanted == Wanted::gradients ? "gradient: " : "", failure.message, "\n  in ", call.folder.string());
    if (!last_lines.empty()) failure.message += "\n  the program's last lines:\n" + last_lines;
    return {{}, {}, failure};
}

}  // namespace strake
