#pragma once
#include "optimize/run/run_records.hpp"

#include <filesystem>
#include <fstream>

/// history.csv of a run: one row an evaluation. No times, hosts or paths: equal runs give equal bytes.
namespace strake {

/// Columns: evaluation, level, status, objective, one per value name, max_violation, accepted, one per parameter.
/// Numbers with 17 digits; empty where there is none. Each row is flushed: a run that dies leaves all rows so far. A
/// new column goes into `before_values` or `after_values` (history.cpp) and `history_row`, and into `record_of`
/// (report/run_status.cpp) if status and report show it.
class HistoryWriter {
public:
    /// @throws OutputError with path and reason.
    /// @param continues an existing file is kept while its rows are the same: that of a run which is replayed.
    HistoryWriter(const std::filesystem::path& file, const std::vector<std::string>& names,
                  const std::vector<std::string>& parameters = {}, bool continues = false);
    void add(const EvaluationRecord& record);  ///< @throws OutputError
    void finish();                             ///< what was kept and has not come again goes

private:
    void write(const std::string& line);
    [[noreturn]] void refuse() const;
    std::string kept_;      ///< bytes of the file
    std::size_t same_ = 0;  ///< so many of them have come again
    std::filesystem::path file_;
    std::ofstream out_;
    std::size_t num_values_ = 0;
};

/// One of the columns that every history has: no value or parameter may be called so.
bool is_history_column(const std::string& name);
/// Of values and parameters, as the first row has them.
struct HistoryNames {
    std::vector<std::string> values, parameters;
};
HistoryNames history_names(const std::string& header);
/// The first row, without the end of line.
std::string history_header(const std::vector<std::string>& names, const std::vector<std::string>& parameters);
/// One row, without the end of line. `num_values` empty columns stand for a record without values.
std::string history_row(const EvaluationRecord& record, std::size_t num_values);

}  // namespace strake
