#pragma once
#include <filesystem>
#include <memory>
#include <string>

/// `strake studio`: a page in the browser in which regions are chosen, a case is written, and a run is started and
/// watched.
namespace strake {

struct StudioOptions {
    std::filesystem::path target;  ///< surface, case, run folder or any folder; empty: the present one
    int port = 0;                  ///< 0: any free one
    bool read_only = false;        ///< nothing is written, started or stopped
};

/// All files that it reads by name and all that it writes lie in one folder: that of the surface or case, or the run
/// folder. Programs that a case names run only in a run that the page has started.
class Studio {
public:
    /// Binds the port and begins to read the target. @throws InputError: there is no such file or folder; OutputError:
    /// no port, or the page is missing.
    explicit Studio(const StudioOptions& options);
    ~Studio();  ///< runs that it started go on

    std::string url() const;
    int port() const;
    /// Of another studio on the same folder; empty: there is none.
    std::string notice() const;
    /// "the run in FOLDER goes on": what continues when the studio ends; empty: nothing.
    std::string continuing() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace strake
