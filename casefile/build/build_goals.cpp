#include "casefile/build/problem_builder.hpp"
#include "casefile/check/cheap_models.hpp"
#include "core/error.hpp"
#include "core/mesh/surface_map.hpp"
#include "core/text/file.hpp"
#include "objectives/external/external.hpp"
#include "objectives/external/hand_over.hpp"
#include "objectives/external/plugin.hpp"
#include "objectives/fit/measured_points.hpp"
#include "objectives/fit/target_shape.hpp"
#include "objectives/geometry/measures.hpp"
#include "objectives/quantity/closed.hpp"
#include "optimize/journal/journal.hpp"
#include "optimize/run/design_table.hpp"

#include <algorithm>

namespace strake {
namespace {

/// The folder of an evaluation has files of these names of its own.
bool is_handed_over(const std::string& word) {
    constexpr const char* names[] = {"surface_positions.dat", "points.npy",  "points.csv",   "request.json",
                                     "gradient_request.json", "result.json", "gradient.json"};
    return word.starts_with("surface.") || std::ranges::find(names, word) != std::end(names);
}

/// A program runs in the folder of its evaluation: `python3 solve.py` does not find the script beside the case.
void warn_of_files_elsewhere(const std::string& quantity, const std::vector<std::string>& words,
                             const std::filesystem::path& case_dir, std::vector<std::string>& warnings) {
    for (std::size_t k = 1; k < words.size(); ++k) {
        std::error_code ignored;
        if (words[k].empty() || words[k].front() == '/' || is_handed_over(words[k]) ||
            !std::filesystem::is_regular_file(case_dir / words[k], ignored))
            continue;
        warnings.push_back(text("quantities.", quantity, ": '", printable(words[k]),
                                "' is a file beside the case, and the program runs in the folder of its evaluation; "
                                "write \"{case_dir}/",
                                printable(words[k]), "\" for that file"));
    }
}

/// A quantity that a trial shape may leave undefined (a line that no longer crosses the body): shortens the step.
Quantity shortening(Quantity quantity) {
    quantity.failing_shortens_step = true;
    return quantity;
}

std::function<QuantityResult(const QuantityRequest&)> with_value_after_failure(const Quantity& quantity, double value) {
    return [ask = quantity.evaluate, count = quantity.names.size(), value](const QuantityRequest& request) {
        QuantityResult result = ask(request);
        if (!result.failure) return result;
        result.remarks.push_back(
            text(result.failure->kind, ": ", result.failure->message, "; ", value, " is substituted"));
        result.failure.reset();
        result.values.assign(count, value);
        result.is_substitute = true;
        return result;
    };
}

std::optional<std::vector<std::string>> names_of(const std::optional<std::vector<Reference>>& references) {
    if (!references) return {};
    std::vector<std::string> names;
    for (const Reference& reference : *references) names.push_back(reference.name);
    return names;
}

}  // namespace

/// Designs that have been evaluated elsewhere: `sample.table`.
void ProblemBuilder::read_designs() {
    if (!case_.sample_table) return;
    std::vector<std::string> names;
    for (const Quantity& quantity : out_.problem.quantities)
        names.insert(names.end(), quantity.names.begin(), quantity.names.end());
    try {
        out_.problem.table = std::make_shared<const DesignTable>(read_table(*case_.sample_table, names));
    } catch (const InputError& refused) {
        errors_.add(case_.sample_place, refused.what());
    }
}

void ProblemBuilder::set_goals() {
    for (const QuantityEntry& entry : case_.quantities)
        at(entry.place, text("quantities.", entry.name, ": "), [&] {
            Quantity quantity = std::visit([&](const auto& what) { return make(entry, what); }, entry.what);
            quantity.names = entry.value_names();
            out_.problem.quantities.push_back(std::move(quantity));
        });
    for (const ProgramParameterEntry& entry : case_.variables)
        out_.problem.program_parameters.push_back(entry.variable);
    out_.problem.objective = case_.objective.name;
    out_.problem.maximize = case_.maximize;
    for (const Reference& target : case_.fit) out_.problem.fit.push_back(target.name);
    for (const ConstraintEntry& entry : case_.constraints) out_.problem.constraints.push_back(entry.constraint);
    out_.problem.optimize = case_.optimize;
    set_cheap_models();
    out_.problem.sample = case_.sample;
    out_.problem.fitting = case_.fitting;
    const Length& scale = case_.loss_scale;
    out_.problem.fitting.loss_scale = scale.is_relative_to_diagonal ? scale.value : scale.value / start_.diagonal;
}

void ProblemBuilder::set_cheap_models() {
    out_.problem.cheap_models = cheap_models(case_, errors_);
    for (const QuantityEntry* entry : cheap_programs(case_, out_.problem.cheap_models))
        at(entry->place, text("quantities.", entry->name, ": "), [&] {
            Quantity quantity = make_program(*entry, std::get<ExternalEntry>(entry->what), "low_fidelity");
            quantity.names = entry->value_names();
            quantity.failing_shortens_step = true;  // of the cheap model: the run does without this design
            out_.problem.cheap_programs.push_back(std::move(quantity));
        });
}

/// Where there is no shell the surface may be open.
Quantity ProblemBuilder::make(const QuantityEntry&, const VolumeEntry&) {
    const bool is_open =
        (!case_.has_shell || case_.wrap) && !open_edges(start_.mesh, start_.adjacent, case_.symmetry).empty();
    return is_open ? closed_volume(start_.mesh, case_.symmetry) : volume(start_.mesh, case_.symmetry);
}
Quantity ProblemBuilder::make(const QuantityEntry&, const AreaEntry&) { return area(!case_.has_shell || case_.wrap); }
Quantity ProblemBuilder::make(const QuantityEntry& entry, const TargetShapeEntry& target) {
    const TriMesh shape = read_surface(target.file).mesh;
    return target.same_connectivity ? target_shape_same(entry.name, start_.mesh, shape)
                                    : target_shape_closest(entry.name, start_.mesh, shape);
}
Quantity ProblemBuilder::make(const QuantityEntry& entry, const MeasuredPointsEntry& measured) {
    try {
        return shortening(measured_points(entry.name, start_.mesh, read_measured_points(measured.file)));
    } catch (const InputError& error) {
        throw InvalidInput(error.what());
    }
}
Quantity ProblemBuilder::make(const QuantityEntry& entry, const LineThicknessEntry& along) {
    return shortening(thickness(entry.name, start_.mesh, along.lines, along.values));
}
Quantity ProblemBuilder::make(const QuantityEntry& entry, const SectionAreaEntry& area) {
    return shortening(section_area(entry.name, start_.mesh, area.section, case_.symmetry));
}
Quantity ProblemBuilder::make(const QuantityEntry& entry, const BuiltInEntry& made) {
    const auto marks = [&](const Reference& region) {
        std::vector<char> is_in(static_cast<std::size_t>(start_.mesh.num_triangles()), 0);
        for (const int t : triangles(region)) is_in[static_cast<std::size_t>(t)] = 1;
        return is_in;
    };
    try {
        const auto wing = [&](const std::string& name) { return wings_.at(name); };
        const auto body = [&](const std::string& name) { return bodies_.at(name); };
        return shortening(made.make(entry.name, {start_.mesh, start_.diagonal, case_.symmetry, marks, wing, body}));
    } catch (const InputError& error) {
        throw InvalidInput(error.what());
    }
}
/// It has sensitivities where all its parts have.
Quantity ProblemBuilder::make(const QuantityEntry&, const FormulaEntry& formula) {
    Quantity quantity;
    quantity.combination = Combination{formula.of, formula.value};
    quantity.evaluate = [](const QuantityRequest&) { return QuantityResult{}; };
    quantity.failing_shortens_step = true;
    for (const Quantity& other : out_.problem.quantities)
        for (const std::string& name : other.names)
            if (std::find(formula.of.begin(), formula.of.end(), name) != formula.of.end())
                quantity.has_sensitivities &= other.has_sensitivities;
    return quantity;
}
std::shared_ptr<const ProgramPoints> ProblemBuilder::program_points(const ExternalEntry& program) const {
    try {
        NumberedPoints rest = read_points(program.gradient_points);
        const double reach = program.support_radius.in(start_.diagonal) / start_.diagonal;
        std::vector<double> numbers{reach};
        if (const auto& plane = case_.symmetry)
            numbers.insert(numbers.end(), {plane->normal.x(), plane->normal.y(), plane->normal.z(), plane->offset});
        const std::string_view bits(reinterpret_cast<const char*>(numbers.data()), sizeof(double) * numbers.size());
        std::string origin = text(content_hash(start_.mesh), " ", content_hash(read_bytes(program.gradient_points)),
                                  " ", content_hash(bits));
        SurfaceMap map(start_.mesh, rest.at, {reach, case_.symmetry});
        return std::make_shared<const ProgramPoints>(
            ProgramPoints{std::move(rest), std::move(map), is_npy(program.gradient_points), std::move(origin)});
    } catch (const InputError& error) {
        throw InvalidInput(error.what());
    }
}

Quantity ProblemBuilder::make_plugin(const QuantityEntry& entry, const ExternalEntry& program) const {
    PluginLibrary library;
    library.name = entry.name;
    library.library = program.plugin->library;
    library.options = program.plugin->options;
    library.outputs = program.outputs;
    library.has_gradients = program.has_gradients;
    library.depends_on = names_of(program.depends_on);
    library.may_lack_derivatives = case_.optimize.finite_differences;
    Quantity quantity = plugin(library);
    if (program.on_failure == ExternalEntry::OnFailure::value)
        quantity.evaluate = with_value_after_failure(quantity, program.value_after_failure);
    quantity.failing_shortens_step = program.on_failure == ExternalEntry::OnFailure::shrink_step;
    return quantity;
}

Quantity ProblemBuilder::make(const QuantityEntry& entry, const ExternalEntry& program) {
    return make_program(entry, program, "evaluations");
}

/// @param folders name of the folder that holds those of its calls
Quantity ProblemBuilder::make_program(const QuantityEntry& entry, const ExternalEntry& program, const char* folders) {
    if (program.plugin) return make_plugin(entry, program);
    ExternalCommand command;
    command.name = entry.name;
    command.command = program.command;
    command.outputs = program.outputs;
    command.timeout_s = program.timeout_s;
    command.format = program.format.empty() ? name_of(out_.format) : program.format;
    // Now, not when the command runs: a plug-in or a callback may change the working directory.
    command.case_dir = std::filesystem::absolute(case_.command_dir.empty() ? case_.dir() : case_.command_dir);
    command.evaluations_dir = std::filesystem::absolute(case_.output.dir / folders);
    const auto is_program = [](const QuantityEntry& q) { return std::holds_alternative<ExternalEntry>(q.what); };
    command.own_folder = std::count_if(case_.quantities.begin(), case_.quantities.end(), is_program) > 1;
    command.has_gradients = program.has_gradients;
    command.gradient_command = program.gradient_command;
    command.gradient_timeout_s = program.gradient_timeout_s;
    if (!program.gradient_points.empty()) command.points = program_points(program);
    command.depends_on = names_of(program.depends_on);
    command.may_lack_derivatives = case_.optimize.finite_differences;
    command.diagonal = start_.diagonal;
    command.units = case_.units;
    command.retries = program.retries;
    command.may_follow_others = case_.output.is_resumed;
    command.parallel = program.parallel;
    command.by_hand = case_.output.by_hand;
    command.slurm = program.slurm;
    command.queue_s = program.queue_s;
    command.poll_s = program.poll_s;
    if (!program.cache.empty()) command.cache = std::filesystem::absolute(program.cache);
    for (const std::filesystem::path& file : program.cache_files)
        command.files.push_back(std::filesystem::absolute(file));
    if (program.on_failure == ExternalEntry::OnFailure::value)
        command.value_after_failure = program.value_after_failure;
    for (const auto* words : {&command.command, &command.gradient_command})
        warn_of_files_elsewhere(entry.name, *words, command.case_dir, out_.warnings);
    Quantity quantity = external(command);
    quantity.failing_shortens_step = program.on_failure == ExternalEntry::OnFailure::shrink_step;
    return quantity;
}

}  // namespace strake
