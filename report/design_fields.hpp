#pragma once
#include "core/mesh/vtp.hpp"
#include "optimize/problem.hpp"

#include <filesystem>

/// What objectives have to say point by point: pressure of a flow solver, distance to what is to be met.
namespace strake {

struct ShownDesign {
    const TriMesh& surface;
    std::filesystem::path evaluation;                      ///< folder of its programs
    std::vector<std::pair<std::string, double>> own = {};  ///< as QuantityRequest::own
    std::filesystem::path data_set = {};                   ///< .vtp in which it was shown before
};

/// Point fields of a design, a number a vertex:
/// - those of built-in quantities (Quantity::fields): NAME.cp, NAME.cf;
/// - `NAME.distance` of every quantity that measures a distance at the vertices (target_shape), in its unit;
/// - those that programs left with their result: {"fields": {"cp": "cp.csv"}} in result.json of `evaluation` (the
///   folder of the evaluation) or of a folder in it; rows index,value in any order, one for each vertex of the surface
///   handed over; or {"file": "out.vtp", "field": "Cp"}. Where that folder has been removed: those of the data set.
/// @param problems one sentence for each field that cannot be used; a run does not fail for a picture.
std::vector<Field> design_fields(const Problem& problem, const ShownDesign& design, std::vector<std::string>& problems);

}  // namespace strake
