#include "casefile/build/problem_builder.hpp"
#include "core/mesh/geometry.hpp"

namespace strake {

/// Thicknesses whose cubes leave nothing of the other terms of the stiffness.
void ProblemBuilder::check_heights(const Eigen::VectorXd& height) {
    constexpr double thinnest = 1e-8, thickest = 100;  // in diagonals
    for (const double h : {height.minCoeff(), height.maxCoeff()})
        if (!(h >= thinnest * start_.diagonal && h <= thickest * start_.diagonal))
            errors_.add(case_.thickness_place, text("shell.thickness: ", h, " is ", h / start_.diagonal,
                                                    " times the diagonal of the surface, must be in [", thinnest, ", ",
                                                    thickest, "]; 2% of the diagonal is the default"));
}

void ProblemBuilder::set_heights() {
    const int m = elastic().mesh.num_triangles();
    Eigen::VectorXd height = Eigen::VectorXd::Constant(m, case_.thickness.in(start_.diagonal));
    std::vector<int> owner(m, -1);
    for (int k = 0; k < static_cast<int>(case_.thickness_by_region.size()); ++k) {
        const ThicknessEntry& entry = case_.thickness_by_region[k];
        std::vector<int> shared(k, 0);
        for (const int t : elastic_triangles(entry.region)) {
            if (owner[t] >= 0) ++shared[owner[t]];
            owner[t] = k;
            height[t] = entry.height.in(start_.diagonal);
        }
        for (int earlier = 0; earlier < k; ++earlier)
            if (shared[earlier] > 0)
                out_.warnings.push_back(text("shell.thickness: regions '",
                                             case_.thickness_by_region[earlier].region.name, "' and '",
                                             entry.region.name, "' share ", shared[earlier],
                                             " triangles; the later one, '", entry.region.name, "', holds there"));
    }
    check_heights(height);
    out_.problem.prism_height = vertex_heights(elastic().mesh, height);
    double edges = 0;
    for (const auto& [a, b] : elastic().adjacent.edges)
        edges += (elastic().mesh.vertices.row(a) - elastic().mesh.vertices.row(b)).norm();
    const double mean = edges / elastic().adjacent.num_edges();
    if (height.minCoeff() < 0.5 * mean)
        out_.warnings.push_back(text("shell.thickness: ", height.minCoeff(), " is below half of the mean edge length ",
                                     mean, "; the stiffness depends on the triangulation"));
}

/// A strain of a region without its fixed triangles: these stay fixed.
PrescribedStrain ProblemBuilder::prescribed(const StrainEntry& strain, const std::vector<char>& is_fixed) const {
    const std::vector<int> held = elastic_triangles(strain.region);
    PrescribedStrain given;
    for (const int t : held)
        if (!is_fixed[t]) given.triangles.push_back(t);
    given.motion.rotation = strain.rotate;
    for (int k = 0; k < 3; ++k) given.motion.translation[k] = strain.translate[k].in(start_.diagonal);
    given.motion.about = strain.about ? *strain.about : area_centroid(start_.mesh, triangles(strain.region));
    return given;
}

/// @param owner per triangle: the strain that moves it; this one's triangles are entered.
void ProblemBuilder::check_strain(const StrainEntry& strain, const std::vector<char>& is_fixed,
                                  std::vector<const StrainEntry*>& owner) {
    const std::vector<int> held = elastic_triangles(strain.region);
    int fixed = 0;
    for (const int t : held) {
        fixed += is_fixed[t];
        if (owner[t] && !is_fixed[t])
            errors_.add(strain.region.place, text("strains: regions '", owner[t]->region.name, "' and '",
                                                  strain.region.name, "' share triangles, which cannot follow both"));
        owner[t] = &strain;
    }
    if (fixed == static_cast<int>(held.size()))
        errors_.add(strain.region.place, text("strains: every triangle of region '", strain.region.name, "' is fixed"));
    else if (fixed > 0)
        out_.warnings.push_back(text("strains: ", fixed, " of ", held.size(), " triangles of region '",
                                     strain.region.name, "' are fixed as well and stay fixed"));
    warn_shared_vertices(strain, held, is_fixed);
}

void ProblemBuilder::set_pins() {
    if (!wrap_) {  // else `set_wrap` has it
        std::vector<char> marks(start_.mesh.num_triangles(), 0);
        for (const Reference& region : case_.fixed)
            for (const int t : triangles(region)) marks[t] = 1;
        for (int t = 0; t < start_.mesh.num_triangles(); ++t)
            if (marks[t]) out_.problem.fixed.push_back(t);
    }
    const int m = elastic().mesh.num_triangles();
    std::vector<char> is_fixed(m, 0);
    for (const int t : held_triangles()) is_fixed[t] = 1;
    std::vector<const StrainEntry*> owner(m, nullptr);
    for (const StrainEntry& strain : case_.strains) {
        check_strain(strain, is_fixed, owner);
        PrescribedStrain given = prescribed(strain, is_fixed);
        check_symmetry(strain.place, text("strains: region '", strain.region.name, "'"), given);
        leave_to_motion(triangles(strain.region));
        out_.problem.strains.push_back(std::move(given));
    }
    if (!errors_.empty()) return;
    for (int t = 0; t < m; ++t)
        if (!is_fixed[t] && !owner[t]) return;
    errors_.add(case_.fixed.empty() ? case_.strains[0].place : case_.fixed_place,
                text(case_.fixed.empty() ? "strains" : "fixed", ": every triangle is ",
                     case_.strains.empty() ? "fixed"
                     : case_.fixed.empty() ? "strained"
                                           : "fixed or strained",
                     "; nothing is left to deform"));
}

/// Open edges on the plane of symmetry must stay there: otherwise the half and its mirror image come apart.
void ProblemBuilder::check_symmetry(const Place& place, const std::string& shown, const PrescribedStrain& given) {
    if (!case_.symmetry) return;
    const SymmetryPlane& plane = *case_.symmetry;
    const TriMesh& mesh = elastic().mesh;
    std::vector<char> moved(mesh.num_vertices(), 0);
    for (const int t : given.triangles)
        for (int k = 0; k < 3; ++k) moved[mesh.triangles(t, k)] = 1;
    for (const int t : held_triangles())
        for (int k = 0; k < 3; ++k) moved[mesh.triangles(t, k)] = 0;
    const double angle = given.motion.rotation.norm();
    const Eigen::Matrix3d turn = angle > 0 ? Eigen::AngleAxisd(angle, given.motion.rotation / angle).toRotationMatrix()
                                           : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
    const auto off_plane = [&](const Eigen::Vector3d& x) { return plane.normal.dot(x) - plane.offset; };
    for (int e = 0; e < elastic().adjacent.num_edges(); ++e) {
        const auto& ends = elastic().adjacent.edges[e];
        if (elastic().adjacent.edge_triangles[e].size() != 1) continue;
        const Eigen::Vector3d a = mesh.vertices.row(ends[0]), b = mesh.vertices.row(ends[1]);
        const double near = 1e-6 * start_.diagonal;
        if (std::abs(off_plane(a)) > near || std::abs(off_plane(b)) > near) continue;
        for (const int v : ends) {
            if (!moved[v]) continue;
            const Eigen::Vector3d arm = mesh.vertices.row(v).transpose() - given.motion.about;
            const double off = plane.normal.dot(turn * arm - arm + given.motion.translation);
            if (std::abs(off) <= 1e-9 * start_.diagonal) continue;
            errors_.add(place, text(shown, " takes vertex ", v, " off the symmetry plane by ", off,
                                    "; keep the motion within the plane"));
            return;
        }
    }
}

void ProblemBuilder::warn_shared_vertices(const StrainEntry& strain, const std::vector<int>& held,
                                          const std::vector<char>& is_fixed) {
    const TriMesh& mesh = elastic().mesh;
    std::vector<char> moved(mesh.num_vertices(), 0), fixed(mesh.num_vertices(), 0);
    for (const int t : held)
        if (!is_fixed[t])
            for (int k = 0; k < 3; ++k) moved[mesh.triangles(t, k)] = 1;
    for (const int t : held_triangles())
        for (int k = 0; k < 3; ++k) fixed[mesh.triangles(t, k)] = 1;
    int shared = 0;
    for (int v = 0; v < mesh.num_vertices(); ++v) shared += moved[v] && fixed[v];
    if (shared > 0)
        out_.warnings.push_back(text("strains: region '", strain.region.name, "' shares ", shared,
                                     " vertices with fixed regions; they stay fixed"));
}

}  // namespace strake
