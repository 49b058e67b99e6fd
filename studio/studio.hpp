#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// `strake studio`: a page in the browser in which regions are chosen, a case is written, and a run is started and
/// watched.
namespace strake {

struct StudioOptions {
    std::filesystem::path target;  ///< surface, case, run folder or any folder; empty: the present one
    int port = 0;                  ///< 0: any free one
    bool read_only = false;        ///< nothing is written, started or stopped
    bool needs_page = true;        ///< false: answers requests in a program that was built without the page
    bool new_address = false;      ///< not the address that the last studio of this folder had
};

/// All files that it reads by name and all that it writes lie in one folder: that of the surface or case, or the run
/// folder. Programs that a case names run only in a run that the page has started.
class Studio {
public:
    /// Binds the port and begins to read the target. @throws InputError: there is no such file or folder; OutputError:
    /// no port, or the page is missing.
    explicit Studio(const StudioOptions& options);
    ~Studio();  ///< runs that it started go on; waits for a file that is being read
    /// Answers nothing from now on. @return whether it still reads a file: the destructor would wait for that
    bool leave();

    std::string url() const;
    /// The answer to the bytes of a request as they come from a socket: to be tried without one.
    std::string answer_bytes(const std::string& request);
    int port() const;
    /// Of another studio on the same folder; empty: there is none.
    std::string notice() const;
    /// Starts `strake run` of a case, which the page shows. @param out empty: the next free folder below runs/
    /// @param settings KEY=VALUE of --set
    void run(const std::filesystem::path& case_file, const std::filesystem::path& out,
             const std::vector<std::string>& settings);
    std::optional<int> run_status() const;  ///< of that run's exit; nothing: it is at work
    std::string run_messages() const;
    void interrupt_run();  ///< it ends in order
    /// "the run in FOLDER goes on": what continues when the studio ends; empty: nothing.
    std::string continuing() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace strake
