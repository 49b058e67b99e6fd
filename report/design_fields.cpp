#include "report/design_fields.hpp"

#include "core/error.hpp"
#include "core/formats/vtp_reader.hpp"
#include "core/text/csv_columns.hpp"
#include "core/text/file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace strake {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t max_fields = 20;  ///< of one evaluation

/// Names with another meaning in a data set.
bool is_taken(const std::string& name) {
    return name.empty() || name == "displacement" || name == "objective_sensitivity" || name == "sensitivity" ||
           name == "load" || name.starts_with("patch");
}

bool read(std::string_view word, double& value) {
    while (!word.empty() && (word.front() == ' ' || word.front() == '\t')) word.remove_prefix(1);
    while (!word.empty() && (word.back() == ' ' || word.back() == '\r')) word.remove_suffix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size() && !word.empty();
}

/// Rows index,value; a first line of another form is a header.
Eigen::VectorXd rows_of_csv(const std::string& bytes, int vertices) {
    Eigen::VectorXd values = Eigen::VectorXd::Constant(vertices, std::numeric_limits<double>::quiet_NaN());
    std::istringstream lines(bytes);
    std::string line;
    int number = 0, count = 0;
    while (std::getline(lines, line)) {
        ++number;
        const std::vector<std::string_view> fields = csv_fields(line, 2);
        double index = 0, value = 0;
        if (line.empty() || line == "\r" || line[0] == '#') continue;
        const bool is_row = fields.size() == 2 && read(fields[0], index) && read(fields[1], value);
        if (!is_row && count == 0 && number == 1) continue;
        if (!is_row || !std::isfinite(value)) throw InputError(text("line ", number, ": expected index,value"));
        if (!(index >= 0 && index < vertices) || index != std::floor(index))
            throw InputError(text("line ", number, ": index ", index, ", limits 0 and ", vertices - 1));
        if (std::isfinite(values[static_cast<int>(index)]))
            throw InputError(text("line ", number, ": vertex ", index, " appears twice"));
        values[static_cast<int>(index)] = value;
        ++count;
    }
    if (count != vertices) throw InputError(text(count, " rows, must be ", vertices, ", one for each vertex"));
    return values;
}

Eigen::VectorXd field_of_vtp(const std::string& bytes, const std::string& field, int vertices) {
    for (const VtpField& found : parse_vtp(bytes, "the file").point_fields) {
        if (!field.empty() && found.name != field) continue;
        if (found.values.cols() != 1 || found.values.rows() != vertices)
            throw InputError(text("'", printable(found.name, 60), "' has ", found.values.rows(), " rows of ",
                                  found.values.cols(), ", must be ", vertices, " of 1"));
        if (!found.values.allFinite()) throw InputError("a value is not finite");
        return found.values.col(0);
    }
    throw InputError(text("no point field '", printable(field, 60), "'"));
}

/// Only files inside the folder: a result names its own files.
fs::path file_in(const fs::path& folder, const std::string& name) {
    const fs::path path = fs::path(name).lexically_normal();
    if (name.empty() || path.is_absolute() || *path.begin() == "..")
        throw InputError("must be the name of a file in the folder of the evaluation");
    return folder / path;
}

Eigen::VectorXd values_of(const Json& entry, const fs::path& folder, int vertices) {
    const bool is_pair = entry.is_object() && entry.contains("file") && entry["file"].is_string();
    if (!entry.is_string() && !is_pair) throw InputError("must be the name of a file, or {\"file\": …, \"field\": …}");
    const std::string name = (is_pair ? entry["file"] : entry).get<std::string>();
    std::string field;
    if (is_pair && entry.contains("field") && entry["field"].is_string()) field = entry["field"];
    const std::string bytes = read_bytes(file_in(folder, name));
    return fs::path(name).extension() == ".vtp" ? field_of_vtp(bytes, field, vertices) : rows_of_csv(bytes, vertices);
}

struct Collected {
    std::vector<Field>& fields;
    std::vector<std::string>& problems;
    bool has(const std::string& name) const {
        return std::any_of(fields.begin(), fields.end(), [&](const Field& field) { return field.name == name; });
    }
};

void add_of_program(const fs::path& folder, int vertices, Collected& out) {
    std::error_code ignored;
    if (!fs::is_regular_file(folder / "result.json", ignored)) return;
    Json result;
    try {
        result = Json::parse(read_bytes(folder / "result.json"), nullptr, false);
    } catch (const InputError&) {
        return;
    }
    if (!result.is_object() || !result.contains("fields") || !result["fields"].is_object()) return;
    for (const auto& [key, entry] : result["fields"].items()) {
        const std::string name = printable(key, 60);
        try {
            if (is_taken(name) || out.has(name)) throw InputError("the name is taken");
            if (out.fields.size() == max_fields) throw InputError(text("at most ", max_fields, " fields are kept"));
            out.fields.push_back({name, values_of(entry, folder, vertices)});
        } catch (const InputError& error) {
            out.problems.push_back(text("field '", name, "' of a program is ignored: ", error.what()));
        }
    }
}

void add_distance(const Quantity& quantity, const TriMesh& surface, Collected& out) {
    try {
        const Residuals found = quantity.residuals(surface, surface);
        if (found.weight.size() != surface.num_vertices() || found.r.size() != found.width * found.weight.size())
            return;  // at points other than the vertices
        Eigen::VectorXd distance = Eigen::VectorXd::Zero(found.weight.size());
        for (Eigen::Index k = 0; k < distance.size(); ++k)
            if (found.weight[k] > 0)
                distance[k] = found.r.segment(k * found.width, found.width).norm() / std::sqrt(found.weight[k]);
        out.fields.push_back({quantity.names.front() + ".distance", distance});
    } catch (const InvalidInput& error) {
        out.problems.push_back(text("distances of ", quantity.names.front(), " are ignored: ", error.what()));
    }
}

void add_built_in(const Quantity& quantity, const ShownDesign& design, Collected& out) {
    QuantityRequest request{design.surface, false, 0, 0, {}};
    request.parameters = design.parameters;
    try {
        for (SurfaceField& field : quantity.fields(request))
            if (field.values.size() == design.surface.num_vertices() && field.values.allFinite())
                out.fields.push_back({std::move(field.name), std::move(field.values)});
            else
                out.problems.push_back(text("field '", field.name, "' is ignored: a value is not finite"));
    } catch (const std::runtime_error& error) {
        out.problems.push_back(text("fields of ", quantity.names.front(), " are ignored: ", error.what()));
    } catch (const InvalidInput& error) {
        out.problems.push_back(text("fields of ", quantity.names.front(), " are ignored: ", error.what()));
    }
}

/// The fields that programs gave when the design was written, for a folder that has been removed.
void add_of_data_set(const fs::path& file, int vertices, Collected& out) {
    std::error_code ignored;
    if (file.empty() || !fs::is_regular_file(file, ignored)) return;
    try {
        for (VtpField& found : parse_vtp(read_bytes(file), file.string()).point_fields)
            if (!is_taken(found.name) && !out.has(found.name) && found.values.cols() == 1 &&
                found.values.rows() == vertices)
                out.fields.push_back({found.name, Eigen::VectorXd(found.values.col(0))});
    } catch (const InputError& error) {
        out.problems.push_back(text("fields of programs are ignored: ", error.what()));
    }
}

}  // namespace

std::vector<Field> design_fields(const Problem& problem, const ShownDesign& design,
                                 std::vector<std::string>& problems) {
    std::vector<Field> fields;
    Collected out{fields, problems};
    const int vertices = design.surface.num_vertices();
    for (const Quantity& quantity : problem.quantities) {
        if (quantity.fields) add_built_in(quantity, design, out);
        if (quantity.residuals) add_distance(quantity, design.surface, out);
    }
    std::error_code why;
    if (!fs::exists(design.evaluation, why)) {
        add_of_data_set(design.data_set, vertices, out);
        return fields;
    }
    add_of_program(design.evaluation, vertices, out);
    std::vector<fs::path> below;
    for (fs::directory_iterator at(design.evaluation, why), end; !why && at != end; at.increment(why)) {
        std::error_code ignored;
        if (at->is_directory(ignored) && !at->is_symlink(ignored)) below.push_back(at->path());
    }
    std::sort(below.begin(), below.end());
    for (const fs::path& folder : below) add_of_program(folder, vertices, out);
    return fields;
}

}  // namespace strake
