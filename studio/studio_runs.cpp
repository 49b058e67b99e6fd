#include "casefile/yaml/value.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/text/file.hpp"
#include "report/json_number.hpp"
#include "report/run_lock.hpp"
#include "studio/convergence.hpp"
#include "studio/file_places.hpp"
#include "studio/studio_impl.hpp"

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstring>

/// Commands that the page starts, each as a process of its own: init, check, run and resume.
namespace strake {

namespace fs = std::filesystem;

void Studio::Impl::need_write() const {
    if (options.read_only) throw Declined("this studio is read-only");
}

void Studio::Impl::need_no_task() {
    if (task && !task->ended()) throw Declined(text("'", task_name, "' is still at work"));
}

fs::path Studio::Impl::need_saved_case() const {
    std::error_code ignored;
    if (case_file.empty() || !fs::exists(case_file, ignored)) throw Declined("save the case first");
    return case_file;
}

Studio::Impl::Json Studio::Impl::task_state() {
    if (!task) return nullptr;
    Json facts{{"name", task_name}, {"is_running", false}, {"status", nullptr}, {"messages", ""}, {"output", ""}};
    if (const auto status = task->ended()) {
        facts["status"] = *status;
        facts["messages"] = task->messages();
        facts["output"] = task->output();
    } else {
        facts["is_running"] = true;
    }
    return facts;
}

/// All that the page shows beside the surface; asked for several times a second while it is visible.
Studio::Impl::Json Studio::Impl::state(const WebRequest& request) {
    int from = 0;
    if (const auto found = request.query.find("from"); found != request.query.end())
        std::from_chars(found->second.data(), found->second.data() + found->second.size(), from);
    std::shared_ptr<RunWatch> watch;
    Json facts;
    {
        const std::lock_guard lock(busy);
        if (task && task->ended() == 0 && !task_file.empty()) {  // init has written a case
            to_open = task_file;
            is_opening = true;
            task_file.clear();
            wanted.notify_all();
        }
        watch = run;
        facts = {{"folder", folder.string()},
                 {"read_only", options.read_only},
                 {"version", version},
                 {"is_opening", is_opening},
                 {"trouble", trouble},
                 {"has_surface", subject != nullptr},
                 {"surface", subject ? subject->surface.filename().string() : ""},
                 {"case", case_file.filename().string()},
                 {"is_second", is_second},
                 {"task", task_state()},
                 {"disk_mark", nullptr},
                 {"run", nullptr},
                 {"run_messages", ""}};
        std::error_code ignored;
        if (!case_file.empty() && fs::exists(case_file, ignored))
            facts["disk_mark"] = content_mark(read_case_file(case_file.string()));
        if (run_child && run_child->ended()) facts["run_messages"] = run_child->messages();
    }
    if (!watch) return facts;
    try {
        facts["run"] = watch->look(from);
    } catch (const std::exception& error) {
        facts["run"] = {{"folder", watch->folder().string()},
                        {"status", "starting"},
                        {"reason", error.what()},
                        {"rows", Json::array()},
                        {"from", from}};
    }
    return facts;
}

Studio::Impl::Json Studio::Impl::propose(const Asked& asked) {
    const auto shown = need_subject();
    const fs::path file = inside(text_in(asked, "name"));
    std::error_code ignored;
    if (fs::exists(fs::symlink_status(file, ignored)))
        throw Declined(text(file.filename().string(), " exists already: open it, or choose another name"));
    const std::lock_guard lock(busy);
    need_no_task();
    task = std::make_unique<Child>(
        folder, std::vector<std::string>{"init", shown->surface.string(), "-o", file.string(), "--json"});
    task_name = "propose a case";
    task_file = file;
    return {{"ok", true}};
}

Studio::Impl::Json Studio::Impl::full_check(const Asked&) {
    const std::lock_guard lock(busy);
    need_no_task();
    task = std::make_unique<Child>(folder,
                                   std::vector<std::string>{"check", need_saved_case().string(), "--json", "--quick"});
    task_name = "check";
    task_file.clear();
    return {{"ok", true}};
}

Studio::Impl::Json Studio::Impl::start_run(const Asked& asked) {
    const std::lock_guard lock(busy);
    if (run_child && !run_child->ended()) throw Declined("a run that this studio started is still at work");
    const fs::path file = need_saved_case();
    std::vector<std::string> settings;
    if (asked.contains("evaluations")) {
        if (!asked["evaluations"].is_number_integer()) throw InvalidInput("evaluations must be a whole number");
        settings.push_back(text("optimize.budget.evaluations=", asked["evaluations"].get<long>()));
    }
    begin_run(file, {}, settings);
    std::error_code ignored;
    return {{"folder", fs::relative(run->folder(), folder, ignored).string()}};
}

/// @pre `busy` is locked
void Studio::Impl::begin_run(const fs::path& file, fs::path out, const std::vector<std::string>& settings) {
    const std::string stem = file.stem() == "case" && subject ? subject->surface.stem().string() : file.stem().string();
    std::error_code ignored;
    for (int k = 1; out.empty(); ++k) {
        std::string number = std::to_string(k);
        const fs::path next =
            folder / "runs" / (stem + "-" + std::string(3 - std::min<std::size_t>(3, number.size()), '0') + number);
        if (!fs::exists(next, ignored)) out = next;
    }
    std::vector<std::string> arguments{"run", fs::absolute(file).string(), "--out", fs::absolute(out).string(),
                                       "--quiet"};
    for (const std::string& setting : settings) arguments.insert(arguments.end(), {"--set", setting});
    run_child = std::make_unique<Child>(folder, arguments);
    run = std::make_shared<RunWatch>(fs::absolute(out));
}

/// Ends in order, and can be resumed. Also a run that was started elsewhere on this machine.
Studio::Impl::Json Studio::Impl::stop_run() {
    const std::lock_guard lock(busy);
    if (run_child && !run_child->ended()) {
        run_child->interrupt();
        return {{"ok", true}};
    }
    if (!run) throw Declined("no run is open");
    const auto holder = lock_holder(run->folder());
    if (!holder) throw Declined("the run is not at work");
    int process = 0;
    std::from_chars(holder->process.data(), holder->process.data() + holder->process.size(), process);
    if (holder->host != host_name() || process <= 1)
        throw Declined(text("the run is at work as ", holder->words(), "; stop it there"));
    if (::kill(process, SIGINT) != 0)
        throw Declined(text("the run cannot be stopped from here: ", std::strerror(errno)));
    return {{"ok", true}};
}

Studio::Impl::Json Studio::Impl::resume_run(const Asked& asked) {
    const std::lock_guard lock(busy);
    if (!run) throw Declined("no run is open");
    if ((run_child && !run_child->ended()) || lock_holder(run->folder())) throw Declined("the run is at work");
    std::vector<std::string> arguments{"resume", run->folder().string(), "--quiet"};
    if (asked.contains("evaluations")) {
        if (!asked["evaluations"].is_number_unsigned()) throw InvalidInput("evaluations must be a whole number");
        arguments.insert(arguments.end(), {"--evaluations", text("+", asked["evaluations"].get<unsigned long>())});
    }
    run_child = std::make_unique<Child>(folder, arguments);
    run = std::make_shared<RunWatch>(run->folder());
    return {{"ok", true}};
}

Studio::Impl::Json Studio::Impl::attach(const Asked& asked) {
    const fs::path path = inside(text_in(asked, "name"));
    std::error_code ignored;
    if (!fs::exists(path / "journal.sqlite", ignored)) throw InvalidInput("that is not a run folder");
    const std::lock_guard lock(busy);
    run = std::make_shared<RunWatch>(path);
    return {{"ok", true}};
}

WebAnswer Studio::Impl::report() {
    std::shared_ptr<RunWatch> watch;
    {
        const std::lock_guard lock(busy);
        watch = run;
    }
    std::error_code ignored;
    if (!watch || !fs::is_regular_file(watch->folder() / "report.html", ignored) ||
        !lies_in(watch->folder() / "report.html", watch->folder()))
        return {404, "text/plain", "there is no report yet: it is written when the run ends\n"};
    return {200, "text/html; charset=utf-8", read_bytes(watch->folder() / "report.html"), true};
}

/// Of a run; empty: there is none.
static fs::path best_file(const fs::path& run) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(run, ignored))
        if (entry.path().stem() == "best" && entry.is_regular_file(ignored) && lies_in(entry.path(), run))
            return entry.path();
    return {};
}

/// Positions of the best shape so far, as those of /api/surface: n x 3 numbers relative to its middle.
WebAnswer Studio::Impl::best_shape() {
    const auto shown = need_subject();
    std::shared_ptr<RunWatch> watch;
    {
        const std::lock_guard lock(busy);
        watch = run;
    }
    if (!watch) return {404, "text/plain", "no run is open\n"};
    const fs::path best = best_file(watch->folder());
    if (best.empty()) return {404, "text/plain", "there is no best shape yet\n"};
    return shape_answer(best, *shown);
}

WebAnswer Studio::Impl::shape_answer(const fs::path& file, const Subject& shown) {
    const TriMesh shape = read_surface(file).mesh;
    const TriMesh& start = shown.ground.start.mesh;
    if (shape.num_vertices() != start.num_vertices() || shape.triangles != start.triangles)
        return {404, "text/plain", "that shape has other triangles than the surface shown\n"};
    return {200, "application/octet-stream", centred_positions(shape.vertices, start)};
}

/// {designs: [{run, evaluation}]}: the shapes that the runs of the folder have kept; evaluation 0 is the best one.
Studio::Impl::Json Studio::Impl::designs() {
    constexpr std::size_t most = 400;
    Json list = Json::array();
    std::vector<fs::path> folders;
    std::error_code ignored;
    std::shared_ptr<RunWatch> watch;
    {
        const std::lock_guard lock(busy);
        watch = run;
    }
    if (watch) folders.push_back(watch->folder());
    for (const auto& entry : fs::directory_iterator(folder / "runs", ignored))
        if (fs::exists(entry.path() / "journal.sqlite", ignored) && lies_in(entry.path(), folder) &&
            (!watch || entry.path() != watch->folder()))
            folders.push_back(entry.path());
    if (folders.size() > 1) std::sort(folders.begin() + (watch ? 1 : 0), folders.end());
    for (const fs::path& one : folders) {
        const std::string name = fs::relative(one, folder, ignored).string();
        list.push_back({{"run", name}, {"evaluation", 0}});
        std::vector<int> numbers;
        for (const auto& entry : fs::directory_iterator(one / "series", ignored)) {
            const std::string file = entry.path().filename().string();
            int number = 0;
            constexpr std::size_t before = 7;  // of "design_"
            if (!file.starts_with("design_") || !file.ends_with(".vtp")) continue;
            std::from_chars(file.data() + before, file.data() + file.size(), number);
            if (number > 0) numbers.push_back(number);
        }
        std::sort(numbers.begin(), numbers.end());
        for (const int number : numbers)
            if (list.size() < most) list.push_back({{"run", name}, {"evaluation", number}});
    }
    return {{"designs", std::move(list)}};
}

/// {files: [{name, evaluation, program}] newest first, shown, names, columns}: how the solver of one evaluation
/// converges, of the newest one unless the request names another.
Studio::Impl::Json Studio::Impl::convergence(const WebRequest& request) {
    std::shared_ptr<RunWatch> watch;
    {
        const std::lock_guard lock(busy);
        watch = run;
    }
    Json answer{{"files", Json::array()}, {"shown", ""}, {"names", Json::array()}, {"columns", Json::array()}};
    if (!watch) return answer;
    const auto files = convergence_files(watch->folder(), watch->convergence_of());
    if (files.empty()) return answer;
    const auto asked = request.query.find("name");
    const ConvergenceFile* shown = &files.front();
    for (const ConvergenceFile& one : files) {
        answer["files"].push_back({{"name", one.name}, {"evaluation", one.evaluation}, {"program", one.program}});
        if (asked != request.query.end() && asked->second == one.name) shown = &one;
    }
    constexpr std::uintmax_t max_bytes = 64 << 20;
    std::error_code gone;
    if (fs::file_size(shown->file, gone) > max_bytes || gone) return answer;
    const ConvergenceTable table = read_convergence(read_bytes(shown->file));
    answer["shown"] = shown->name;
    answer["names"] = table.names;
    for (const std::vector<double>& column : table.columns) {
        Json values = Json::array();
        for (const double value : column) values.push_back(json_number(value));
        answer["columns"].push_back(std::move(values));
    }
    return answer;
}

/// One of them, as positions of /api/surface.
WebAnswer Studio::Impl::design(const WebRequest& request) {
    const auto shown = need_subject();
    const auto asked_run = request.query.find("run"), asked_number = request.query.find("evaluation");
    int number = -1;
    if (asked_number != request.query.end())
        std::from_chars(asked_number->second.data(), asked_number->second.data() + asked_number->second.size(), number);
    if (asked_run == request.query.end() || number < 0) return {404, "text/plain", "run and evaluation are missing\n"};
    const fs::path from = inside(asked_run->second);
    std::error_code ignored;
    if (!fs::exists(from / "journal.sqlite", ignored)) return {404, "text/plain", "that is not a run folder\n"};
    std::string digits = std::to_string(number);
    if (digits.size() < 6) digits.insert(0, 6 - digits.size(), '0');
    fs::path file = from / "series" / ("design_" + digits + ".vtp");
    if (number == 0) file = best_file(from);
    if (!fs::is_regular_file(file, ignored) || !lies_in(file, from))
        return {404, "text/plain", "that shape was not kept\n"};
    return shape_answer(file, *shown);
}

}  // namespace strake
