#include "report/run_folder.hpp"
#include "core/patches/carried.hpp"
#include "core/text/file.hpp"
#include "core/text/shell_word.hpp"
#include "core/wrap/wrap_map.hpp"

#include "core/error.hpp"
#include "core/formats/vtp.hpp"
#include "optimize/run/design_table.hpp"
#include "optimize/run/stored_design.hpp"
#include "optimize/space/parameters.hpp"
#include "report/design_fields.hpp"
#include "report/json_number.hpp"
#include "report/paraview_script.hpp"

#include <algorithm>
#include <cstdio>
#include <iomanip>
#include <nlohmann/json.hpp>

namespace strake {
namespace {

namespace fs = std::filesystem;

std::ostringstream digits() {
    std::ostringstream s;
    s.imbue(std::locale::classic());
    s << std::setprecision(17);
    return s;
}

const char* kind_word(VariableKind kind) {
    switch (kind) {
        case VariableKind::load:
            return "load";
        case VariableKind::normal_load:
            return "load_normal";
        case VariableKind::strain:
            return "strain";
        case VariableKind::stiffness:
            return "stiffness";
        case VariableKind::field:
            return "field";
        case VariableKind::planform:
            return "planform";
        case VariableKind::parameter:
            return "own";
    }
    return "unknown";
}

std::string data_set_name(int evaluation) {
    std::ostringstream name;
    name << "series/design_" << std::setw(6) << std::setfill('0') << evaluation << ".vtp";
    return name.str();
}

std::string labels_csv(const PatchLevel& level) {
    std::string rows = "patch\n";
    for (const int p : level.label) rows += std::to_string(p) + "\n";
    return rows;
}

/// x times unit is the physical value: traction 1/length, radians, length, or the logarithm of a factor; for a
/// parameter of the program, the change from its start.
std::string variables_csv(const DesignSpace& space, const Eigen::VectorXd& x) {
    std::ostringstream rows = digits();
    rows << "name,kind,patch,x,lower,upper,unit,value\n";
    for (int j = 0; j < space.size(); ++j) {
        const Variable& v = space.variables[j];
        rows << v.name << ',' << kind_word(v.kind) << ',' << v.patch << ',' << x[j] << ',' << space.lower[j] << ','
             << space.upper[j] << ',' << v.unit << ',' << v.offset + x[j] * v.unit << '\n';
    }
    return rows.str();
}

nlohmann::ordered_json level_json(const LevelSummary& level) {
    return {{"level", level.level},
            {"patches", level.patches},
            {"variables", level.variables},
            {"evaluations", level.evaluations},
            {"objective_start", json_number(level.objective_start)},
            {"objective_end", json_number(level.objective_end)},
            {"inherited_shape_change", json_number(level.inherited_shape_change)},
            {"inherited_objective_change", json_number(level.inherited_objective_change)},
            {"left_out", level.dependent},
            {"weak", level.weak},
            {"nearly_held", level.nearly_fixed},
            {"stop", level.stop}};
}

/// Removes temporary files of a killed run, there and `deeper` folders down.
void remove_unfinished(const fs::path& folder, int deeper) {
    std::vector<fs::path> found, below;
    std::error_code why;
    for (fs::directory_iterator at(folder, why), end; !why && at != end; at.increment(why)) {
        const std::string name = at->path().filename().string();
        std::error_code ignored;
        if (name.starts_with(".strake-") && name.ends_with(".tmp")) found.push_back(at->path());
        if (deeper > 0 && at->is_directory(ignored) && !at->is_symlink(ignored)) below.push_back(at->path());
    }
    for (const fs::path& file : found) fs::remove(file, why);
    for (const fs::path& next : below) remove_unfinished(next, deeper - 1);
}

}  // namespace

namespace {

bool is_leftover(const std::string& name) {
    return name == "lock" || (name.starts_with(".strake-") && name.ends_with(".tmp"));
}

/// What a run leaves that is killed before it has written its case: nothing that anybody would miss.
bool holds_leftovers_only(const fs::path& folder) {
    std::error_code why;
    fs::directory_iterator at(folder, why), end;
    while (!why && at != end && is_leftover(at->path().filename().string())) at.increment(why);
    return !why && at == end;
}

/// Whether it has the case of a run (a case that somebody keeps there begins otherwise), but neither rows of a history
/// nor folders of evaluations.
bool has_only_begun(const fs::path& folder) {
    std::error_code why;
    if (!fs::exists(folder / "case.yaml", why) || fs::exists(folder / "run.json", why)) return false;
    if (fs::exists(folder / "evaluations", why)) return false;
    const std::string yaml = read_bytes(folder / "case.yaml");
    if (!yaml.starts_with("# run of a case in ") && !yaml.starts_with("# fit of a case in ")) return false;
    if (!fs::exists(folder / "history.csv", why)) return true;
    const std::string history = read_bytes(folder / "history.csv");
    return std::count(history.begin(), history.end(), '\n') < 2;
}

nlohmann::ordered_json samples_json(const SampleSummary& samples) {
    nlohmann::ordered_json j;
    j["variables"] = samples.table->variables;
    for (const auto& [key, bounds] : {std::pair("lower", &samples.lower), std::pair("upper", &samples.upper)}) {
        j[key] = nlohmann::ordered_json::array();
        for (const double bound : *bounds) j[key].push_back(json_number(bound));
    }
    j["values"] = nlohmann::ordered_json::object();
    for (const SampledValue& value : samples.values) {
        nlohmann::ordered_json& of = j["values"][value.name];
        of = {{"deviation", json_number(value.deviation)}, {"predicted_share", json_number(value.predicted_share)}};
        for (std::size_t k = 0; k < value.share.size(); ++k)
            of["main_effects"][samples.table->variables[k]] = {{"share", json_number(value.share[k])},
                                                               {"error", json_number(value.error[k])},
                                                               {"total", json_number(value.total[k])}};
    }
    if (!samples.without_effects.empty()) j["without_effects"] = samples.without_effects;
    j["remarks"] = samples.remarks;
    return j;
}

}  // namespace

void check_run_folder(const fs::path& folder) {
    std::error_code why;
    const fs::file_status status = fs::status(folder, why);
    if (!fs::exists(status)) return;
    if (!fs::is_directory(status)) throw OutputError(text(folder.string(), ": exists and is not a folder"));
    if (const auto holder = lock_holder(folder))
        throw OutputError(text(folder.string(), ": a run is in progress in this folder (", holder->words(),
                               "); give --out a new folder"));
    const bool empty = fs::is_empty(folder, why);
    if (why) throw OutputError(text(folder.string(), ": ", why.message()));
    if (!empty && has_only_begun(folder))
        throw OutputError(text(folder.string(),
                               ": the run in this folder ended before its first evaluation; `strake resume ",
                               typed_path(folder.string()), "` starts it"));
    if (!empty && !holds_leftovers_only(folder))
        throw OutputError(text(folder.string(),
                               ": the folder is not empty, and a run never overwrites another; give "
                               "--out a new folder, or remove this one"));
}

/// Absolute from the start: whoever changes the working directory later redirects nothing.
RunFolder::RunFolder(const fs::path& folder, bool is_continued)
    : folder_(fs::absolute(folder)), is_continued_(is_continued) {
    if (!is_continued) {
        check_run_folder(folder);
        make_folder(folder_);
    }
    lock_ = std::make_unique<RunLock>(folder_);
    constexpr int deepest = 3;  // evaluations/000012/aero
    remove_unfinished(folder_, is_continued ? deepest : 0);
}

fs::path RunFolder::aside(const std::string& name) {
    aside_.push_back(name);
    return folder_ / name;
}

void RunFolder::make_folder(const fs::path& folder) {
    std::vector<fs::path> missing;
    std::error_code why;
    for (fs::path at = fs::absolute(folder).lexically_normal(); !fs::exists(at, why); at = at.parent_path())
        if (at.has_filename()) missing.push_back(at);  // "a/b/" ends with an empty name
    fs::create_directories(folder, why);
    if (why) throw OutputError(text(folder.string(), ": cannot create the folder: ", why.message()));
    made_.insert(made_.begin(), missing.begin(), missing.end());
}

void RunFolder::discard() {
    history_.reset();
    std::error_code ignored;
    for (const auto* list : {&files_, &aside_})
        for (const std::string& file : *list) fs::remove(folder_ / file, ignored);
    lock_.reset();
    for (const fs::path& folder : made_) fs::remove(folder, ignored);  // fails if somebody else has put files there
    files_.clear();
    made_.clear();
}

void RunFolder::add_problems(const std::vector<std::string>& problems) {
    for (const std::string& words : problems)
        if (std::find(problems_.begin(), problems_.end(), words) == problems_.end()) problems_.push_back(words);
}

void RunFolder::remember(const std::string& name) {
    if (std::find(files_.begin(), files_.end(), name) == files_.end()) files_.push_back(name);
}

void RunFolder::write(const std::string& name, const std::string& bytes) {
    const fs::path file = folder_ / name;
    make_folder(file.parent_path());
    write_atomically(file, bytes);
    remember(name);
}

void RunFolder::write_case(const std::string& yaml) { write("case.yaml", yaml); }

void RunFolder::write_start(const TriMesh& surface, SurfaceFormat format, const std::string& repairs_csv) {
    const std::string name = "start" + extension_of(format);
    write(name, surface_bytes(surface, format, name));
    if (!repairs_csv.empty()) write("start-repairs.csv", repairs_csv);
}

void RunFolder::begin(const Problem& problem, const std::vector<std::string>& value_names, SurfaceFormat format,
                      SeriesPolicy policy, KeepPolicy keep) {
    problem_ = &problem;
    const bool may_ask_again = std::any_of(problem.quantities.begin(), problem.quantities.end(),
                                           [](const Quantity& q) { return bool(q.differentiate); });
    evaluations_ = std::make_unique<EvaluationFolders>(folder_, keep, may_ask_again);
    format_ = format;
    policy_ = policy;
    history_ =
        std::make_unique<HistoryWriter>(folder_ / "history.csv", value_names, recorded_names(problem), is_continued_);
    remember("history.csv");
}

void RunFolder::add(const EvaluationRecord& record) {
    std::error_code ignored;
    if (is_continued_ && !record.is_replayed) fs::remove(folder_ / "run.json", ignored);  // it describes an earlier end
    history_->add(record);
    evaluations_->add(record);
}

void RunFolder::add(const LevelStart& level) {
    const std::string number = std::to_string(level.space.level);
    write("levels/labels_" + number + ".csv", labels_csv(level.space.patches()));
    if (problem_->wrap) {
        const std::string wrap = "levels/wrap_" + number + ".vtp";
        write_vtp(folder_ / wrap, problem_->wrap->mesh(), {}, {{"patch", level.space.patches().label}});
        remember(wrap);
    }
    write("levels/variables_" + number + ".csv", variables_csv(level.space, level.x));
}

void RunFolder::add(const AcceptedDesign& design) {
    const std::string best = "best" + extension_of(format_);
    for (const std::string& file : {best, std::string("levels/best.csv"), std::string("levels/best.design")})
        remember(file);
    if (design.record.evaluation >= best_from_) {
        write_surface(folder_ / best, with_vertices(problem_->surface, design.vertices), format_);
        write("levels/best.csv", variables_csv(design.space, design.x));
        write("levels/best.design", design_bytes(stored_design(design)));
    }
    const bool wanted = policy_ == SeriesPolicy::every_accepted || (policy_ == SeriesPolicy::best && steps_.empty());
    if (!wanted && policy_ != SeriesPolicy::best) return;
    last_best_ = data_set(design);
    if (wanted) add_to_series(design.record.evaluation, last_best_);
}

void RunFolder::add_sensitivities(int evaluation, const Points& dJ_dv) {
    last_best_.dJ_dv = dJ_dv;
    if (steps_.empty() || steps_.back().first != evaluation) return;
    last_.dJ_dv = dJ_dv;
    if (evaluation >= best_from_) write_data_set(steps_.back().second, last_);
}

/// Labels of the elastic triangles on those of the surface.
std::vector<int> RunFolder::on_surface(const std::vector<int>& label) const {
    return problem_->wrap ? carried(label, problem_->wrap->wrap_triangle()) : label;
}

RunFolder::DataSet RunFolder::data_set(const AcceptedDesign& design) {
    char number[16];
    std::snprintf(number, sizeof number, "%06d", design.record.evaluation);
    std::vector<std::string> problems;
    DataSet out{design.vertices, design.dJ_dv, {}, on_surface(design.space.patches().label), {}};
    const TriMesh surface = with_vertices(problem_->surface, design.vertices);
    const ShownDesign shown{surface, folder_ / "evaluations" / number, parameter_values(design.space, design.x),
                            folder_ / data_set_name(design.record.evaluation)};
    out.fields = design_fields(*problem_, shown, problems);
    add_problems(problems);
    const Points force = demand(design.space, design.x).loads.force;
    if (force.rows() != problem_->surface.num_vertices() || problem_->wrap) return out;  // loads on a wrap
    const Eigen::VectorXd& area = design.space.rest->vertex_area;
    out.load = force.array().colwise() * area.array().max(std::numeric_limits<double>::min()).inverse();
    return out;
}

void RunFolder::write_data_set(const std::string& name, const DataSet& design) const {
    std::vector<Field> points{{"displacement", Points(design.vertices - problem_->surface.vertices)}};
    if (design.dJ_dv.rows() > 0) points.push_back({"objective_sensitivity", design.dJ_dv});
    if (design.load.rows() > 0) points.push_back({"load", design.load});
    points.insert(points.end(), design.fields.begin(), design.fields.end());
    std::vector<Field> cells;
    if (!design.patch.empty()) cells.push_back({"patch", design.patch});
    for (std::size_t k = 1; k < problem_->tree.levels.size(); ++k)
        cells.push_back({"patch_level_" + std::to_string(k), on_surface(problem_->tree.levels[k].label)});
    write_vtp(folder_ / name, with_vertices(problem_->surface, design.vertices), points, cells);
}

void RunFolder::add_to_series(int evaluation, DataSet design) {
    const std::string name = data_set_name(evaluation);
    make_folder(folder_ / "series");
    // A replayed design has been written already, complete and with the same bytes.
    if (evaluation >= best_from_ || !fs::exists(folder_ / name)) write_data_set(name, design);
    last_ = std::move(design);
    steps_.emplace_back(evaluation, name);
    write_pvd(folder_ / "series.pvd", steps_);
    remember("series.pvd");
    if (steps_.size() == 1) write("series.py", paraview_script());
}

void RunFolder::write_samples(const DesignTable& table) { write("samples.csv", table_csv(table)); }

void RunFolder::finish(const RunResult& result) {
    const bool is_over = result.status != "interrupted" && result.status != "waiting";
    if (is_over && policy_ == SeriesPolicy::best && result.vertices.rows() > 0 && result.best_evaluation > 1)
        add_to_series(result.best_evaluation, last_best_);
    if (is_over) history_->finish(), evaluations_->finish(result);
    add_problems(evaluations_->problems());
    remember("run.json");
    write("run.json", run_json(result, files_) + "\n");
}

std::string run_json(const RunResult& result, const std::vector<std::string>& files) {
    nlohmann::ordered_json j;
    j["status"] = result.status;
    j["reason"] = result.reason;
    if (!result.cheap_model.empty()) j["cheap_model"] = result.cheap_model;
    j["level"] = result.level;
    j["evaluations"] = result.evaluations;
    j["objective"] = json_number(result.objective);
    j["best"] = json_number(result.objective);
    j["max_violation"] = json_number(result.max_violation);
    j["files"] = files;
    j["objective_start"] = json_number(result.objective_start);
    j["best_evaluation"] = result.best_evaluation;
    for (std::size_t i = 0; i < result.values.size(); ++i)
        j["values"][result.names[i]] = {{"start", json_number(result.values_start[i])},
                                        {"best", json_number(result.values[i])}};
    if (result.best_evaluation > 0)
        for (const auto& [name, value] : parameter_values(result.space, result.x)) {
            const ProgramParameter& parameter = result.space.rest->program_parameters[j["variables"].size()];
            j["variables"][name] = {{"start", json_number(parameter.start)}, {"best", json_number(value)}};
            if (parameter.is_angle) j["variables"][name]["unit"] = "rad";
        }
    if (result.best_evaluation > 0)
        for (const auto& [name, value, is_angle] : planform_values(result.space, result.x)) {
            j["variables"][name] = {{"start", 0.0}, {"best", json_number(value)}};
            if (is_angle) j["variables"][name]["unit"] = "rad";
        }
    if (result.motion.is_limited)
        j["motion_limit"] = {{"active", result.motion.is_active},
                             {"used", json_number(result.motion.used)},
                             {"limit", json_number(result.motion.limit)},
                             {"vertex", result.motion.vertex},
                             {"vertices", result.motion.num_vertices},
                             {"patch", result.motion.where},
                             {"gain_per_thousandth", json_number(result.motion.gain)}};
    for (const AwaitedCall& call : result.awaited)
        j["awaited"].push_back({{"evaluation", call.evaluation},
                                {"quantity", call.quantity},
                                {"folder", call.folder},
                                {"request", call.request},
                                {"command", call.command}});
    if (result.samples) j["samples"] = samples_json(*result.samples);
    j["levels"] = nlohmann::ordered_json::array();
    for (const LevelSummary& level : result.levels) j["levels"].push_back(level_json(level));
    return j.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace strake
