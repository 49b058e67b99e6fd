#include "casefile/load_case.hpp"
#include "cli/commands.hpp"
#include "cli/continuation.hpp"
#include "cli/detail.hpp"
#include "cli/outputs.hpp"
#include "optimize/journal/journal.hpp"
#include "report/report_subject.hpp"

#include <fmt/core.h>
#include <memory>

namespace strake::cli {
namespace {

namespace fs = std::filesystem;

struct ReportArguments {
    std::string folder, out;
};

/// What the folder lacks comes from the case, if that can still be read.
ReportSubject subject_of(const fs::path& folder, const JournalFacts& facts) {
    const Purpose purpose = facts.is_fit ? Purpose::fit : Purpose::run;
    ReportSubject subject;
    subject.title = "run";
    try {
        Case the_case = load_case(folder / "case.yaml", purpose, facts.case_dir);
        the_case.output.dir = folder;
        the_case.output.is_resumed = true;
        keep_meaning(the_case, facts.meaning);
        subject = report_subject(the_case, nullptr);
        if (has_shapes(folder) && the_case.planform.empty()) return subject;
        const BuiltProblem built = build_problem(the_case, purpose);
        subject = report_subject(the_case, &built);
    } catch (const std::exception& error) {
        subject.notes.push_back(text("The case can no longer be read: ", error.what()));
    }
    return subject;
}

void report(const ReportArguments& args) {
    if (!has_report_page()) throw OutputError(report_page_missing());
    const fs::path folder = args.folder, journal = folder / "journal.sqlite";
    std::error_code ignored;
    if (!fs::exists(folder, ignored)) throw InvalidInput(printable(args.folder, 400) + ": no such folder");
    if (!fs::exists(journal, ignored))
        throw InvalidInput(text(printable(args.folder, 400), ": is not a run folder (it has no journal.sqlite)"));
    const fs::path out = args.out.empty() ? folder / "report.html" : fs::path(args.out);
    check_outputs({out}, {journal, folder / "run.json", folder / "case.yaml", folder / "history.csv"});
    write_report(folder, subject_of(folder, Journal::look(journal)->facts()), out);
    fmt::print("{}\n", printable(out.string(), 400));
}

}  // namespace

void add_report(CLI::App& app) {
    auto args = std::make_shared<ReportArguments>();
    CLI::App* command =
        app.add_subcommand("report", "write a run as one page for the browser, also while it is running");
    command->add_option("folder", args->folder, "folder of the run")->required();
    command->add_option("-o,--out,--output", args->out, "the page (default: report.html in the folder)");
    command->callback([args] { report(*args); });
}

}  // namespace strake::cli
