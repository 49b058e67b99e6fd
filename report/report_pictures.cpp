#include "core/mesh/geometry.hpp"
#include "core/text/base64.hpp"
#include "optimize/run/stored_design.hpp"
#include "report/drawing.hpp"
#include "report/json_number.hpp"
#include "report/report_parts.hpp"

#include <Eigen/Geometry>
#include <cmath>

/// Pictures for the first screen of the report, which need neither WebGL nor a pointer.
namespace strake::page {
namespace {

using Eigen::Vector3d;

constexpr int width = 620, height = 400;

/// The axis along which the body is flat, otherwise z.
Vector3d likely_up(const TriMesh& mesh) {
    const Box box = bounding_box(mesh);
    const Vector3d size = box.max - box.min;
    int thinnest = 0;
    size.minCoeff(&thinnest);
    double next = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k)
        if (k != thinnest) next = std::min(next, size[k]);
    return Vector3d::Unit(size[thinnest] < 0.5 * next ? thinnest : 2);
}

/// Obliquely from ahead and above; of a half model from the side where the body is.
View view_of(const TriMesh& mesh, const ReportSubject& subject) {
    const Vector3d up = subject.up.value_or(likely_up(mesh));
    Vector3d ahead = -subject.downstream.value_or(up[0] > 0.9 ? Vector3d::UnitZ() : Vector3d::UnitX());
    ahead = (ahead - ahead.dot(up) * up).stableNormalized();
    Vector3d side = up.cross(ahead);
    if (subject.symmetry && std::abs(subject.symmetry->normal.dot(side)) > 0.5) {
        const double middle = subject.symmetry->normal.dot(mesh.vertices.colwise().mean()) - subject.symmetry->offset;
        if (middle * subject.symmetry->normal.dot(side) < 0) side = -side;
    }
    return {ahead + 1.1 * side + 0.8 * up, up};
}

std::string png(const TriMesh& mesh, const std::vector<Colour>& colour, const View& view) {
    const std::vector<int> one(colour.size(), 0);
    return "data:image/png;base64," + base64(png_bytes(draw_surface(mesh, colour, one, view, width, height)));
}

/// Displacement of each triangle along its normal at the start.
Eigen::VectorXd outward_displacement(const TriMesh& start, const Points& vertices) {
    const Points normal = triangle_normals(start), moved = vertices - start.vertices;
    Eigen::VectorXd out(start.num_triangles());
    for (int t = 0; t < start.num_triangles(); ++t)
        out[t] = normal.row(t).dot(moved.row(start.triangles(t, 0)) + moved.row(start.triangles(t, 1)) +
                                   moved.row(start.triangles(t, 2))) /
                 3;
    return out;
}

}  // namespace

Json pictures_json(const TriMesh& start, const Points& best, const ReportSubject& subject) {
    if (start.num_triangles() == 0 || !(box_diagonal(start) > 0)) return Json::array();
    const View view = view_of(start, subject);
    const Colour plain{196, 200, 206};
    Json out = Json::array();
    out.push_back(
        {{"title", "Start"},
         {"words", ""},
         {"image", png(start, std::vector<Colour>(static_cast<std::size_t>(start.num_triangles()), plain), view)}});
    if (best.rows() != start.vertices.rows()) return out;
    const Eigen::VectorXd outward = outward_displacement(start, best);
    const double most = outward.cwiseAbs().maxCoeff(), diagonal = box_diagonal(start);
    std::vector<Colour> colour;
    for (const double value : outward) colour.push_back(most > 1e-12 * diagonal ? signed_colour(value / most) : plain);
    out.push_back({{"title", "Best design"},
                   {"words", "moved inward (blue) and outward (brown)"},
                   {"most", json_number(most / diagonal)},
                   {"image", png(with_vertices(start, best), colour, view)}});
    return out;
}

Points best_vertices(const std::filesystem::path& folder) {
    std::error_code ignored;
    const std::filesystem::path file = folder / "levels/best.design";
    return std::filesystem::is_regular_file(file, ignored) ? read_design(file).vertices : Points();
}

}  // namespace strake::page
