#pragma once
#include "studio/bench_worker.hpp"
#include "studio/child.hpp"
#include "studio/run_watch.hpp"
#include "studio/studio.hpp"
#include "studio/subject.hpp"
#include "studio/web_server.hpp"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

/// Between the studio's files; not for others.
namespace strake {

/// The caller asks for something that cannot be done now; the text goes to the page.
struct Declined : InvalidInput {
    using InvalidInput::InvalidInput;
};

struct Studio::Impl {
    using Json = nlohmann::ordered_json;
    using Asked = nlohmann::json;

    StudioOptions options;
    std::filesystem::path folder;  ///< canonical
    int folder_lock = -1;
    bool is_second = false;

    std::mutex busy;  ///< of all below
    std::shared_ptr<const Subject> subject;
    std::filesystem::path case_file;  ///< open in the editor; empty: none
    std::string case_text, trouble;
    std::vector<std::string> steps_done;
    int version = 0;  ///< of subject and case
    std::shared_ptr<RunWatch> run;
    std::unique_ptr<Child> run_child, task;
    std::string task_name;
    std::filesystem::path task_file;

    // The reader: the newest request overtakes older ones.
    std::condition_variable wanted;
    std::filesystem::path to_open;
    bool is_opening = false, ends = false;
    std::thread reader;

    std::unique_ptr<BenchWorker> worker;  ///< made when it is needed first, and never replaced

    std::unique_ptr<WebServer> server;  ///< the last member: its threads use all others

    explicit Impl(const StudioOptions& wishes);
    ~Impl();
    bool leave();

    void listen();
    WebAnswer answer(const WebRequest& request);
    WebAnswer get(const WebRequest& request);
    Json post(const Asked& asked);

    // studio_files.cpp
    std::filesystem::path inside(const std::string& name) const;
    Json files() const;
    void open_later(const std::filesystem::path& file);
    void read_targets();
    void open_now(const std::filesystem::path& file);
    void open_case(const std::filesystem::path& file);
    Json save(const Asked& asked);

    // studio_case.cpp
    std::filesystem::path case_path();  ///< of the text in the editor; a new one will be the folder's case.yaml
    Json check(const Asked& asked);
    Json choose(const Asked& asked);
    Json put_region(const Asked& asked);
    std::string with_found_wing(std::string yaml, const Subject& shown, std::vector<ChoiceStep>& steps);
    void write_list(const std::string& name, const std::vector<int>& numbers, const std::string& known_from);
    Json form(const Asked& asked);
    Json set_values(const Asked& asked);
    std::shared_ptr<const Subject> need_subject();

    // studio_feel.cpp
    Json feel(const Asked& asked);
    Json felt_state();
    WebAnswer felt(const std::string& what, const WebRequest& request);

    // studio_runs.cpp
    Json state(const WebRequest& request);
    Json propose(const Asked& asked);
    Json full_check(const Asked& asked);
    Json start_run(const Asked& asked);
    void begin_run(const std::filesystem::path& case_file, std::filesystem::path out,
                   const std::vector<std::string>& settings);
    Json stop_run();
    Json resume_run(const Asked& asked);
    Json attach(const Asked& asked);
    WebAnswer report();
    WebAnswer best_shape();
    Json convergence(const WebRequest& request);
    Json designs();
    WebAnswer design(const WebRequest& request);
    WebAnswer shape_answer(const std::filesystem::path& file, const Subject& shown);
    Json task_state();
    void need_write() const;
    void need_no_task();
    std::filesystem::path need_saved_case() const;
};

/// A text member of what the page sent. @throws InvalidInput: it is missing or no text.
std::string text_in(const nlohmann::json& asked, const char* key);
/// As `positions` of /api/surface: n x 3 numbers relative to the middle of the start's box.
std::string centred_positions(const Points& vertices, const TriMesh& start);
std::string content_mark(const std::string& bytes);  ///< tells contents apart

}  // namespace strake
