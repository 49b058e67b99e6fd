#include "optimize/nlp/surrogate/mirror_directions.hpp"
#include "optimize/nlp/minimizer.hpp"
#include "programs.hpp"

#include <gtest/gtest.h>

/// Searches by models where values are the same for mirror images.
namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MinimizeOptions by_models(int evaluations) {
    MinimizeOptions how;
    how.method = Method::model;
    how.max_evaluations = evaluations;
    return how;
}

/// What is odd in its last half, by two mirror images: x_5 to x_8, and x_3, x_4, x_7, x_8.
NonlinearProgram mirrored_bowl(double tilt) {
    NonlinearProgram p;
    p.start = VectorXd::Zero(8);
    p.lower = VectorXd::Constant(8, -3);
    p.upper = VectorXd::Constant(8, 3);
    p.evaluate = [tilt](const VectorXd& x) {
        Evaluation at;
        at.objective = (x.head(2) - vec({0.5, -0.4})).squaredNorm() + 3 * x.tail(6).squaredNorm() + tilt * x[6] +
                       0.1 * std::cos(x[4] * x[4]);
        return at;
    };
    for (const auto& mu : {vec({1, 1, 1, 1, -1, -1, -1, -1}), vec({1, 1, -1, -1, 1, 1, -1, -1})})
        p.mirror_images.push_back({MatrixXd::Identity(8, 8), mu.asDiagonal(), false, [](bool) {}});
    return p;
}

}  // namespace

TEST(MirrorDirections, WhereMirrorImagesHaveTheSameValuesWhatIsSymmetricIsSearched) {
    for (const double tilt : {0.0, 2.0}) {
        NonlinearProgram p = mirrored_bowl(tilt);
        std::vector<char> found;
        for (MirrorImage& image : p.mirror_images) image.found = [&](bool holds) { found.push_back(holds); };
        std::vector<VectorXd> seen;
        p.evaluate = [&seen, inner = p.evaluate](const VectorXd& x) { return seen.push_back(x), inner(x); };
        MinimizeOptions how = by_models(41);
        how.limit_follows_variables = true;
        const MinimizeResult r = minimize(p, how);
        EXPECT_EQ(found, (tilt == 0 ? std::vector<char>{1, 1} : std::vector<char>{0}));
        ASSERT_GT(seen.size(), 10u);
        double beside = 0;  // of the symmetric designs, after the start, the design and its images
        for (std::size_t k = 4; k < seen.size(); ++k) beside = std::max(beside, seen[k].tail(6).norm());
        if (tilt == 0) {
            EXPECT_LT(beside, 1e-9);
            EXPECT_NEAR(r.best.objective, 0.1, 1e-4);
            EXPECT_LE(r.evaluations, 4 + 3 * 8) << "three of nine, but three batches";
        } else {
            EXPECT_GT(beside, 0.1);
            EXPECT_LT(r.best.objective, -tilt * tilt / 12 + 0.11) << "else it has not gone there";
            EXPECT_GT(r.evaluations, 28);
        }
    }
    NonlinearProgram p = mirrored_bowl(0);  // one of the images holds
    p.evaluate = [inner = p.evaluate](const VectorXd& x) {
        Evaluation at = inner(x);
        at.objective -= x[5];
        return at;
    };
    std::swap(p.mirror_images[0], p.mirror_images[1]);
    const MinimizeResult r = minimize(p, by_models(60));
    EXPECT_NEAR(r.x[2], 0, 1e-9);
    EXPECT_NEAR(r.x[5], 1.0 / 6, 1e-2);
}

/// The start misses a limit that is known exactly: what leads back to it is symmetric, too, and has fewer coordinates.
TEST(MirrorDirections, FirstStepsKeepAnExactLimitInTheCoordinatesThatAreLeft) {
    NonlinearProgram p;
    p.start = VectorXd::Zero(8);
    p.lower = VectorXd::Constant(8, -3);
    p.upper = VectorXd::Constant(8, 3);
    p.num_inequalities = 1;
    p.evaluate = [](const VectorXd& x) {
        Evaluation at;
        at.objective = (x - VectorXd::LinSpaced(8, -0.1, 0.1).cwiseAbs()).squaredNorm();
        at.constraints = VectorXd::Constant(1, 0.4 - x.sum());
        return at;
    };
    NonlinearProgram cheap = p;
    cheap.differentiate = [](const VectorXd&, Evaluation& at) {
        at.gradient = VectorXd::Zero(8);
        at.jacobian = -MatrixXd::Ones(1, 8);
    };
    p.low_fidelity = LowFidelity{
        std::make_shared<const NonlinearProgram>(cheap), {LowFidelityValue::none, LowFidelityValue::same}, nullptr};
    const MatrixXd swapped = MatrixXd::Identity(8, 8).rowwise().reverse();
    bool holds = false;
    p.mirror_images.push_back({MatrixXd::Identity(8, 8), swapped, false, [&](bool found) { holds = found; }});
    std::vector<VectorXd> seen;
    p.evaluate = [&seen, inner = p.evaluate](const VectorXd& x) { return seen.push_back(x), inner(x); };
    MinimizeOptions how = by_models(11);
    how.batch = 4;
    minimize(p, how);
    ASSERT_TRUE(holds);
    ASSERT_EQ(seen.size(), 11u);
    for (std::size_t k = 3; k < seen.size(); ++k) {
        EXPECT_LT((seen[k] - seen[k].reverse()).norm(), 1e-9) << k;
        EXPECT_GE(seen[k].sum(), 0.4 - 1e-6) << k;
    }
}

TEST(MirrorDirections, EvenKeepTheOrderOfTheirColumns) {
    const VectorXd mu = (VectorXd(6) << 1, -1, 1, -1, 1, 1).finished();
    const MatrixXd all = MatrixXd::Identity(6, 6);
    const MirrorDirections mirror({all, mu.asDiagonal(), false, {}}, all, {0, 1, 2, 3, 4, 5});
    const MatrixXd wanted = all(Eigen::all, std::vector<int>{0, 2, 4, 5});
    EXPECT_LT((mirror.even_within(all) - wanted).cwiseAbs().maxCoeff(), 1e-12);
    const VectorXd z = (VectorXd(6) << 1, 2, 3, 4, 5, 6).finished();
    EXPECT_LT((mirror.in_pairs(z) - z).norm(), 1e-5 * z.norm());  // what moves nothing has no image: no_motion
    EXPECT_LT((mirror.image(z) - mu.cwiseProduct(z)).norm(), 1e-5 * z.norm());
    EXPECT_EQ(mirror.even_within(wanted), wanted);
}

/// What levels before have found holds where an image is no better than that its values differ so much; what differs
/// altogether is refuted. In runs of before little was enough.
TEST(MirrorDirections, BlurredImagesRefuteNoSymmetryThatHasHeld) {
    const auto found = [](double mu, double tilt, bool has_held, bool doubts) {
        NonlinearProgram p = mirrored_bowl(tilt);
        p.mirror_images.resize(1);
        p.mirror_images[0].image.diagonal().tail(4).setConstant(-mu);
        p.mirror_images[0].holds = has_held;
        bool holds = !has_held;
        p.mirror_images[0].found = [&](bool is_same) { holds = is_same; };
        MinimizeOptions how = by_models(30);
        how.images_are_exact = doubts;
        minimize(p, how);
        return holds;
    };
    EXPECT_TRUE(found(0.99, 0.02, true, false));
    EXPECT_FALSE(found(0.99, 0.02, false, false)) << "nothing has held before";
    EXPECT_FALSE(found(0.99, 0.02, true, true)) << "a run of before";
    EXPECT_FALSE(found(1, 0.02, true, false)) << "an exact image";
    EXPECT_FALSE(found(0.99, 3, true, false));
}

TEST(MirrorDirections, TellWhatImagesMiss) {
    const VectorXd mu = vec({1, -0.8, 0.6});
    const MatrixXd all = MatrixXd::Identity(3, 3);
    const MirrorDirections mirror({all, mu.asDiagonal(), false, {}}, all, {0, 1, 2});
    EXPECT_NEAR(mirror.image_error(vec({0, 2, 0})), 0.6, 1e-5);  // what moves nothing has no image: no_motion
    EXPECT_NEAR(mirror.image_error(vec({0, 0, -1})), 0.8, 1e-5);
    EXPECT_NEAR(mirror.image_error(vec({1, 0, 1})), std::sqrt(0.32), 1e-5);
    EXPECT_LT(mirror.image_error(vec({1, 0, 0})), 3e-3);
    EXPECT_EQ(mirror.image_error(VectorXd::Zero(3)), 0);
}

}  // namespace strake
