#pragma once
#include "core/formats/io.hpp"
#include "core/formats/vtp.hpp"
#include "optimize/run/history.hpp"
#include "report/evaluation_folders.hpp"
#include "report/run_lock.hpp"

#include <filesystem>
#include <memory>
#include <optional>

/// The folder of a run: case.yaml, history.csv, levels/, series.pvd + series/*.vtp with series.py,
/// best.FORMAT, run.json. Shapes get their names here, those of single evaluations in `evaluation_folders.hpp`.
/// Everything but history.csv, which grows row by row, is written atomically.
namespace strake {

enum class SeriesPolicy { every_accepted, best, none };

class RunFolder {
public:
    /// Makes the folder and locks it for the lifetime of the object. @throws OutputError if it exists and is not empty,
    /// with the remedy; or cannot be made. @param is_continued the folder of an earlier run, whose records are
    /// completed.
    explicit RunFolder(const std::filesystem::path& folder, bool is_continued = false);

    void write_case(const std::string& yaml);
    /// start.FORMAT, a surface that differs from the file's; and start-repairs.csv if `repairs_csv` is not empty.
    void write_start(const TriMesh& surface, SurfaceFormat format, const std::string& repairs_csv);

    /// Starts the records. `problem` must outlive the folder.
    void begin(const Problem& problem, const std::vector<std::string>& value_names, SurfaceFormat format,
               SeriesPolicy policy, KeepPolicy keep = KeepPolicy::all);

    void add(const EvaluationRecord& record);
    /// levels/labels_K.csv (patch of each triangle, file order) and levels/variables_K.csv.
    void add(const LevelStart& level);
    /// best.FORMAT, levels/best.csv, levels/best.design (for `start_from`), and the next data set of the series.
    void add(const AcceptedDesign& design);
    /// Adds them to the design's data set, if it has one.
    void add_sensitivities(int evaluation, const Points& dJ_dv);
    /// During a replay: best designs of evaluations before this one are outdated and not written again.
    void begin_best_at(int evaluation) { best_from_ = evaluation; }
    /// A file that others keep there: not listed among the files, but removed by `discard`.
    std::filesystem::path aside(const std::string& name);

    /// A file that others write after the end: listed among the files, and removed by `discard`.
    void list_file(const std::string& name) { remember(name); }

    /// samples.csv, for `start_from`.
    void write_samples(const DesignTable& table);
    /// Completes series and run.json.
    void finish(const RunResult& result);
    /// Removes everything written and the folders made, before the first design: as if there had been no run.
    void discard();

    const std::filesystem::path& folder() const { return folder_; }
    /// Names of the files written so far, relative to the folder.
    const std::vector<std::string>& files() const { return files_; }
    /// Messages about invalid fields of programs and folders that could not be removed, each once.
    const std::vector<std::string>& problems() const { return problems_; }

private:
    void make_folder(const std::filesystem::path& folder);  ///< with its parents
    void write(const std::string& name, const std::string& bytes);
    /// One design for ParaView.
    struct DataSet {
        Points vertices, dJ_dv;
        Points load;                ///< traction at the vertices, n x 3, 1/length; empty: none
        std::vector<int> patch;     ///< of each triangle, on the level of the design; empty: unknown
        std::vector<Field> fields;  ///< of objectives
    };
    std::vector<int> on_surface(const std::vector<int>& label) const;
    DataSet data_set(const AcceptedDesign& design);
    void write_data_set(const std::string& name, const DataSet& design) const;
    void add_to_series(int evaluation, DataSet design);
    void remember(const std::string& name);
    void add_problems(const std::vector<std::string>& problems);

    std::filesystem::path folder_;
    bool is_continued_ = false;
    std::unique_ptr<RunLock> lock_;
    int best_from_ = 0;
    const Problem* problem_ = nullptr;
    std::unique_ptr<HistoryWriter> history_;
    std::unique_ptr<EvaluationFolders> evaluations_;
    SurfaceFormat format_ = SurfaceFormat::stl_binary;
    SeriesPolicy policy_ = SeriesPolicy::every_accepted;
    std::vector<std::pair<double, std::string>> steps_;
    DataSet last_, last_best_;  ///< of steps_; of the best design so far, for a series with only that
    std::vector<std::string> files_, aside_, problems_;
    std::vector<std::filesystem::path> made_;  ///< folders that did not exist, the deepest first
};

/// What finish() writes as run.json, and `strake run --json` prints: {status, reason, level, evaluations, objective,
/// best, max_violation, files, variables: {name: {start, best, unit: rad}}, ...}. `objective` and `best` are those of
/// the best design; null where there is none.
std::string run_json(const RunResult& result, const std::vector<std::string>& files);

/// Throws what the constructor of RunFolder would throw about an existing folder, without making it.
void check_run_folder(const std::filesystem::path& folder);

}  // namespace strake
