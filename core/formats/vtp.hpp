#pragma once
#include "core/mesh/mesh.hpp"

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

/// ParaView's polygon files (.vtp, binary appended, double coordinates).
namespace strake {

/// One value (k = 1) or vector (k = 3) per vertex or triangle, or an integer label.
struct Field {
    std::string name;
    std::variant<Eigen::VectorXd, Points, std::vector<int>> values;
};

/// The whole file. @throws InvalidInput on a wrong count or a number that is not finite.
std::string vtp_bytes(const TriMesh& mesh, const std::vector<Field>& point_fields = {},
                      const std::vector<Field>& cell_fields = {});

/// Writes that atomically. @throws OutputError, too.
void write_vtp(const std::filesystem::path& file, const TriMesh& mesh, const std::vector<Field>& point_fields = {},
               const std::vector<Field>& cell_fields = {});

/// A series for ParaView: `file` (.pvd) names each data set with its time.
void write_pvd(const std::filesystem::path& file, const std::vector<std::pair<double, std::string>>& steps);

}  // namespace strake
