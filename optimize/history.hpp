#pragma once
#include "optimize/run_records.hpp"

#include <filesystem>
#include <fstream>

/// history.csv of a run: one row an evaluation. No times, hosts or paths, so that equal runs give equal bytes.
namespace strake {

/// Columns: evaluation, level, status, objective, one per value name, max_violation, accepted, one per own variable.
/// Numbers with 17 digits;
/// empty where there is none. Each row is flushed, so that a run that dies leaves what it knew.
class HistoryWriter {
public:
    /// @throws OutputError with path and reason.
    HistoryWriter(const std::filesystem::path& file, const std::vector<std::string>& names,
                  const std::vector<std::string>& own = {});
    void add(const EvaluationRecord& record);  ///< @throws OutputError

private:
    void write(const std::string& line);
    std::filesystem::path file_;
    std::ofstream out_;
    std::size_t num_values_ = 0;
};

/// One row, without the end of line. `num_values` empty columns stand for a record without values.
std::string history_row(const EvaluationRecord& record, std::size_t num_values);

}  // namespace strake
