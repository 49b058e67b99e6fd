#pragma once
#include "core/fields/field_frame.hpp"

#include <string>
#include <vector>

/// Coordinates of a wing as smooth functions of space, for displacement fields.
namespace strake {

/// A wing by its sections, as displacement fields need it. Planes are streamwise.
struct WingLines {
    std::string name = "wing";
    Eigen::Vector3d span = Eigen::Vector3d::UnitY(), downstream = Eigen::Vector3d::UnitX(),
                    up = Eigen::Vector3d::UnitZ();  ///< unit, square to each other; `span` outboard on the first side
    double centre = 0;                              ///< coordinate along `span` of the plane between both sides
    double root = 0;                                ///< distance of the root from there
    double reach = 1;                               ///< from the root to the tip
    bool is_both = false;                           ///< the wing has two sides, mirror images about `centre`
    struct Section {
        double place;          ///< fraction of `reach`, from the root
        double front, height;  ///< leading edge: downstream and up
        double chord, rise;    ///< from there to the trailing edge: downstream and up
        double thickness;      ///< largest
    };
    std::vector<Section> sections;  ///< by place, at least two
};

/// (s, xi, eta) of a point: fraction of the semispan from the root on, of the chord between leading and trailing edge,
/// height over the line between them in halves of the largest thickness there. Between the sections edges and thickness
/// are cubic splines with one slope at each (straight where the edges are), beyond them they go on straight; so the
/// coordinates have continuous derivatives, but on the plane between both sides of a swept wing.
///
/// Functions are products of one in s, one in xi and a power of eta, by their numbers:
///     along s    0: 1;  2 n - 1: +-s P_(n-1)(2 s - 1), the sign that of the side;  2 n: s P_(n-1)(2 s - 1)
///     along xi   0: 1;  1: X = 2 xi - 1;  k: (P_k(X) - P_(k-2)(X)) / (2 k - 1), zero at both edges
/// P are Legendre polynomials. All but the first along s vanish at the root. A number -1 - k along s stands for the
/// coordinate k in the frame of the fields.
class WingCoordinates {
public:
    explicit WingCoordinates(WingLines lines);

    const WingLines& lines() const { return lines_; }

    struct At {
        double s, side, xi, eta;              ///< side: 1 or -1
        Eigen::Vector3d by_s, by_xi, by_eta;  ///< gradients
    };
    At at(const Eigen::Vector3d& x) const;

private:
    struct Values {
        Eigen::Matrix<double, 5, 1> value, slope;  ///< front, height, chord, rise, thickness; by s
    };
    Values section_at(double s) const;

    WingLines lines_;
    std::vector<Eigen::Matrix<double, 5, 1>> value_, slope_;  ///< at the sections
};

/// The products of functions at one point.
class WingFunctions {
public:
    /// @param frame of the coordinates k
    WingFunctions(const WingCoordinates& wing, const FieldFrame& frame, const std::vector<std::array<int, 3>>& numbers);
    void set(const Eigen::Vector3d& x);
    double value(const std::array<int, 3>& number) const;
    Eigen::Vector3d gradient(const std::array<int, 3>& number) const;

private:
    struct Along {
        std::vector<double> value, slope;
    };
    void set_span();
    void set_chord();
    const WingCoordinates& wing_;
    const FieldFrame& frame_;
    WingCoordinates::At at_{};
    Eigen::Vector3d local_ = Eigen::Vector3d::Zero();
    Along span_, chord_, across_, legendre_;
};

}  // namespace strake
