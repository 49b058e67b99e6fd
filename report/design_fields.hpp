#pragma once
#include "core/formats/vtp.hpp"
#include "optimize/problem/problem.hpp"

#include <filesystem>

/// Point-wise results of objectives: the pressure of a flow solver, the distance to a target.
namespace strake {

struct ShownDesign {
    const TriMesh& surface;
    std::filesystem::path evaluation;                             ///< folder in which its programs ran
    std::vector<std::pair<std::string, double>> parameters = {};  ///< as QuantityRequest::parameters
    std::filesystem::path data_set = {};                          ///< .vtp written for it earlier
};

/// Point fields of a design, one number for each vertex:
/// - those of built-in quantities (Quantity::fields): NAME.cp, NAME.cf;
/// - `NAME.distance` of every quantity that measures a distance at the vertices (target_shape), in its unit;
/// - those that programs return with their result: {"fields": {"cp": "cp.csv"}} in result.json of `evaluation` (the
///   folder of the evaluation) or of a folder in it; rows index,value in any order, one for each vertex of the
///   surface handed over; or {"file": "out.vtp", "field": "Cp"}. If that folder has been removed, those of the data
///   set.
/// @param problems one sentence for each unusable field; a run does not fail because of a picture.
std::vector<Field> design_fields(const Problem& problem, const ShownDesign& design, std::vector<std::string>& problems);

}  // namespace strake
