#include "core/volume/cell_check.hpp"

#include "core/error.hpp"
#include "core/volume/blocks.hpp"

#include <gtest/gtest.h>

namespace strake {
namespace {

Points points_of(std::initializer_list<std::array<double, 3>> rows) {
    Points out(static_cast<Eigen::Index>(rows.size()), 3);
    Eigen::Index i = 0;
    for (const auto& row : rows) out.row(i++) << row[0], row[1], row[2];
    return out;
}

/// One cell of a kind; its signed volume.
double volume_of(int kind, const Points& points, std::vector<int> corners) {
    VolumeMesh mesh;
    mesh.points = points;
    std::vector<int> kinds;
    add_cell(mesh, kind, corners, kinds);
    return cell_sizes(mesh, points).volume[0];
}

TEST(CellCheck, KnowsTheVolumesOfAllKinds) {
    const Points cube = points_of(
        {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 2}, {1, 0, 2}, {1, 1, 2}, {0, 1, 2}, {0.5, 0.5, 3}});
    EXPECT_NEAR(volume_of(10, cube, {0, 1, 3, 4}), 1.0 / 3, 1e-15);
    EXPECT_NEAR(volume_of(10, cube, {0, 3, 1, 4}), -1.0 / 3, 1e-15);
    EXPECT_NEAR(volume_of(12, cube, {0, 1, 2, 3, 4, 5, 6, 7}), 2, 1e-14);
    EXPECT_NEAR(volume_of(11, cube, {0, 1, 3, 2, 4, 5, 7, 6}), 2, 1e-14);
    EXPECT_NEAR(volume_of(13, cube, {0, 1, 3, 4, 5, 7}), 1, 1e-14);
    EXPECT_NEAR(volume_of(14, cube, {0, 1, 2, 3, 8}), 1, 1e-14);
    Points hexagon(12, 3);
    for (int k = 0; k < 12; ++k) hexagon.row(k) << std::cos(k * M_PI / 3), std::sin(k * M_PI / 3), k / 6;
    EXPECT_NEAR(volume_of(16, hexagon, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}), 1.5 * std::sqrt(3.0), 1e-14);
}

TEST(CellCheck, TurnsKindsThatAProgramNumbersTheOtherWayRound) {
    VolumeMesh mesh;
    mesh.points = points_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}});
    std::vector<int> kinds;
    add_cell(mesh, 13, std::vector<int>{0, 2, 1, 3, 5, 4}, kinds);
    EXPECT_LT(cell_sizes(mesh, mesh.points).volume[0], 0);
    orient_by_majority(mesh, kinds);
    EXPECT_NEAR(cell_sizes(mesh, mesh.points).volume[0], 0.5, 1e-15);
}

TEST(CellCheck, FindsWhereCellsTurnInsideOut) {
    const VolumeMesh mesh = mesh_of(block(4));
    EXPECT_EQ(mesh.num_cells, 64);
    EXPECT_NEAR(cell_sizes(mesh, mesh.points).volume.sum(), 1, 1e-14);
    const CellCheck same = check_cells(mesh, mesh.points, mesh.points);
    EXPECT_EQ(same.newly_bad, 0);
    EXPECT_EQ(same.smallest_ratio, 1);
    Points moved = mesh.points;
    moved.col(0) *= 1.5;
    EXPECT_NEAR(check_cells(mesh, mesh.points, moved).smallest_ratio, 1, 1e-12);
    EXPECT_NEAR(check_cells(mesh, mesh.points, moved).largest_ratio, 1.5, 1e-12);
    moved = mesh.points;
    moved.row(62) += Eigen::RowVector3d(0.6, 0, 0);  // an inner point, past its neighbour
    const CellCheck bad = check_cells(mesh, mesh.points, moved);
    EXPECT_GT(bad.inverted + bad.folded, 0);
    EXPECT_EQ(bad.newly_bad, bad.inverted + bad.folded);
    EXPECT_EQ(bad.inverted_before + bad.folded_before, 0);
    EXPECT_LT((bad.worst_at.transpose() - mesh.points.row(62)).norm(), 0.5);
    EXPECT_NEAR(bad.worst_before, 1.0 / 64, 1e-15);
    moved = mesh.points;
    moved(62, 1) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_GT(check_cells(mesh, mesh.points, moved).inverted, 0) << "what is not a number is not good";
    EXPECT_THROW(check_cells(mesh, mesh.points, mesh.points.topRows(5)), InvalidInput);
}

TEST(CellCheck, AMirroredMeshIsInvertedEverywhere) {
    const VolumeMesh mesh = mesh_of(block(2));
    Points mirrored = mesh.points;
    mirrored.col(1) *= -1;
    const CellCheck check = check_cells(mesh, mesh.points, mirrored);
    EXPECT_EQ(check.inverted, 8);
    EXPECT_NEAR(check.smallest_ratio, -1, 1e-12);
}

}  // namespace
}  // namespace strake
