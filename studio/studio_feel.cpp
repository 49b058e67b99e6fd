#include "casefile/load_case.hpp"
#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "report/json_number.hpp"
#include "studio/studio_impl.hpp"
#include "studio/surface_payload.hpp"

#include <cstring>

/// Sliders: the variables of a level, and the exact shape at their values.
namespace strake {

/// The bench of this text, made anew when the text is another one. @pre feeling is locked
ShapeBench& Studio::Impl::bench_for(const std::string& yaml) {
    if (bench && bench_text == yaml) return *bench;
    bench.reset();
    felt.resize(0, 3);
    bench = std::make_unique<ShapeBench>(load_case_text(yaml, case_path()));
    bench_text = yaml;
    return *bench;
}

/// {levels: [first, last], level, variables: [{name, lower, upper, unit}], leaves_out_programs}.
Studio::Impl::Json Studio::Impl::variables(const Asked& asked) {
    const std::lock_guard lock(feeling);
    ShapeBench& made = bench_for(text_in(asked, "text"));
    int level = made.coarsest();
    if (asked.contains("level") && asked["level"].is_number_integer()) level = asked["level"].get<int>();
    Json list = Json::array();
    for (const BenchVariable& variable : made.variables(level))
        list.push_back({{"name", variable.name},
                        {"lower", variable.lower},
                        {"upper", variable.upper},
                        {"unit", variable.unit},
                        {"is_parameter", variable.is_parameter}});
    return {{"levels", {made.coarsest(), made.finest()}},
            {"level", level},
            {"variables", std::move(list)},
            {"leaves_out_programs", made.leaves_out_programs()}};
}

/// {status, reason, has_shape, values: {name: value}}; the shape itself is at /api/felt.
Studio::Impl::Json Studio::Impl::feel(const Asked& asked) {
    const std::lock_guard lock(feeling);
    ShapeBench& made = bench_for(text_in(asked, "text"));
    if (!asked.contains("level") || !asked["level"].is_number_integer()) throw InvalidInput("'level' must be a number");
    if (!asked.contains("x") || !asked["x"].is_array()) throw InvalidInput("'x' must be a list");
    std::vector<double> x;
    for (const Asked& value : asked["x"]) {
        if (!value.is_number()) throw InvalidInput("'x' must be a list of numbers");
        x.push_back(value.get<double>());
    }
    BenchShape shape = made.at(asked["level"].get<int>(), x);
    felt = std::move(shape.vertices);
    Json values = Json::object();
    for (std::size_t k = 0; k < std::min(shape.names.size(), shape.values.size()); ++k)
        values[shape.names[k]] = json_number(shape.values[k]);
    return {{"status", shape.status},
            {"reason", shape.reason},
            {"has_shape", felt.rows() > 0},
            {"values", std::move(values)}};
}

WebAnswer Studio::Impl::felt_shape() {
    const auto shown = need_subject();
    const std::lock_guard lock(feeling);
    if (felt.rows() != shown->ground.start.mesh.num_vertices())
        return {404, "text/plain", "there is no shape, or it belongs to another surface than the one shown\n"};
    return {200, "application/octet-stream", centred_positions(felt, shown->ground.start.mesh)};
}

std::string centred_positions(const Points& vertices, const TriMesh& start) {
    const Box box = bounding_box(start);
    const std::vector<float> positions = relative_to((box.min + box.max) / 2, vertices);
    std::string bytes(positions.size() * sizeof(float), '\0');
    if (!positions.empty()) std::memcpy(bytes.data(), positions.data(), bytes.size());
    return bytes;
}

}  // namespace strake
