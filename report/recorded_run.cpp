#include "report/recorded_run.hpp"

#include "casefile/read/resolved_case.hpp"
#include "core/text/file.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/design_table.hpp"
#include "optimize/run/fit.hpp"
#include "optimize/run/known_designs.hpp"
#include "optimize/run/samples.hpp"
#include "optimize/space/parameters.hpp"
#include "report/report_subject.hpp"
#include "report/run_report.hpp"

namespace strake {
namespace {

/// Folder of the case file that the run was started with.
std::filesystem::path case_dir(const Case& the_case) {
    return std::filesystem::absolute(the_case.command_dir.empty() ? the_case.dir() : the_case.command_dir)
        .lexically_normal();
}

SeriesPolicy series_policy(ParaView wanted) {
    switch (wanted) {
        case ParaView::every_accepted:
            return SeriesPolicy::every_accepted;
        case ParaView::best:
            return SeriesPolicy::best;
        case ParaView::none:
            return SeriesPolicy::none;
    }
    return SeriesPolicy::every_accepted;
}

KeepPolicy keep_policy(Keep wanted) {
    switch (wanted) {
        case Keep::all:
            return KeepPolicy::all;
        case Keep::failed:
            return KeepPolicy::failed;
        case Keep::best:
            return KeepPolicy::best;
        case Keep::none:
            return KeepPolicy::none;
    }
    return KeepPolicy::all;
}

/// The first lines of case.yaml, comments: what a run that has no journal yet, or no more, is started from.
std::string begin_note(const Case& the_case, bool is_fit, int meaning) {
    const std::string dir = case_dir(the_case).string();
    for (const char c : dir)
        if (static_cast<unsigned char>(c) < ' ' || c == 127) return "";
    return text("# ", is_fit ? "fit" : "run", " of a case in ", dir, "\n", meaning_note, meaning, "\n");
}

std::unique_ptr<Journal> new_journal(const BuiltProblem& built, const Case& the_case, RunFolder& folder, bool is_fit) {
    const Problem& problem = built.problem;
    JournalFacts facts;
    facts.case_yaml = resolved_case(the_case, the_case.output.dir, built.wrap);
    facts.case_dir = case_dir(the_case);
    facts.host = host_name();
    facts.is_fit = is_fit;
    facts.values = value_names(problem);
    facts.parameters = recorded_names(problem);
    facts.files = file_hashes(the_case);
    for (const char* companion : {"journal.sqlite-wal", "journal.sqlite-shm"}) folder.aside(companion);
    return Journal::create(folder.aside("journal.sqlite"), facts,
                           {0, problem.optimize.max_evaluations, problem.optimize.max_seconds});
}

/// Every event goes to the folder and to `also`.
RunEvents recorded(RunFolder& folder, const RunEvents& also, bool& has_evaluated) {
    RunEvents events = also;
    events.level = [&](const LevelStart& level) {
        if (also.level) also.level(level);
        folder.add(level);
    };
    events.evaluation = [&](const EvaluationRecord& record) {
        has_evaluated = true;
        if (also.evaluation) also.evaluation(record);
        folder.add(record);
    };
    events.accepted = [&](const AcceptedDesign& design) {
        if (also.accepted) also.accepted(design);
        folder.add(design);
    };
    events.sensitivities = [&](int evaluation, const Points& vertices, const Points& dJ_dv) {
        if (also.sensitivities) also.sensitivities(evaluation, vertices, dJ_dv);
        folder.add_sensitivities(evaluation, dJ_dv);
    };
    return events;
}

}  // namespace

RunResult recorded_run(const BuiltProblem& built, const Case& the_case, RunFolder& folder, bool is_fit,
                       const RunEvents& also, std::unique_ptr<Journal> journal,
                       const std::function<void(const std::string&)>& warn) {
    const Problem& problem = built.problem;
    bool has_evaluated = journal != nullptr;
    const RunEvents events = recorded(folder, also, has_evaluated);
    try {
        // Before the journal: a run that is killed in between can be started from it.
        const int meaning = journal ? journal->facts().meaning : JournalFacts().meaning;
        folder.write_case(begin_note(the_case, is_fit, meaning) +
                          resolved_case(the_case, the_case.output.dir, built.wrap));
        if (!journal) journal = new_journal(built, the_case, folder, is_fit);
        if (built.is_prepared) folder.write_start(problem.surface, built.format, built.repairs_csv);
        folder.begin(problem, value_names(problem), built.format, series_policy(the_case.output.paraview),
                     keep_policy(the_case.output.keep));
        if (is_fit) return fit(problem, events, journal.get());
        if (!problem.sample) return optimize(problem, events, journal.get());
        RunResult result = sample(problem, events, journal.get());
        if (result.samples->table->rows() > 0) folder.write_samples(*result.samples->table);
        return result;
    } catch (...) {
        journal.reset();
        std::error_code ignored;
        const bool has_paid = std::filesystem::exists(folder.folder() / "evaluations", ignored);
        if (!has_evaluated && !has_paid) {
            folder.discard();
        } else if (wants_report(the_case.output)) {
            const std::string why = make_report(built, the_case, folder.folder());
            if (!why.empty() && warn) warn(why);
        }
        throw;
    }
}

bool wants_report(const Case::Output& output) {
    // The case.yaml of a run states every default.
    const bool is_stated = output.report_is_stated && !output.is_resumed;
    return output.report && (is_stated || has_report_page());
}

std::string make_report(const BuiltProblem& built, const Case& the_case, const std::filesystem::path& folder) {
    try {
        ReportSubject subject = report_subject(the_case, &built);
        subject.is_over = true;
        write_report(folder, subject, folder / "report.html");
        return "";
    } catch (const std::exception& error) {
        return text("report.html could not be written: ", error.what());
    }
}

std::vector<std::string> value_names(const Problem& problem) {
    std::vector<std::string> names;
    for (const Quantity& quantity : problem.quantities)
        names.insert(names.end(), quantity.names.begin(), quantity.names.end());
    return names;
}

std::map<std::string, std::string> file_hashes(const Case& the_case) {
    std::map<std::string, std::string> hashes;
    for (const auto& [key, file] : files_of(the_case)) hashes[key] = content_hash(read_bytes(file));
    if (the_case.start_from && the_case.fit.empty() && !the_case.sample)
        if (const std::string known = known_designs_hash(*the_case.start_from); !known.empty())
            hashes[known_designs_key] = known;
    return hashes;
}

}  // namespace strake
