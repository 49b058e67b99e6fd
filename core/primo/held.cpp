#include "core/primo/held.hpp"

#include <Eigen/Eigenvalues>
#include <numeric>

#include "core/error.hpp"
#include "core/primo/linear/block_matrix.hpp"

namespace strake {
namespace {

/// Parts: prisms connected by shared faces. A part's number is that of its smallest prism.
std::vector<int> parts_by_faces(const RestState& rest) {
    std::vector<int> parent(rest.num_prisms());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    };
    for (const SharedFace& f : rest.faces) {
        const int a = root(f.i), b = root(f.j);
        if (a != b) parent[std::max(a, b)] = std::min(a, b);
    }
    for (int i = 0; i < rest.num_prisms(); ++i) parent[i] = root(i);
    return parent;
}

struct Part {
    int triangles = 0, last = 0;
    bool pinned = false;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double area = 0, size = 0;
    Matrix6 hold = Matrix6::Zero();  ///< stiffness against rigid motion, lengths in units of `size`
};

/// Adds stiffness k against motion along `direction` of the point x.
void add_hold(Part& part, const Eigen::Vector3d& x, const Eigen::Matrix3d& directions, double k) {
    const Eigen::Vector3d a = (x - part.centre) / part.size;
    Eigen::Matrix<double, 3, 6> J;
    J << 0, a.z(), -a.y(), 1, 0, 0, -a.z(), 0, a.x(), 0, 1, 0, a.y(), -a.x(), 0, 0, 0, 1;
    part.hold += k * J.transpose() * directions * J;
}

void gather(const RestState& rest, const std::vector<int>& number, std::vector<Part>& parts) {
    for (int i = 0; i < rest.num_prisms(); ++i) {
        Part& part = parts[number[i]];
        ++part.triangles;
        part.last = i;
        part.pinned |= rest.pin[i] != free_prism;
        part.centre += rest.area[i] * rest.centroid.row(i).transpose();
        part.area += rest.area[i];
    }
    for (Part& part : parts)
        if (part.area > 0) part.centre /= part.area;
    for (int i = 0; i < rest.num_prisms(); ++i) {
        Part& part = parts[number[i]];
        part.size = std::max(part.size, (rest.centroid.row(i).transpose() - part.centre).norm() + rest.prism_radius[i]);
    }
}

}  // namespace

void check_held(const RestState& rest, const Eigen::VectorXd& spring) {
    const std::vector<int> number = parts_by_faces(rest);
    std::vector<Part> parts(rest.num_prisms());
    gather(rest, number, parts);
    for (int k = 0; k < rest.mesh.num_vertices(); ++k)
        if (spring[k] > 0)
            for (const int i : rest.vertex_prisms[k])
                add_hold(parts[number[i]], rest.mesh.vertices.row(k).transpose(), rest.plane_projector, 1);
    if (rest.symmetry)
        for (const MirroredFace& f : rest.mirrored)
            for (int g = 0; g < 4; ++g)
                add_hold(parts[number[f.i]], rest.centroid.row(f.i).transpose() + f.arm[g],
                         rest.symmetry->normal * rest.symmetry->normal.transpose(), 1);
    int count = 0, loose = 0, first = -1, motions = 0;
    for (int i = 0; i < rest.num_prisms(); ++i) {
        if (number[i] != i) continue;
        ++count;
        if (parts[i].pinned) continue;
        const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(parts[i].hold);
        const double limit = 1e-10 * std::max(eigen.eigenvalues().maxCoeff(), 1e-300);
        const int free = static_cast<int>((eigen.eigenvalues().array() <= limit).count());
        if (free == 0) continue;
        ++loose;
        if (first < 0) first = i, motions = free;
    }
    if (loose == 0) return;
    const Part& part = parts[first];
    // Shows round-off of a centre at the origin as zero.
    const Eigen::Vector3d centre = (part.centre.array().abs() < 1e-9 * part.size).select(0, part.centre);
    throw UnheldPart(
        text("deform: ", loose, " of ", count, " connected parts of the surface can move freely; the first has ",
             part.triangles, " triangles (", first, " to ", part.last, ", centre ", centre.x(), ", ", centre.y(), ", ",
             centre.z(), ") and ", motions,
             " free rigid motions; fix a region of it, hold one triangle (hold: point), or give it springs",
             loose < count ? ", or attach it to another part" : "",
             rest.symmetry ? " (the symmetry plane stops three of six)" : ""));
}

}  // namespace strake
