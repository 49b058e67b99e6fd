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
/// Its repr, cut off where it is long.
std::string shown(const py::object& thing);
/// Distinct triangle numbers, ascending, from numbers or from a mask of booleans.
/// @throws InvalidInput `what: ...` out of range, on a mask of another length, on numbers that are not whole.
std::vector<int> triangles_of(const py::object& chosen, const TriMesh& surface, const std::string& what);
/// Whole numbers >= 1. @throws InvalidInput
std::vector<int> counts_of(const py::object& given, const std::string& what);
/// m x 3 numbers of vertices. @throws InvalidInput
Triangles corners_of(const py::object& given, Eigen::Index num_vertices, const std::string& what);

/// Docstrings begin with the signature, by which `help` and `inspect` show it as Python's own; pybind11's names types
/// as C++ does. The tests compare it with the arguments that are really taken.
constexpr const char* repr_doc = "__repr__(self)\n--\n\n";

}  // namespace strake::python
