#pragma once
#include "core/mesh/closest_point.hpp"
#include "core/mesh/space_motion.hpp"
#include "core/planform/wing.hpp"

#include <complex>

/// The motion of the sections of wings, and of the space around them.
namespace strake {

/// Whatever moves a wing, each of its sections is shifted, turned and scaled by some amount. These amounts are fitted
/// to the displacement of the vertices by least squares, weighted with their areas, and the planes of the sections take
/// the space along: span stretches it, sweep and dihedral shear it, twist turns it, chord scales it. With s the
/// fraction of the semispan at a point x, d downstream, n up in the section's plane, w the complex place from the
/// wing's axis (downstream + i up), e the chord vector and zeta = w / e,
///   u(x) = g(x) [c(s) + Re(k(s) zeta) d + Im(k(s) zeta) n],
/// c (a vector) and k (complex, length) straight between knots: the stations of the wing, the kinks of its edges, and
/// others between them. This holds what `PlanformMotion` does by span, sweep, dihedral, chord and twist without loss;
/// thickness and camber are no motion of the section. Beyond the tip, s grows to 0.3 more than there at most; before
/// the root all is as there.
///   g(x) = psi(d / reach) (1 - smoothstep(d / (d + b))),   psi(x) = (1 - x)^4 (4 x + 1),
/// d the distance from the wing and b that from all of the surface which is not of it: 1 on the wing, 0 on bodies, and
/// 0 from `reach` on. On the plane of symmetry of a half model whose wing begins there nothing leaves it.
///
/// Between both sides of a whole wing u changes smoothly over a tenth of the semispan. Wings with winglets, where
/// planes of sections meet, are left out.
class SectionMotion : public SpaceMotion {
public:
    /// @param reach length > 0. @throws InvalidInput: as Wing; a reach that is not.
    SectionMotion(const TriMesh& start, const std::vector<std::shared_ptr<const Wing>>& wings, double reach,
                  const std::optional<SymmetryPlane>& symmetry = {});

    int num_vertices() const override { return num_vertices_; }
    Eigen::VectorXd fitted(const Points& displacement) const override;
    Points fitted_transpose(const Eigen::VectorXd& by_amplitude) const override;
    std::unique_ptr<const Field> at(const Points& points) const override;

private:
    using Complex = std::complex<double>;
    struct Knot {
        double place;          ///< fraction of the semispan
        Complex chord;         ///< e
        Eigen::Vector3d axis;  ///< in space
    };
    /// A part of the motion at a point.
    struct Spot {
        int side, knot;  ///< before it
        double along;    ///< from that knot to the next, beyond the tip above 1
        double weight;
        Complex zeta;
    };
    /// One side of a wing. Amplitudes of a knot: c, then k.
    struct Side {
        Eigen::Vector3d span, downstream, up;
        double root = 0, reach = 0;
        std::vector<Knot> knots;
        int first = 0;  ///< its first amplitude
        std::vector<int> vertices;
        std::vector<Spot> spots = {};  ///< likewise
        Eigen::VectorXd area;          ///< per vertex
        Eigen::MatrixXd inverse = {};  ///< of the normal equations
        double outboard(const Eigen::Vector3d& x) const { return span.dot(x) - root; }
    };
    struct MovedWing {
        int first = 0, count = 0;                        ///< sides
        std::unique_ptr<ClosestPointTree> tree, others;  ///< null: there are none
    };
    class At;

    void add_wing(const TriMesh& start, const std::shared_ptr<const Wing>& wing);
    void prepare_fit(Side& side, int number, const TriMesh& start, const std::vector<int>& triangles);
    Spot spot_between(int side, int knot, double place, double weight, const Eigen::Vector3d& x) const;
    Spot spot_at(int side, const Eigen::Vector3d& x, double weight) const;
    void add_all_spots(const Eigen::Vector3d& x, std::vector<Spot>& found) const;
    double share_of(const MovedWing& wing, const Eigen::Vector3d& x) const;
    bool is_image(const Eigen::Vector3d& x) const;
    Eigen::Vector3d mirrored(const Eigen::Vector3d& x) const;
    Eigen::Vector3d moved(const Spot& spot, const Eigen::VectorXd& amplitudes) const;
    void add_transposed(const Spot& spot, const Eigen::Vector3d& by, Eigen::VectorXd& amplitudes) const;
    int size() const;

    int num_vertices_;
    double reach_;
    std::optional<SymmetryPlane> symmetry_;
    double side_of_plane_ = 1;  ///< on which the surface lies
    std::vector<Side> sides_;
    std::vector<MovedWing> wings_;
};

}  // namespace strake
