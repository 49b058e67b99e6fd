#pragma once
#include "optimize/nlp/surrogate/local_models.hpp"

/// Which directions of a search are symmetric. Internal to the search by models.
namespace strake {

/// Of one mirror image: directions v with image v = mu motion v, mu = 1 for what is its own image (even), -1 for what
/// the image turns around (odd), between them where variables have no images, as patches that are cut otherwise.
class MirrorDirections {
public:
    /// @param along free variables by directions of z @param free their numbers
    MirrorDirections(const MirrorImage& image, const Eigen::MatrixXd& along, const std::vector<int>& free);

    /// Orthonormal directions of z among the combinations of the columns of Q, which are orthonormal, that are more
    /// even than odd: next to these columns, in their order.
    Eigen::MatrixXd even_within(const Eigen::MatrixXd& Q) const;
    /// The part of z that is even or odd, which has an image.
    Eigen::VectorXd in_pairs(const Eigen::VectorXd& z) const;
    double mean_square_mu() const { return mu_.squaredNorm() / static_cast<double>(mu_.size()); }
    /// Of such a part.
    Eigen::VectorXd image(const Eigen::VectorXd& z) const;
    /// What its motion misses of the mirror image of that of z (rms), over all of it.
    double image_error(const Eigen::VectorXd& z) const;

private:
    Eigen::MatrixXd motion_, image_;  ///< by z
    Eigen::MatrixXd directions_;      ///< columns, orthonormal by motion_
    Eigen::VectorXd mu_;
};

/// One design in which all directions take part, and its images, of which a search compares all values.
class MirrorLook {
public:
    MirrorLook(const NonlinearProgram& program, const SampledPoints& points);

    /// What it may find is worth its evaluations.
    bool is_worth(int evaluations_left) const;
    /// In z, from the start: the design, then an image for each of the program's. Empty: none has one.
    std::vector<Eigen::VectorXd> steps(double length, unsigned seed) const;
    /// All values of the design and of its image are the same, to 2 % of their change, or to `blur` if that is more.
    bool is_same(const SampledPoints::Point& start, const SampledPoints::Point& design,
                 const SampledPoints::Point& image, double blur) const;
    /// What a step's image may differ by where levels before have found values to be the same: some of what it misses
    /// of the mirror image. Zero: they have not.
    double blur(std::size_t image, const Eigen::VectorXd& step) const;
    /// The directions that are even by all images that hold; tells the program which do. All where nothing is even.
    /// @param holds of the first images; the others were not compared, and are as on the level before
    Eigen::MatrixXd even(const std::vector<char>& holds) const;

    /// Of evaluations that are left for all directions, those for so many: but three batches, the first of which only
    /// looks around, and all where the limit knew.
    int evaluations_for(Eigen::Index directions, int left, int batch) const;

    std::string words(Eigen::Index directions) const;  ///< for the log

private:
    Eigen::MatrixXd all() const;

    const NonlinearProgram& program_;
    const SampledPoints& points_;
    std::vector<MirrorDirections> mirrors_;
};

/// The image of most that the variables move is again something that they move: the plane is one of what is held, too.
bool keeps_directions(const NonlinearProgram& program, const MirrorImage& image);

/// Number of directions that are even by all mirror images of the program that hold.
int num_even_directions(const NonlinearProgram& program);

}  // namespace strake
