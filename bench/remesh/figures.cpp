// remesh_figures BEFORE AFTER ANGLE_DEG: one row of a Markdown table, by the measures of the tests.
#include "core/formats/io.hpp"
#include "measure.hpp"

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
    using namespace strake;
    if (argc != 4) return std::fputs("remesh_figures BEFORE AFTER ANGLE_DEG\n", stderr), 2;
    const TriMesh before = read_surface(argv[1]).mesh, after = read_surface(argv[2]).mesh;
    const Shape shape = shape_of(after);
    const double diagonal = box_diagonal(before), angle = std::atof(argv[3]);
    const Intersections was = intersections(before), is = intersections(after);
    const auto creases = creases_of(before, angle);
    std::printf("%d | %.3f | %.3f | %.2g | %.1f, %.1f | %.0f %% | %.1e | ", after.num_triangles(), shape.mean,
                shape.fifth_percentile, shape.smallest, shape.smallest_angle, shape.largest_angle, 100 * shape.regular,
                hausdorff(before, after) / diagonal);
    if (creases.empty())
        std::printf("- | ");
    else  // of half the angle: noise in a crease must not count as its end
        std::printf("%.1e | ", farthest(creases, creases_of(after, 0.5 * angle), true) / diagonal);
    std::printf("%zu > %zu\n", was.apart.size() + was.adjacent.size(), is.apart.size() + is.adjacent.size());
    return 0;
}
