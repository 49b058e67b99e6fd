#pragma once
#include "casefile/model/case.hpp"
#include "core/mesh/mesh.hpp"

#include <nlohmann/json.hpp>

/// Where `strake check` finds nose, right wing and top of the body, by the axes of the case.
namespace strake::cli {

/// The foremost point of the surface along a direction.
struct BodyEnd {
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit, outward
    int vertex = -1;
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

struct AxesFacts {
    BodyAxes axes;
    std::vector<std::string> users = {};  ///< quantities with a stream
    BodyEnd nose = {}, tail = {}, right = {}, left = {}, top = {};
    /// Of a half model whose right wing is the plane's normal: 1 the right half, -1 the left one; 0: neither.
    int half = 0;
    bool is_half_model = false, whole_coefficients = false;
    std::string warning = {};  ///< axes that hardly can be those of this half model; empty: none
};

/// Nothing where the case has neither axes nor a quantity with a stream.
std::optional<AxesFacts> axes_facts(const Case& the_case, const TriMesh& surface);

void print_axes(const AxesFacts& facts);
nlohmann::ordered_json axes_json(const std::optional<AxesFacts>& facts);

}  // namespace strake::cli
