#include "optimize/run/known_designs.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/text/csv_columns.hpp"
#include "core/text/file.hpp"
#include "optimize/journal/journal.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace strake {
namespace {

using Eigen::VectorXd;

/// What the folder of a run says of a level: names, kinds and units of its variables, and its evaluations.
struct RecordedLevel {
    std::unique_ptr<Journal> journal;
    int best = 0;  ///< number of the evaluation
    std::vector<std::string> names;
    std::vector<double> units;
    bool has_strains = false;
    std::vector<const JournalEvaluation*> designs;  ///< the best one first
};

void read_variables(const std::filesystem::path& file, RecordedLevel& level) {
    std::istringstream lines(read_bytes(file));
    std::string line;
    std::getline(lines, line);
    const std::string first = line;
    const std::vector<std::string_view> header = csv_fields(first);
    const int name = column_named(header, "name"), kind = column_named(header, "kind"),
              unit = column_named(header, "unit");
    while (std::getline(lines, line)) {
        const std::vector<std::string_view> row = csv_fields(line);
        double size = 0;
        if (name >= 0 && kind >= 0 && unit >= 0 && row.size() == header.size()) {
            const std::string_view word = row[static_cast<std::size_t>(unit)];
            std::from_chars(word.data(), word.data() + word.size(), size);
        }
        if (!(std::isfinite(size) && size > 0))
            throw InputError(text(file.string(), ": line ", level.names.size() + 2,
                                  " is no variable with its unit; restore the file, or remove optimize.start_from"));
        level.names.emplace_back(row[static_cast<std::size_t>(name)]);
        level.units.push_back(size);
        level.has_strains |= row[static_cast<std::size_t>(kind)] == "strain";
    }
}

/// A step that did not converge says nothing of its design.
bool tells_something(const JournalEvaluation& e) {
    return e.status == "ok" || e.status == "quantity_failed" || e.status == "invalid";
}

/// Nothing: there is no journal, or it is that of a fit.
std::optional<RecordedLevel> recorded_level(const std::filesystem::path& folder, const StoredDesign& best) {
    std::error_code ignored;
    const std::filesystem::path file = folder / "journal.sqlite",
                                variables = folder / "levels" / text("variables_", best.level, ".csv");
    if (!std::filesystem::exists(file, ignored) || !std::filesystem::exists(variables, ignored)) return {};
    RecordedLevel level;
    level.journal = Journal::look(file);
    level.best = best.evaluation;
    const JournalEvaluation* there = level.journal->find(best.evaluation);
    if (level.journal->facts().is_fit || !there || there->status != "ok") return {};
    read_variables(variables, level);
    if (static_cast<Eigen::Index>(level.names.size()) != there->x.size()) return {};
    level.designs.push_back(there);
    for (const JournalEvaluation& e : level.journal->evaluations())
        if (e.number != there->number && e.level == there->level && e.x.size() == there->x.size() && tells_something(e))
            level.designs.push_back(&e);
    return level;
}

/// Why values of the problem are not those of the same names there; empty: they are.
std::string other_values(const RecordedLevel& level, const Problem& problem) {
    const JournalFacts& facts = level.journal->facts();
    for (const Quantity& quantity : problem.quantities) {
        for (const std::string& name : quantity.names)
            if (std::ranges::find(facts.values, name) == facts.values.end())
                return text("there is no value called '", name,
                            "'; give it the name that it has there, or sample again");
        if (quantity.program.empty()) continue;
        const auto call = level.journal->find_call(level.best, quantity.names[0]);
        // A table of the user's own has values that no program of Strake has given.
        if (call ? call->program != content_hash(quantity.program) : !facts.files.contains("sample.table"))
            return text("the program of '", quantity.names[0],
                        "' was called by another command there; use the same command, or sample again");
    }
    for (const ProgramParameter& parameter : problem.program_parameters)
        if (std::ranges::find(level.names, parameter.name) == level.names.end())
            return text("there is no variable called '", parameter.name, "'; remove it, or sample again with it");
    return "";
}

bool is_start(const StoredDesign& start, const QuantityRequest& request) {
    const Points& here = request.surface.vertices;
    const auto has = [&](const auto& parameter) {
        return std::ranges::find(start.parameters, parameter) != start.parameters.end();
    };
    return here.rows() == start.vertices.rows() && std::ranges::all_of(request.parameters, has) &&
           (here - start.vertices).rowwise().norm().maxCoeff() <= inheritance_tolerance * box_diagonal(request.surface);
}

}  // namespace

KnownDesigns known_designs(const Problem& problem, const std::filesystem::path& folder) {
    const auto level = recorded_level(folder, *problem.start);
    if (!level) return {};
    const auto refused = [&](const std::string& why) {
        return KnownDesigns{nullptr, text("the designs of ", folder.string(), " are not used: ", why)};
    };
    if (const std::string why = other_values(*level, problem); !why.empty()) return refused(why);
    if (level->has_strains) return refused("strain variables do not add up; sample without them to use designs");
    auto table = std::make_shared<DesignTable>();
    table->name = folder.string();
    table->variables = level->names;
    for (const Quantity& quantity : problem.quantities)
        table->values.insert(table->values.end(), quantity.names.begin(), quantity.names.end());
    const auto rows = static_cast<Eigen::Index>(level->designs.size());
    const VectorXd unit = VectorXd::Map(level->units.data(), static_cast<Eigen::Index>(level->units.size()));
    table->designs.resize(rows, unit.size());
    table->given.setConstant(rows, static_cast<Eigen::Index>(table->values.size()),
                             std::numeric_limits<double>::quiet_NaN());
    const std::vector<std::string>& names = level->journal->facts().values;
    for (Eigen::Index i = 0; i < rows; ++i) {
        const JournalEvaluation& e = *level->designs[static_cast<std::size_t>(i)];
        table->designs.row(i) = e.x.cwiseProduct(unit);
        table->status.push_back(e.status);
        for (std::size_t k = 0; k < table->values.size() && e.status == "ok"; ++k)
            table->given(i, static_cast<Eigen::Index>(k)) =
                e.values[static_cast<std::size_t>(std::ranges::find(names, table->values[k]) - names.begin())];
    }
    return {table, ""};
}

std::string known_designs_hash(const std::filesystem::path& folder) {
    const auto level = recorded_level(folder, read_design(folder / "levels" / "best.design"));
    if (!level) return "";
    std::string bytes;
    const auto add = [&](const double* data, std::size_t size) {
        bytes.append(reinterpret_cast<const char*>(data), size * sizeof(double));
    };
    for (const JournalEvaluation* e : level->designs) {
        add(e->x.data(), static_cast<std::size_t>(e->x.size()));
        add(e->values.data(), e->values.size());
    }
    return content_hash(bytes);
}

void answer_start(Problem& problem) {
    std::size_t first = 0;
    for (Quantity& quantity : problem.quantities) {
        const std::size_t at = first;
        first += quantity.names.size();
        if (quantity.program.empty() || !quantity.cache.empty()) continue;  // a cache answers by itself
        QuantityResult known;
        for (std::size_t k = at; k < first; ++k)
            known.values.push_back(problem.table->given(0, static_cast<Eigen::Index>(k)));
        known.remarks = {text(quantity.names[0], " is known from evaluation ", problem.start->evaluation, " of ",
                              problem.table->name, ": the program was not called")};
        quantity.evaluate = [inner = quantity.evaluate, start = problem.start,
                             known = std::move(known)](const QuantityRequest& request) {
            const bool asks_for_it = request.evaluation == 1 && !request.want_sensitivities;
            return asks_for_it && is_start(*start, request) ? known : inner(request);
        };
    }
}

}  // namespace strake
