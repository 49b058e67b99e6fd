#include "cli/designs.hpp"
#include "cli/detail.hpp"

#include "casefile/build/prepare_surface.hpp"
#include "casefile/load_case.hpp"
#include "casefile/model/case.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/text/file.hpp"
#include "optimize/run/stored_design.hpp"

#include <fmt/core.h>

namespace strake::cli {
namespace {

namespace fs = std::filesystem;

/// The vertices of an evaluation from the ParaView series.
Points shape_of(const fs::path& run, int evaluation, const TriMesh& rest) {
    const fs::path file = run / fmt::format("series/design_{:06d}.vtp", evaluation);
    std::error_code ignored;
    if (!fs::exists(file, ignored))
        throw InvalidInput(
            fmt::format("{}: the shape of evaluation {} was not kept (no {}); output.paraview says which "
                        "shapes are kept",
                        printable(run.native(), 400), evaluation, file.filename().string()));
    const TriMesh shape = read_logged(file).mesh;
    if (!same_triangles(shape, rest))
        throw InputError(
            fmt::format("{}: does not have the triangles of the case's surface", printable(file.native(), 400)));
    return shape.vertices;
}

}  // namespace

bool same_triangles(const TriMesh& a, const TriMesh& b) {
    return a.num_vertices() == b.num_vertices() && a.num_triangles() == b.num_triangles() && a.triangles == b.triangles;
}

bool is_run_folder(const fs::path& path) {
    std::error_code ignored;
    return fs::exists(path / "case.yaml", ignored);
}

Deformation run_deformation(const fs::path& run, const fs::path& design, int evaluation) {
    std::error_code ignored;
    const std::string name = printable(run.native(), 400);
    if (!fs::exists(run, ignored)) throw InvalidInput(name + ": no such folder");
    if (!is_run_folder(run)) throw InvalidInput(name + ": is not a run folder (it has no case.yaml)");
    const fs::path file = design.empty() ? run / "levels/best.design" : design;
    if (design.empty() && !fs::exists(file, ignored))
        throw InvalidInput(name + ": the run has no design yet (no levels/best.design)");
    const Case the_case = load_case(run / "case.yaml");
    Deformation d{prepare_surface(the_case).mesh, {}, evaluation, the_case.symmetry, the_case.invariance};
    if (evaluation > 0) {
        d.vertices = shape_of(run, evaluation, d.rest);
        return d;
    }
    const StoredDesign stored = read_design(file);
    check_surface(stored, d.rest);
    d.vertices = stored.vertices;
    d.evaluation = stored.evaluation;
    return d;
}

Deformation surface_deformation(const fs::path& rest, const fs::path& moved) {
    Deformation d{read_logged(rest).mesh, {}, 0, {}, {}};
    const TriMesh shape = read_logged(moved).mesh;
    if (!same_triangles(shape, d.rest))
        throw InputError(fmt::format("{}: {} vertices and {} triangles differ from those of {} ({} and {})",
                                     printable(moved.native(), 400), shape.num_vertices(), shape.num_triangles(),
                                     printable(rest.native(), 400), d.rest.num_vertices(), d.rest.num_triangles()));
    d.vertices = shape.vertices;
    return d;
}

}  // namespace strake::cli
