#pragma once
#include "optimize/run/run_records.hpp"

#include <filesystem>

/// Designs and what they gave, as a table: samples.csv of a run folder, or a user's own.
namespace strake {

struct DesignTable {
    std::string name;                    ///< for messages: the file
    std::vector<std::string> variables;  ///< names
    std::vector<std::string> values;     ///< names
    Eigen::MatrixXd designs;             ///< rows x variables, physical: as programs receive them, angles in radians
    Eigen::MatrixXd given;               ///< rows x values; NaN: there is no value
    std::vector<std::string> status;     ///< per row: "ok", or why it has no values, in one word
    int rows() const { return static_cast<int>(status.size()); }
};

/// Names and physical values of all variables of a design, those of the shape first.
std::vector<std::string> variable_names(const DesignSpace& space);
Eigen::VectorXd physical_design(const DesignSpace& space, const Eigen::VectorXd& x);
/// The design with these physical values. @pre as many as variables
Eigen::VectorXd design_of(const DesignSpace& space, const Eigen::VectorXd& physical);

/// Header `evaluation,status`, variables, values; 17 digits; empty fields where there is no value.
std::string table_csv(const DesignTable& table);

/// Columns in any order, separated by commas; those that are neither `values` nor a bookkeeping column of Strake's own
/// tables (evaluation, status, level, objective, max_violation, accepted) are variables. A row whose values are not all
/// there is one that failed.
/// @param values names that the case knows; not all need be there.
/// @throws InputError with file, line, value and remedy: no value's column, a number that is none or not finite, no
/// row, a row with another number of fields.
DesignTable read_table(const std::filesystem::path& file, const std::vector<std::string>& values);

/// The same with the variables in this order. @throws InvalidInput naming a variable without a column, or a column that
/// is no variable, with the remedy.
DesignTable with_variables(const DesignTable& table, const std::vector<std::string>& variables);

}  // namespace strake
