// As-rigid-as-possible deformation of CGAL as Debian ships it, beside Strake's shell: arap_table [wing:22000 |
// body:131000 | FILE]... The first 5 % of the longest axis stay, the last tenth goes across it by 10 % of the diagonal
// and turns by 20 degrees about it; all else is free. CPU seconds of the process: what CGAL takes for preprocessing and
// 100 iterations, and what Strake takes from the bare surface to full convergence; steps in diagonals.
#include "bench/shell_cases.hpp"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_deformation.h>

#include <cstdio>

namespace {

using namespace strake;
using Mesh = CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3>;

struct Task {
    TriMesh mesh;
    ShellOptions options;
    RigidMotion motion;
    double diagonal = box_diagonal(mesh);
    std::vector<char> is_held;  ///< vertices whose triangles all stay or all move
    Points target;              ///< places of these

    explicit Task(const std::string& name) : Task(HeldShell(bench_surface(name))) {}

private:
    explicit Task(HeldShell held) : mesh(std::move(held.mesh)), options(std::move(held.options)) {
        const Box box = bounding_box(mesh);
        const Points centroid = triangle_centroids(mesh);
        int axis = 0;
        const double length = (box.max - box.min).maxCoeff(&axis);
        motion.translation[axis == 2 ? 0 : 2] = 0.1 * diagonal;
        motion.rotation[axis] = 20 * EIGEN_PI / 180;
        motion.about = (box.min + box.max) / 2;
        target = mesh.vertices;
        is_held.assign(mesh.num_vertices(), 1);
        for (int t = 0; t < mesh.num_triangles(); ++t) {
            const bool moves = centroid(t, axis) > box.min[axis] + 0.9 * length;
            if (moves) options.pin[t] = 1;
            for (const int v : mesh.triangles.row(t)) {
                if (options.pin[t] == free_prism) is_held[v] = 0;
                if (moves) target.row(v) = moved(mesh.vertices.row(v)).transpose();
            }
        }
    }
    Eigen::Vector3d moved(const Eigen::Vector3d& x) const {
        const double angle = motion.rotation.norm();
        return motion.about + Eigen::AngleAxisd(angle, motion.rotation / angle) * (x - motion.about) +
               motion.translation;
    }
};

template <CGAL::Deformation_algorithm_tag algorithm>
void by_cgal(const Task& task, const char* name) {
    Mesh mesh;
    for (int v = 0; v < task.mesh.num_vertices(); ++v)
        mesh.add_vertex({task.mesh.vertices(v, 0), task.mesh.vertices(v, 1), task.mesh.vertices(v, 2)});
    for (int t = 0; t < task.mesh.num_triangles(); ++t) {
        const auto corner = [&](int c) { return Mesh::Vertex_index(task.mesh.triangles(t, c)); };
        mesh.add_face(corner(0), corner(1), corner(2));
    }
    const double start = cpu();
    CGAL::Surface_mesh_deformation<Mesh, CGAL::Default, CGAL::Default, algorithm> deformation(mesh);
    deformation.insert_roi_vertices(mesh.vertices().begin(), mesh.vertices().end());
    for (const auto v : mesh.vertices())
        if (task.is_held[v.idx()]) deformation.insert_control_vertex(v);
    if (!deformation.preprocess()) {
        std::printf("| %s | failed | | | |\n", name);
        return;
    }
    const double ready = cpu();
    for (const auto v : mesh.vertices()) {
        const auto p = task.target.row(v.idx());
        if (task.is_held[v.idx()]) deformation.set_target_position(v, {p[0], p[1], p[2]});
    }
    deformation.deform(99, 0);
    std::vector<Mesh::Point> before(mesh.points().begin(), mesh.points().end());
    deformation.deform(1, 0);
    const double end = cpu();
    double step = 0;
    for (const auto v : mesh.vertices())
        step = std::max(step, std::sqrt(CGAL::squared_distance(mesh.point(v), before[v.idx()])));
    std::printf("| %s, 100 iterations | %.2f | %.2f | %.2f | %.1e |\n", name, ready - start, end - ready, end - start,
                step / task.diagonal);
    std::fflush(stdout);
}

void by_strake(const Task& task, LinearSolver solver, const char* name) {
    ShellOptions options = task.options;
    options.solver = solver;
    options.expected_solves = 1;
    const double start = cpu();
    PrimoShell shell(task.mesh, options);
    const double ready = cpu();
    const Equilibrium end = shell.solve({}, {task.motion});
    const double done = cpu();
    std::printf("| %s: %s, %d steps | %.2f | %.2f | %.2f | %.1e |\n", name, to_string(end.status).c_str(),
                end.iterations, ready - start, done - ready, done - start, end.last_step);
    std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
    for (int i = 1; i < argc; ++i) {
        const Task task(argv[i]);
        std::printf(
            "\n%s: %d triangles\n\n| by | set-up, s | solve, s | in all, s | last step |\n|---|---|---|---|---|\n",
            argv[i], task.mesh.num_triangles());
        by_cgal<CGAL::SPOKES_AND_RIMS>(task, "CGAL, spokes and rims");
        by_cgal<CGAL::SRE_ARAP>(task, "CGAL, smooth rotations");
        by_strake(task, LinearSolver::direct, "Strake, direct");
        by_strake(task, LinearSolver::multigrid, "Strake, multigrid");
    }
    return 0;
}
