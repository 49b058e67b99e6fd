#include "core/remesh/vertex_place.hpp"

namespace strake {

bool find_on_surface(const WorkingMesh& mesh, int v, const VertexPlace& from, const Eigen::Vector3d& shift,
                     VertexPlace& place) {
    const Foot foot = project(*mesh.base, from.point + shift, from.foot, 0.5 * mesh.size[v]);
    place = {foot.point, normal_at(*mesh.base, foot), foot.triangle, 0};
    return place.normal.dot(mesh.normal[v]) > 0.5;
}

bool find_on_curve(const WorkingMesh& mesh, const StepGuard& guard, int v, double shift, VertexPlace& place) {
    const auto [before, after] = ridge_edges(mesh, v);
    if (before < 0 || after < 0) return false;
    const FeatureEdge &e = mesh.features[before], &f = mesh.features[after];
    const Curves& curves = mesh.base->curves;
    if (!(shift > -0.7 * (e.s[1] - e.s[0]) && shift < 0.7 * (f.s[1] - f.s[0]))) return false;
    const double s = e.s[1] + shift;
    if (!curves.chord_fits(e.curve, e.s[0], s, guard.chord_slack) ||
        !curves.chord_fits(e.curve, f.s[0] + shift, f.s[1], guard.chord_slack))
        return false;
    place = {curves.at(e.curve, s), mesh.normal[v], curves.triangle_at(e.curve, s), shift};
    return true;
}

void put(WorkingMesh& mesh, int v, const VertexPlace& place) {
    if (mesh.role[v] == VertexRole::ridge) {
        const auto [before, after] = ridge_edges(mesh, v);
        mesh.features[before].s[1] += place.s;
        mesh.features[after].s[0] += place.s;
    }
    mesh.pos[v] = place.point;
    mesh.normal[v] = place.normal;
    mesh.foot[v] = place.foot;
    mesh.wake_around(v);
}

double shape_cost(WorkingMesh& mesh, const StepGuard& guard, int v, const VertexPlace& place, bool keeps_shape) {
    const Eigen::Vector3d normal = mesh.normal[v];
    mesh.normal[v] = place.normal;
    double sum = 0;
    const bool is_old = place.point == mesh.pos[v];
    const auto turns = [&](int p, int q, const Facing& made) {
        const Facing old = facing(mesh, v, p, q);
        return old.quality > no_area && made.normal.dot(old.normal) < guard.cos_natural;
    };
    mesh.around(v, [&](int h) {
        const int p = mesh.to(h), q = mesh.apex(h);
        const Facing made = facing(mesh, v, p, q, place.point, mesh.pos[p], mesh.pos[q]);
        if (!is_old && (made.dot <= 1 ? made.dot < guard.cos_natural : turns(p, q, made)))
            sum = std::numeric_limits<double>::infinity();
        if (!is_old && keeps_shape && made.quality < std::min(well_shaped, mesh.quality(h / 3)))
            sum = std::numeric_limits<double>::infinity();
        const double worse = 1 / std::max(made.quality, 1e-4);
        sum += (worse * worse) * (worse * worse);
        return std::isfinite(sum);
    });
    mesh.normal[v] = normal;
    return sum;
}

}  // namespace strake
