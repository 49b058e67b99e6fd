#include "bench/coarse_to_fine/comparators.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <cmath>

namespace strake::evidence {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// u = (M + r^2 K)^-1 M s on the vertices that are not held.
struct Filter {
    std::vector<int> vertex;  ///< of each unknown
    VectorXd mass;
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor;

    Filter(const TriMesh& mesh, const std::vector<char>& held, double r) {
        std::vector<int> unknown(mesh.num_vertices(), -1);
        for (int v = 0; v < mesh.num_vertices(); ++v)
            if (!held[v]) unknown[v] = static_cast<int>(vertex.size()), vertex.push_back(v);
        const VectorXd area = vertex_areas(mesh);
        const Points angles = corner_angles(mesh);
        mass = area(vertex);
        std::vector<Eigen::Triplet<double>> entries;
        for (int i = 0; i < mass.size(); ++i) entries.emplace_back(i, i, mass[i]);
        for (int t = 0; t < mesh.num_triangles(); ++t)
            for (int k = 0; k < 3; ++k) {
                const double stiffness = 0.5 * r * r / std::tan(angles(t, k));  // of the edge opposite to corner k
                const int a = unknown[mesh.triangles(t, (k + 1) % 3)], b = unknown[mesh.triangles(t, (k + 2) % 3)];
                if (a >= 0) entries.emplace_back(a, a, stiffness);
                if (b >= 0) entries.emplace_back(b, b, stiffness);
                if (a >= 0 && b >= 0) entries.emplace_back(a, b, -stiffness), entries.emplace_back(b, a, -stiffness);
            }
        Eigen::SparseMatrix<double> A(mass.size(), mass.size());
        A.setFromTriplets(entries.begin(), entries.end());
        factor.compute(A);
        if (factor.info() != Eigen::Success) throw SolverError("the Helmholtz filter cannot be factorized");
    }
};

Points vertex_normals(const TriMesh& mesh) {
    Points normal = Points::Zero(mesh.num_vertices(), 3);
    const Points angles = corner_angles(mesh), flat = triangle_normals(mesh);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) normal.row(mesh.triangles(t, k)) += angles(t, k) * flat.row(t);
    for (int v = 0; v < mesh.num_vertices(); ++v) normal.row(v).normalize();
    return normal;
}

}  // namespace

ComparedMotion filtered_vertices(const EvidenceProblem& problem) {
    const TriMesh& surface = problem.problem.surface;
    const PatchLevel& finest = problem.problem.tree.levels.back();
    const double patch = surface_area(surface) / static_cast<double>(finest.patches.size());
    const double r = 2 * std::sqrt(patch / 3.141592653589793) / (2 * std::sqrt(3.0));
    const auto filter = std::make_shared<const Filter>(surface, held_vertices(problem.problem), r);
    const Eigen::Index n = filter->mass.size();
    const std::vector<VariableKind>& kinds = problem.problem.parameters.kinds;
    const bool along_normal = kinds == std::vector<VariableKind>{VariableKind::normal_load};
    const Points normals = vertex_normals(surface)(filter->vertex, Eigen::all);

    // s = 1 at one vertex moves the surface by (M + r^2 K)^-1_kk m_k there. Its mean over some vertices serves for all,
    // so that the field has one unit.
    const Eigen::Index stride = std::max<Eigen::Index>(1, n / 60);
    double sum = 0;
    int count = 0;
    for (Eigen::Index k = 0; k < n; k += stride, ++count)
        sum += filter->factor.solve(VectorXd(filter->mass[k] * VectorXd::Unit(n, k)))[k];
    const double step = problem.problem.parameters.max_displacement * box_diagonal(surface);
    const double unit = step / (sum / count);

    ComparedMotion motion;
    motion.name = text("r = ", r);
    const Eigen::Index size = along_normal ? n : 3 * n;
    motion.lower = VectorXd::Constant(size, -1);
    motion.upper = VectorXd::Constant(size, 1);
    // A step is as long as the root mean square of the field (twice, over max_displacement): the filter passes a smooth
    // field as it is.
    const VectorXd root = 2 * unit / step * (filter->mass / surface_area(surface)).cwiseSqrt();
    motion.weight = along_normal ? root : root.replicate(3, 1);
    motion.vertices = [=, rest = surface.vertices](const VectorXd& x) {
        Points s(n, 3);
        for (int c = 0; c < 3; ++c)
            s.col(c) = along_normal ? VectorXd(normals.col(c).cwiseProduct(x)) : VectorXd(x.segment(c * n, n));
        const MatrixXd load = unit * (filter->mass.asDiagonal() * s);
        const MatrixXd u = filter->factor.solve(load);
        Points v = rest;
        for (Eigen::Index i = 0; i < n; ++i) v.row(filter->vertex[i]) += u.row(i);
        return v;
    };
    motion.gradient = [=](const VectorXd&, const Points& dJ_dv) {
        const MatrixXd right = dJ_dv(filter->vertex, Eigen::all);
        const MatrixXd g = unit * (filter->mass.asDiagonal() * MatrixXd(filter->factor.solve(right)));
        if (!along_normal) return VectorXd(g.reshaped());
        return VectorXd((normals.array() * g.array()).rowwise().sum());
    };
    return motion;
}

}  // namespace strake::evidence
