#pragma once
#include "core/mesh/mesh.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <memory>

/// The Python module, topic by topic. Only the package `strake` imports it.
namespace strake::python {

namespace py = pybind11;

using SurfacePointer = std::shared_ptr<TriMesh>;
using Rows = Eigen::Ref<const Points>;  ///< n x 3 from numpy, without a copy where it is C-contiguous float64

void bind_errors(py::module_& m);
void bind_surface(py::module_& m);
void bind_patches(py::module_& m);
void bind_shell(py::module_& m);
void bind_problem(py::module_& m);
void bind_run(py::module_& m);

/// @throws InvalidInput `what: ...` on another number of rows, or a number that is not finite.
void check_rows(const Rows& rows, Eigen::Index expected, const char* what);
/// (normal, offset), the normal of any length. @throws InvalidInput when it has none.
using PlaneTuple = std::pair<Eigen::Vector3d, double>;
std::optional<SymmetryPlane> plane_of(const std::optional<PlaneTuple>& plane);
/// Distinct triangle numbers, ascending. @throws InvalidInput out of range.
std::vector<int> triangles_of(const std::vector<int>& listed, const TriMesh& surface, const char* what);

}  // namespace strake::python
