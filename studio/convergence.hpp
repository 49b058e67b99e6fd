#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

/// How the solvers of a run converge, from the files that they write (quantities.*.convergence).
namespace strake {

struct ConvergenceTable {
    std::vector<std::string> names;            ///< of the columns; of the first one "iteration" where none is stated
    std::vector<std::vector<double>> columns;  ///< of the same length, the iteration first; NaN where nothing stands
};

/// Reads a table (commas or blanks between numbers, names in the last line before them, quoted or behind '#'; columns
/// without numbers are left out) or a log of OpenFOAM ("Solving for p, Initial residual = …" below "Time = …", of each
/// field the first residual of a time). A last line without its end is being written and is left out.
/// @param max_rows of a longer table evenly spread rows and the last one are taken, >= 2
ConvergenceTable read_convergence(std::string_view bytes, std::size_t max_rows = 600);

struct ConvergenceFile {
    int evaluation = 0;
    std::string name;     ///< "000012/drag/history.csv", below evaluations/
    std::string program;  ///< the quantity
    std::filesystem::path file;
};

/// The files of a run that are there, newest evaluation first. Links out of the run's folder are not followed.
/// @param file_of by quantity
std::vector<ConvergenceFile> convergence_files(const std::filesystem::path& run,
                                               const std::map<std::string, std::filesystem::path>& file_of,
                                               std::size_t max_count = 20);

}  // namespace strake
