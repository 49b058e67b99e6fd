#include "optimize/run/design_table.hpp"

#include "core/error.hpp"
#include "core/text/csv_columns.hpp"
#include "core/text/file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace strake {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
/// Of history.csv and other tables of Strake: neither variables nor values.
const std::vector<std::string> ignored{"evaluation", "status", "level", "objective", "max_violation", "accepted"};

bool contains(const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
}

std::string joined(const std::vector<std::string>& names) {
    std::string out;
    for (const std::string& name : names) out += (out.empty() ? "" : ", ") + printable(name);
    return out;
}

std::string number(double value) {
    if (!std::isfinite(value)) return "";
    char buffer[64];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::scientific, 16);
    return {buffer, end.ptr};
}

bool is_nan(std::string word) {
    std::ranges::transform(word, word.begin(), [](unsigned char c) { return std::tolower(c); });
    return word == "nan";
}

std::string trimmed(std::string word) {
    const char* blank = " \t\r\"";
    word.erase(0, word.find_first_not_of(blank));
    word.erase(word.find_last_not_of(blank) + 1);
    return word;
}

/// Spreadsheets begin a file in UTF-8 with a mark.
std::string without_mark(const std::string& line) {
    constexpr std::string_view mark = "\xEF\xBB\xBF";
    return line.starts_with(mark) ? line.substr(mark.size()) : line;
}

std::vector<std::string> fields(const std::string& line) {
    std::vector<std::string> out;
    for (const std::string_view field : csv_fields(line, line.size())) out.push_back(trimmed(std::string(field)));
    return out;
}

/// Reads a table line by line.
class TableReader {
public:
    TableReader(const std::filesystem::path& file, const std::vector<std::string>& values)
        : file_(file), values_(values), lines_(read_bytes(file)) {
        std::string line;
        if (next(line)) columns_ = fields(without_mark(line));
        if (columns_.empty() || (columns_.size() == 1 && columns_[0].empty()))
            refuse("the table is empty; its first line must name the columns");
        if (columns_.size() == 1 && columns_[0].find(';') != std::string::npos)
            refuse("columns are separated by ';'; separate them by commas, with points in numbers");
        for (std::size_t c = 0; c < columns_.size(); ++c)
            if (columns_[c].empty())
                refuse(text("column ", c + 1, " has no name; name it, or remove the comma before it"));
        for (std::size_t c = 0; c < columns_.size(); ++c)
            for (std::size_t d = c + 1; d < columns_.size(); ++d)
                if (columns_[c] == columns_[d])
                    refuse(text("two columns are called '", printable(columns_[c]), "'; rename or remove one"));
    }

    DesignTable read(const std::vector<std::string>& variables) {
        DesignTable table;
        table.name = file_.string();
        table.variables = variables;
        for (const std::string& value : values_)
            if (contains(columns_, value)) table.values.push_back(value);
        if (table.values.empty())
            refuse(text("no column is one of the values of the case (", joined(values_),
                        "); add one, for example from the results of your solver"));
        const std::vector<int> of_variables = places(table.variables), of_values = places(table.values);
        const std::vector<int> of_status = places({"status"});
        std::vector<std::vector<double>> designs, given;
        std::string line;
        while (next(line)) {
            const std::vector<std::string> row = fields(line);
            if (row.size() == 1 && row[0].empty()) continue;
            if (row.size() != columns_.size())
                refuse(text("has ", row.size(), " fields, the first line names ", columns_.size(),
                            " columns; separate them by commas, and leave a field empty where there is no value"));
            designs.push_back(numbers(row, of_variables, false));
            given.push_back(numbers(row, of_values, true));
            const bool has_all = std::ranges::none_of(given.back(), [](double v) { return std::isnan(v); });
            const std::string status = of_status[0] >= 0 ? row[static_cast<std::size_t>(of_status[0])] : "";
            table.status.push_back(has_all ? "ok" : status.empty() || status == "ok" ? "no_value" : status);
            if (!has_all) std::ranges::fill(given.back(), none);
        }
        if (table.rows() == 0) refuse("there is no row below the names of the columns; add one for each design");
        table.designs = matrix(designs);
        table.given = matrix(given);
        return table;
    }

    const std::vector<std::string>& columns() const { return columns_; }
    [[noreturn]] void refuse(const std::string& why) const {
        throw InputError(text(file_.string(), ":", std::max(line_, 1), ": ", why));
    }

private:
    bool next(std::string& line) {
        ++line_;
        return static_cast<bool>(std::getline(lines_, line));
    }

    /// Number of each column; -1: there is none.
    std::vector<int> places(const std::vector<std::string>& names) const {
        std::vector<int> out;
        for (const std::string& name : names) {
            const auto at = std::find(columns_.begin(), columns_.end(), name);
            out.push_back(at == columns_.end() ? -1 : static_cast<int>(at - columns_.begin()));
        }
        return out;
    }

    std::vector<double> numbers(const std::vector<std::string>& row, const std::vector<int>& at, bool may_miss) const {
        std::vector<double> out;
        for (const int c : at) {
            const std::string& word = row[static_cast<std::size_t>(c)];
            double value = none;
            const bool has_plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
            const char* begin = word.data() + (has_plus ? 1 : 0);
            const auto [end, error] = std::from_chars(begin, word.data() + word.size(), value);
            const bool is_number = error == std::errc() && end == word.data() + word.size() && std::isfinite(value);
            if (!is_number && !(may_miss && (word.empty() || is_nan(word))))
                refuse(text(
                    "column '", printable(columns_[static_cast<std::size_t>(c)]), "': '", printable(word),
                    "' is not a finite number",
                    may_miss ? "; leave the field empty where there is no value" : "; correct it, or remove the row"));
            out.push_back(is_number ? value : none);
        }
        return out;
    }

    static Eigen::MatrixXd matrix(const std::vector<std::vector<double>>& rows) {
        Eigen::MatrixXd m(rows.size(), rows.empty() ? 0 : rows[0].size());
        for (Eigen::Index i = 0; i < m.rows(); ++i)
            for (Eigen::Index j = 0; j < m.cols(); ++j)
                m(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
        return m;
    }

    std::filesystem::path file_;
    const std::vector<std::string>& values_;
    std::istringstream lines_;
    int line_ = 0;
    std::vector<std::string> columns_;
};

}  // namespace

std::vector<std::string> variable_names(const DesignSpace& space) {
    std::vector<std::string> names;
    for (const Variable& variable : space.variables) names.push_back(variable.name);
    return names;
}

Eigen::VectorXd physical_design(const DesignSpace& space, const Eigen::VectorXd& x) {
    Eigen::VectorXd physical(x.size());
    for (Eigen::Index j = 0; j < x.size(); ++j) {
        const Variable& variable = space.variables[static_cast<std::size_t>(j)];
        physical[j] = variable.offset + x[j] * variable.unit;
    }
    return physical;
}

Eigen::VectorXd design_of(const DesignSpace& space, const Eigen::VectorXd& physical) {
    Eigen::VectorXd x(physical.size());
    for (Eigen::Index j = 0; j < x.size(); ++j) {
        const Variable& variable = space.variables[static_cast<std::size_t>(j)];
        x[j] = (physical[j] - variable.offset) / variable.unit;
    }
    return x;
}

std::string table_csv(const DesignTable& table) {
    std::string out = "evaluation,status";
    for (const auto* names : {&table.variables, &table.values})
        for (const std::string& name : *names) out += "," + name;
    out += "\n";
    for (int i = 0; i < table.rows(); ++i) {
        out += std::to_string(i + 1) + "," + table.status[static_cast<std::size_t>(i)];
        for (const auto* numbers : {&table.designs, &table.given})
            for (Eigen::Index j = 0; j < numbers->cols(); ++j) out += "," + number((*numbers)(i, j));
        out += "\n";
    }
    return out;
}

DesignTable read_table(const std::filesystem::path& file, const std::vector<std::string>& values) {
    TableReader reader(file, values);
    std::vector<std::string> variables;
    for (const std::string& name : reader.columns())
        if (!contains(values, name) && !contains(ignored, name)) variables.push_back(name);
    return reader.read(variables);
}

DesignTable with_variables(const DesignTable& table, const std::vector<std::string>& variables) {
    DesignTable out = table;
    out.variables = variables;
    out.designs.resize(table.rows(), static_cast<Eigen::Index>(variables.size()));
    for (std::size_t j = 0; j < variables.size(); ++j) {
        const auto at = std::find(table.variables.begin(), table.variables.end(), variables[j]);
        if (at == table.variables.end())
            throw InvalidInput(text(table.name, ": there is no column for the variable '", printable(variables[j]),
                                    "'; the table must have one for each of ", joined(variables)));
        out.designs.col(static_cast<Eigen::Index>(j)) = table.designs.col(at - table.variables.begin());
    }
    for (const std::string& name : table.variables)
        if (!contains(variables, name))
            throw InvalidInput(text(table.name, ": column '", printable(name),
                                    "' is neither a variable of the first "
                                    "level (",
                                    joined(variables), ") nor a value of the case; remove or rename it"));
    return out;
}

}  // namespace strake
