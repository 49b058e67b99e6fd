#include "cli/rebuild.hpp"

#include "casefile/load_case.hpp"
#include "casefile/read/resolved_case.hpp"
#include "cli/continuation.hpp"
#include "cli/say.hpp"
#include "core/error.hpp"
#include "core/text/file.hpp"
#include "core/text/shell_word.hpp"
#include "optimize/journal/salvage.hpp"
#include "optimize/run/history.hpp"
#include "report/recorded_run.hpp"

#include <algorithm>
#include <optional>

namespace strake::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* journal_files[] = {"journal.sqlite", "journal.sqlite-wal", "journal.sqlite-shm"};

std::string text_of(const fs::path& file) {
    std::error_code ignored;
    return fs::is_regular_file(file, ignored) ? read_bytes(file) : std::string();
}

/// Evaluations that history.csv lists.
int history_rows(const fs::path& dir) {
    const std::string history = text_of(dir / "history.csv");
    return std::max(0, static_cast<int>(std::count(history.begin(), history.end(), '\n')) - 1);
}

/// Folders of evaluations.
int evaluation_folders(const fs::path& dir) {
    int count = 0;
    std::error_code why;
    for (fs::directory_iterator at(dir / "evaluations", why), end; !why && at != end; at.increment(why)) ++count;
    return count;
}

std::optional<Beginning> beginning_in(const fs::path& dir) {
    const std::string yaml = text_of(dir / "case.yaml"), line = yaml.substr(0, yaml.find('\n'));
    for (const bool is_fit : {false, true}) {
        const std::string lead = text("# ", is_fit ? "fit" : "run", " of a case in ");
        if (line.starts_with(lead)) return Beginning{is_fit, line.substr(lead.size())};
    }
    return {};
}

JournalFacts facts_from(const Case& the_case, const Beginning& began, const fs::path& dir) {
    JournalFacts facts;
    facts.case_yaml = resolved_case(the_case, dir);
    facts.case_dir = began.case_dir;
    facts.is_fit = began.is_fit;
    facts.host = host_name();
    facts.meaning = written_meaning(dir);
    if (facts.meaning == 0) {
        facts.meaning = 1;
        say("note: {} does not say which version of Strake began the run: it goes on as before 0.2, where "
            "max_displacement bounds variables\n",
            printable((dir / "case.yaml").string(), 400));
    }
    const std::string history = text_of(dir / "history.csv");
    const HistoryNames names = history_names(history.substr(0, history.find('\n')));
    facts.values = names.values;
    facts.parameters = names.parameters;
    facts.files = file_hashes(the_case);
    return facts;
}

/// Where the damaged journal is kept: a name that is free.
fs::path kept_name(const fs::path& dir) {
    std::error_code why;
    fs::path name = dir / "journal.damaged.sqlite";
    for (int k = 2; fs::exists(name, why); ++k) name = dir / text("journal.damaged.", k, ".sqlite");
    return name;
}

/// The journal's files are renamed, and have their names again unless the new journal is there.
class SetAside {
public:
    SetAside(fs::path dir, fs::path kept) : dir_(std::move(dir)), kept_(std::move(kept)) {
        std::error_code why;
        for (const char* name : journal_files) {
            if (!fs::exists(dir_ / name, why)) continue;
            fs::rename(dir_ / name, kept_name_of(name), why);
            if (!why) continue;
            const std::string words = text((dir_ / name).string(), ": cannot be renamed: ", why.message());
            bring_back();
            throw OutputError(words);
        }
    }
    SetAside(const SetAside&) = delete;
    SetAside& operator=(const SetAside&) = delete;
    ~SetAside() {
        if (!is_done_) bring_back();
    }
    void done() { is_done_ = true; }

private:
    fs::path kept_name_of(const std::string& name) const {
        return kept_.string() + name.substr(std::string("journal.sqlite").size());
    }
    void bring_back() const {
        std::error_code ignored;
        for (const char* name : journal_files) {
            fs::remove(dir_ / name, ignored);
            if (fs::exists(kept_name_of(name), ignored)) fs::rename(kept_name_of(name), dir_ / name, ignored);
        }
    }
    fs::path dir_, kept_;
    bool is_done_ = false;
};

/// Where those of the journal are lost. A run that went on has had a larger limit than its case says.
std::vector<RunLimits> limits_from(const OptimizeOptions& options, int evaluations) {
    std::vector<RunLimits> limits{{0, options.max_evaluations, options.max_seconds}};
    if (evaluations > options.max_evaluations)
        limits.push_back({options.max_evaluations, evaluations, options.max_seconds});
    return limits;
}

/// With every limit where it came into force: a search ends a level by the limit of its time.
std::unique_ptr<Journal> journal_with(const fs::path& file, const JournalFacts& facts,
                                      const std::vector<RunLimits>& limits, const SalvagedJournal& saved) {
    std::unique_ptr<Journal> journal = Journal::create(file, facts, limits[0]);
    for (std::size_t k = 1; k < limits.size(); ++k) journal->add(limits[k]);
    for (const JournalCall& call : saved.calls) journal->add(call);
    for (const JournalEvaluation& evaluation : saved.evaluations) journal->add(evaluation);
    return journal;
}

std::string typed(const fs::path& dir) { return typed_path(dir.string()); }

}  // namespace

bool has_evaluated_nothing(const fs::path& dir) { return history_rows(dir) == 0 && evaluation_folders(dir) == 0; }

bool says_how_it_began(const fs::path& dir) { return beginning_in(dir).has_value(); }

Beginning beginning_of(const fs::path& dir) {
    if (const auto began = beginning_in(dir)) return *began;
    throw InvalidInput(text(printable(dir.string(), 400),
                            ": the run in it ended before it had written its case; `strake run CASE --out ", typed(dir),
                            "` starts it"));
}

void clear_journal(const fs::path& dir) {
    std::error_code why;
    for (const char* name : journal_files)
        if (!fs::remove(dir / name, why) && why) throw OutputError(text((dir / name).string(), ": ", why.message()));
}

std::string rebuild_words(const fs::path& dir) {
    return text("; history.csv lists ", history_rows(dir), " evaluations, and ", evaluation_folders(dir),
                " folders of evaluations are there: `strake resume ", typed(dir),
                " --rebuild` makes a new journal from what can still be read, and takes the programs' answers from "
                "these folders");
}

void check_against_history(const Journal& journal, const fs::path& dir) {
    const int has = static_cast<int>(journal.evaluations().size()), rows = history_rows(dir);
    // One more where the last evaluation was a failure that is asked again.
    if (rows > has + 1)
        throw InputError(text((dir / "journal.sqlite").string(), ": holds ", has,
                              " evaluations: the journal's log is lost or damaged", rebuild_words(dir)));
}

std::unique_ptr<Journal> rebuilt_journal(const fs::path& dir) {
    const fs::path kept = kept_name(dir);
    std::error_code why;
    const int rows = history_rows(dir), folders = evaluation_folders(dir);
    constexpr int more = 1000;  // parallel evaluations ahead of the history's last one
    const SalvagedJournal saved = salvaged_journal(dir / "journal.sqlite", rows + more);
    if (saved.facts && !fs::exists(dir / "case.yaml", why)) write_atomically(dir / "case.yaml", saved.facts->case_yaml);
    const Beginning began = saved.facts ? Beginning{saved.facts->is_fit, saved.facts->case_dir} : beginning_of(dir);
    const Case the_case = load_case(dir / "case.yaml", began.is_fit ? Purpose::fit : Purpose::run, began.case_dir);
    const JournalFacts facts = saved.facts ? *saved.facts : facts_from(the_case, began, dir);
    std::vector<RunLimits> limits = saved.limits;
    if (limits.empty()) limits = limits_from(the_case.optimize, rows);
    SetAside old(dir, kept);
    std::unique_ptr<Journal> journal = journal_with(dir / "journal.sqlite", facts, limits, saved);
    old.done();
    const bool is_kept = fs::exists(kept, why);
    say("strake: rebuilt the journal: {} of {} evaluations and {} answers of programs were read from the damaged "
        "one{}; {} "
        "folders of evaluations are searched for answers; what is in neither is evaluated again\n",
        saved.evaluations.size(), rows, saved.calls.size(),
        is_kept ? ", kept as " + printable(kept.string(), 400) : std::string(), folders);
    return journal;
}

}  // namespace strake::cli
