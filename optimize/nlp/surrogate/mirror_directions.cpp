#include "optimize/nlp/surrogate/mirror_directions.hpp"

#include "core/error.hpp"
#include "optimize/nlp/surrogate/spread.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double no_motion = 1e-6;        ///< of the mean: added, so that what moves nothing is neither even nor odd
constexpr double odd = -0.1;              ///< mu below it; what has no image, as patches of one side, has 0
constexpr double paired = 0.9;            ///< |mu| of directions that have an image
constexpr Eigen::Index worth_a_look = 4;  ///< directions that may be spared
constexpr double mostly_paired = 0.8;     ///< mean of mu^2
constexpr int min_batches = 3;
constexpr int min_left = 2;                          ///< evaluations for each of a look
constexpr double same_value = 0.02;                  ///< of its change: meshes are no images of themselves
constexpr double blur_of_error = 5, max_blur = 0.5;  ///< of that change: parts of it may cancel, the error may not
constexpr double rounding = 1e-9;                    ///< of values
constexpr double near_column[] = {0.5, 0.1, 1e-6};   ///< lengths of what a column has left, one round after another

std::vector<int> free_of(const NonlinearProgram& program) {
    std::vector<int> free;
    for (Eigen::Index j = 0; j < program.start.size(); ++j)
        if (program.lower[j] < program.upper[j]) free.push_back(static_cast<int>(j));
    return free;
}

}  // namespace

MirrorDirections::MirrorDirections(const MirrorImage& image, const MatrixXd& along, const std::vector<int>& free) {
    if (free.empty()) return;
    motion_ = along.transpose() * image.motion(free, free) * along;
    image_ = along.transpose() * image.image(free, free) * along;
    motion_.diagonal().array() += no_motion * motion_.trace() / static_cast<double>(motion_.rows());
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> of(0.5 * (image_ + image_.transpose()),
                                                                0.5 * (motion_ + motion_.transpose()));
    directions_ = of.eigenvectors();
    mu_ = of.eigenvalues();
}

MatrixXd MirrorDirections::even_within(const MatrixXd& Q) const {
    if (Q.cols() == 0) return Q;
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> of(Q.transpose() * image_ * Q,
                                                                Q.transpose() * motion_ * Q);
    const Eigen::Index n = Q.cols(), num_odd = (of.eigenvalues().array() < odd).count(), count = n - num_odd;
    if (num_odd == 0) return Q;
    const MatrixXd even = of.eigenvectors().rightCols(count);
    const MatrixXd basis = Eigen::HouseholderQR<MatrixXd>(even).householderQ() * MatrixXd::Identity(n, count);
    MatrixXd found(n, 0);
    std::vector<char> taken(static_cast<std::size_t>(n), 0);
    for (const double least : near_column)
        for (Eigen::Index k = 0; k < n && found.cols() < count; ++k) {
            if (taken[static_cast<std::size_t>(k)]) continue;
            VectorXd left = basis * basis.row(k).transpose();
            for (int round = 0; round < 2; ++round) left -= found * (found.transpose() * left);
            if (left.norm() < least) continue;
            taken[static_cast<std::size_t>(k)] = 1;
            found.conservativeResize(Eigen::NoChange, found.cols() + 1);
            found.rightCols(1) = left.normalized();
        }
    return Q * found;
}

VectorXd MirrorDirections::in_pairs(const VectorXd& z) const {
    const VectorXd share = (mu_.cwiseAbs().array() > paired).cast<double>();
    return directions_ * share.cwiseProduct(directions_.transpose() * (motion_ * z));
}

VectorXd MirrorDirections::image(const VectorXd& z) const {
    const VectorXd sign = (mu_.array() > 0).select(VectorXd::Ones(mu_.size()), -VectorXd::Ones(mu_.size()));
    return directions_ * sign.cwiseProduct(directions_.transpose() * (motion_ * z));
}

double MirrorDirections::image_error(const VectorXd& z) const {
    const VectorXd parts = (directions_.transpose() * (motion_ * z)).cwiseAbs2();
    const double sum = parts.sum(), missed = parts.dot((1 - mu_.array().square()).cwiseMax(0).matrix());
    return sum > 0 ? std::sqrt(missed / sum) : 0;
}

MirrorLook::MirrorLook(const NonlinearProgram& program, const SampledPoints& points)
    : program_(program), points_(points) {
    for (const MirrorImage& image : program.mirror_images)
        mirrors_.emplace_back(image, points.free_along(all()), points.free());
}

MatrixXd MirrorLook::all() const { return MatrixXd::Identity(points_.dimensions(), points_.dimensions()); }

bool MirrorLook::is_worth(int evaluations_left) const {
    if (mirrors_.empty()) return false;
    Eigen::Index spared = 0;
    for (const MirrorDirections& mirror : mirrors_)
        spared = std::max(spared, points_.dimensions() - mirror.even_within(all()).cols());
    return spared >= worth_a_look && evaluations_left > min_left * (static_cast<int>(mirrors_.size()) + 1);
}

std::vector<VectorXd> MirrorLook::steps(double length, unsigned seed) const {
    VectorXd step = latin_hypercube(static_cast<int>(points_.dimensions()), 1, seed).array() - 0.5;
    for (const MirrorDirections& mirror : mirrors_) step = mirror.in_pairs(step);
    if (!(step.norm() > 0)) return {};
    step *= length / step.norm();
    std::vector<VectorXd> steps{step};
    for (const MirrorDirections& mirror : mirrors_) steps.push_back(mirror.image(step));
    return steps;
}

double MirrorLook::blur(std::size_t image, const VectorXd& step) const {
    if (!program_.mirror_images[image].holds) return 0;
    return std::min(max_blur, blur_of_error * mirrors_[image].image_error(step));
}

bool MirrorLook::is_same(const SampledPoints::Point& start, const SampledPoints::Point& design,
                         const SampledPoints::Point& image, double blur) const {
    const VectorXd by_design = design.values - start.values, by_image = image.values - start.values;
    const VectorXd change = by_design.cwiseAbs().cwiseMax(by_image.cwiseAbs());
    VectorXd size = start.values.cwiseAbs();
    size.tail(size.size() - 1) = size.tail(size.size() - 1).cwiseMax(1);  // constraints are scaled
    const VectorXd allowed = (std::max(same_value, blur) * change).cwiseMax(rounding * size);
    return ((by_design - by_image).cwiseAbs().array() <= allowed.array()).all();
}

MatrixXd MirrorLook::even(const std::vector<char>& holds) const {
    MatrixXd even = all();
    for (std::size_t k = 0; k < mirrors_.size(); ++k) {
        const MirrorImage& image = program_.mirror_images[k];
        const bool is_compared = k < holds.size(), is_even = is_compared ? holds[k] != 0 : image.holds;
        if (is_compared && image.found) image.found(is_even);
        if (is_even) even = mirrors_[k].even_within(even);
    }
    return even.cols() > 0 ? even : all();
}

int MirrorLook::evaluations_for(Eigen::Index directions, int left, int batch) const {
    if (std::ranges::any_of(program_.mirror_images, &MirrorImage::holds)) return left;
    const double share = double(directions + 1) / double(points_.dimensions() + 1);
    return std::min(left, std::max(min_batches * batch, static_cast<int>(std::ceil(share * left))));
}

std::string MirrorLook::words(Eigen::Index directions) const {
    return text("values are the same for mirror images: ", directions, " of ", points_.dimensions(),
                " directions are searched, what is symmetric");
}

bool keeps_directions(const NonlinearProgram& program, const MirrorImage& image) {
    const std::vector<int> free = free_of(program);
    const auto n = static_cast<Eigen::Index>(free.size());
    return n > 0 && MirrorDirections(image, MatrixXd::Identity(n, n), free).mean_square_mu() > mostly_paired;
}

int num_even_directions(const NonlinearProgram& program) {
    const std::vector<int> free = free_of(program);
    const auto n = static_cast<Eigen::Index>(free.size());
    if (n == 0) return 0;
    const MatrixXd all = MatrixXd::Identity(n, n);
    MatrixXd even = all;
    for (const MirrorImage& image : program.mirror_images)
        if (image.holds) even = MirrorDirections(image, all, free).even_within(even);
    return static_cast<int>(even.cols());
}

}  // namespace strake
