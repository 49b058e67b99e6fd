#include "optimize/space/motion_images.hpp"
#include "core/fields/displacement_fields.hpp"
#include "evaluated.hpp"
#include "optimize/nlp/surrogate/mirror_directions.hpp"
#include "optimize/space/mirror.hpp"
#include "problems.hpp"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// An ellipsoid that is held at its -x end, so that y and z are left.
Problem with_fields_and_patches(double skew = 0) {
    Problem problem = ellipsoid_problem(3, 3);
    for (int v = 0; v < problem.surface.num_vertices(); ++v) {  // no triangle has an image
        const Eigen::RowVector3d p = problem.surface.vertices.row(v);
        Eigen::Vector3d unit(p[0], p[1] / 0.6, p[2] / 0.4);
        unit = Eigen::AngleAxisd(skew, Eigen::Vector3d::UnitX()) * unit;
        problem.surface.vertices.row(v) << unit[0], 0.6 * unit[1], 0.4 * unit[2];
    }
    problem.parameters.kinds = {VariableKind::normal_load};
    FieldConditions conditions;
    conditions.held = problem.fixed;
    add_fields(problem.parameters,
               std::make_shared<const DisplacementFields>(problem.surface, conditions, FieldOptions{27, {}}));
    return problem;
}

VectorXd parities(const MotionImages& images) {
    return Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(images.image, images.motion).eigenvalues();
}

MirrorImage image_of(const MotionImages& images) { return {images.motion, images.image, true, {}}; }

}  // namespace

TEST(PlanesOfSymmetry, AreOrthogonalAndAll) {
    const auto normals = [](const TriMesh& mesh) {
        std::vector<Eigen::Vector3d> found;
        for (const SymmetryPlane& plane : planes_of_symmetry(mesh)) found.push_back(plane.normal.cwiseAbs());
        return found;
    };
    TriMesh mesh = ellipsoid({1, 0.6, 0.4}, 3);
    EXPECT_EQ(normals(mesh).size(), 3u);
    mesh.vertices.col(0).array() += 0.1 * mesh.vertices.col(0).array().square();
    EXPECT_EQ(normals(mesh), (std::vector<Eigen::Vector3d>{Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()}));
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    TriMesh turned = mesh;
    turned.vertices = mesh.vertices * turn.transpose();
    const auto of_turned = normals(turned);
    ASSERT_EQ(of_turned.size(), 2u);
    EXPECT_LT(std::abs(of_turned[0].dot(turn.col(0).cwiseAbs()) - 1), 1) << "none along the axis";
    EXPECT_EQ(normals(ellipsoid({0.5, 0.5, 0.5}, 3)).size(), 3u);
    mesh.vertices.col(1).array() += 0.1 * mesh.vertices.col(0).array() * mesh.vertices.col(2).array();
    mesh.vertices.col(2).array() += 0.1 * mesh.vertices.col(1).array().square();
    EXPECT_TRUE(normals(mesh).empty());
}

/// Every field is even or odd, and eight normal loads on octants are so in pairs.
TEST(MotionImages, TellEvenFromOdd) {
    for (const double skew : {0.0, 0.3}) {
        const Evaluated e(with_fields_and_patches(skew), skew > 0 ? 0 : 3);
        for (const Eigen::Vector3d normal : {Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()}) {
            const MotionImages images = motion_images(e.space, {normal, 0});
            const VectorXd mu = parities(images);
            // Images lie on the mesh, not on the ellipsoid; triangles of the shell are no images of each other.
            EXPECT_LT((mu.cwiseAbs().array() - 1).abs().maxCoeff(), 0.05) << mu.transpose();
            EXPECT_GT((mu.array() > 0).count(), 8);
            EXPECT_GT((mu.array() < 0).count(), 8);
            const int even = static_cast<int>((mu.array() > 0).count());
            NonlinearProgram program;
            program.start = VectorXd::Zero(e.space.size());
            program.lower = e.space.lower;
            program.upper = e.space.upper;
            program.mirror_images = {image_of(images)};
            EXPECT_EQ(num_even_directions(program), even);
            program.mirror_images[0].holds = false;
            EXPECT_EQ(num_even_directions(program), e.space.size());
        }
    }
}

}  // namespace strake
