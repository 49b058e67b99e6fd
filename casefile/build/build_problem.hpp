#pragma once
#include "casefile/model/case.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/geometry.hpp"

/// From the checked case to the problem that `deform`, `run` and `fit` solve.
namespace strake {

/// The surface file is readable, but cannot be deformed as it is. The text says what is wrong, where, and
/// what to do.
struct SurfaceRefused : InputError {
    using InputError::InputError;
};

struct RegionTriangles {
    std::string name;
    std::vector<int> triangles;  ///< ascending
    double area = 0;
    Box box;  ///< of its triangles
};

struct BuiltProblem {
    Problem problem;
    SurfaceFormat format = SurfaceFormat::stl_binary;  ///< of the surface file
    std::string wrap;  ///< the wrap in use as a value of the key wrap, for any later build; empty: there is none
    bool is_prepared = false;  ///< repair or remesh changed the surface of the file
    std::string repairs_csv;   ///< every single repair; empty without
    std::vector<RegionTriangles> regions;
    std::vector<std::shared_ptr<const Wing>> wings;       ///< those of `planform`, in its order
    std::vector<std::shared_ptr<const Fuselage>> bodies;  ///< likewise
    std::vector<std::string> notes;                       ///< results of repair and remesh
    std::vector<std::string> warnings;
};

/// Reads the surface, refuses one that cannot be deformed, evaluates regions, heights, tractions, patches and
/// quantities. Folders of external evaluations go to `output.dir`/evaluations. The patch tree is left empty for
/// Purpose::deform unless a region names a patch.
/// @throws InputError (surface file), SurfaceRefused, CaseError with all errors about the case.
BuiltProblem build_problem(const Case& the_case, Purpose purpose = Purpose::any);

}  // namespace strake
