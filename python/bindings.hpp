#pragma once
#include "core/mesh/mesh.hpp"
#include "core/mesh/symmetry_plane.hpp"

#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <memory>

/// The Python module by topic. Only the package `strake` imports it.
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
/// (normal, offset), the normal of any length. @throws InvalidInput for a zero normal.
using PlaneTuple = std::pair<Eigen::Vector3d, double>;
std::optional<SymmetryPlane> plane_of(const std::optional<PlaneTuple>& plane);
/// Its repr, truncated.
std::string shown(const py::handle& thing);
/// The present name for `given`: `now` for the old name `before`, with a DeprecationWarning. Old names go at 1.0.
std::string current_name(const std::string& given, const char* before, const char* now, const char* what);
/// Distinct triangle numbers, ascending, from numbers or from a mask of booleans.
/// @throws InvalidInput `what: ...` out of range, for a mask of the wrong length, for numbers that are not whole.
std::vector<int> triangles_of(const py::object& chosen, const TriMesh& surface, const std::string& what);
/// Whole numbers >= 1. @throws InvalidInput
std::vector<int> counts_of(const py::object& given, const std::string& what);
/// m x 3 numbers of vertices. @throws InvalidInput
Triangles corners_of(const py::object& given, Eigen::Index num_vertices, const std::string& what);

/// Docstrings begin with a Python signature for `help` and `inspect`; pybind11's own would show C++ types. The tests
/// compare it with the real arguments.
constexpr const char* repr_doc = "__repr__(self)\n--\n\n";

}  // namespace strake::python
