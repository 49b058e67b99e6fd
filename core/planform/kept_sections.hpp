#pragma once
#include "core/planform/wing.hpp"

#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <complex>
#include <memory>
#include <mutex>

/// What of a motion is left where wings keep the edges of their sections.
namespace strake {

/// Which leading edges are kept as sections show them (others by their linear motion at the start), how many knots
/// there may be over the semispan, and whether noses of too few points keep their shape. All but the first: the meaning
/// of earlier runs.
enum class KeptRules : int {
    latest,             ///< wherever a polynomial gives the edge; 128; they keep it
    coarse_noses_move,  ///< likewise, but they do not
    earlier             ///< of noses of ten points or more; 64; likewise
};

/// Motions of a surface without what they do to the planform of its wings: u = H (S d - B a), so that on the surface
/// x0 + u leading and trailing edge of each wing, as its sections show them, are where the start has them. Chord,
/// twist, sweep, dihedral and span then are those of the start; thickness and camber are what d makes them.
///
/// S takes out what goes across the sections, so that these stay in their planes. B a moves each section by a map
/// w -> alpha(s) (1 - zeta) + beta(s) zeta of its complex plane, zeta = 0 at the leading and 1 at the trailing edge: a
/// rotation, a scaling and a translation. alpha and beta are piecewise linear along the span, with knots at the rows
/// of vertices of each edge, at most 128 over the semispan, fewer where an irregular mesh could not bring the edges
/// back there, and a their values, found by Newton's method. A motion that turns, scales and moves the sections in
/// their planes is taken out whole.
///
/// H is 1 but at the coarse noses of a side, most of whose sections have fewer than ten points within 4 % of the chord:
/// on triangles that reach there it is 0, and 1 from 20 % of the chord on. Which points show the leading edge of such a
/// nose changes along the span: it stays where none of them moves.
///
/// What is fixed stays fixed: towards it B fades to zero, over a quarter of the root chord. Where the wing shares
/// edges with a body, B and S fade to zero on the body, over half of the root chord. Parts of their own (a body that a
/// wing pierces) keep their motion.
class KeptSections {
public:
    /// @param fixed triangles. @throws InvalidInput: a wing whose edges cannot be kept, with the reason.
    KeptSections(const TriMesh& start, const std::vector<std::shared_ptr<const Wing>>& wings,
                 const std::vector<int>& fixed, KeptRules rules = KeptRules::latest);

    int num_vertices() const { return start_.num_vertices(); }
    int num_knots() const { return num_knots_; }

    /// u by d, n x 3. 0 by 0 to the last bit. @throws SolverError where the edges cannot be brought back; InvalidInput
    /// where there is no section.
    Points kept(const Points& motion) const;
    /// The derivative of `kept` times a motion. @param surface x0 + u; null: the start
    Points rate(const Points* surface, const Points& motion) const;
    /// Its transpose.
    Points pulled_back(const Points* surface, const Points& dJ_dv) const;

    /// From linear parts of maps x -> x + d(x), one a triangle, to those of x -> x + u(x), to first order in d.
    void change_maps(const Points& motion, std::vector<Eigen::Matrix3d>& maps) const;
    /// dJ/d(map) before `change_maps` and dJ/dd, by that of the map of one triangle after it: the transpose.
    Eigen::Matrix3d pull_map(int triangle, const Eigen::Matrix3d& dJ_dF, Points& dJ_dd) const;

private:
    using Complex = std::complex<double>;
    /// One cut that is looked at.
    struct Section {
        std::shared_ptr<const Wing> wing;
        int side = 0;
        double place = 0;
        int leading = -1, trailing = -1;      ///< knots; -1: that edge is not looked at here
        std::vector<int> triangles;           ///< that it may meet
        double chord = 0;                     ///< at the start
        Eigen::Vector2d leading_at = {0, 0};  ///< likewise, in the plane
        bool is_round = false;                ///< the nose has points enough for a polynomial
    };
    /// Of one side of a wing at the start.
    struct Side {
        std::shared_ptr<const Wing> wing;
        int side = 0;
        double reach = 0;
        std::vector<double> places;  ///< of the table
        std::vector<Eigen::Vector3d> leading, trailing;
        std::vector<double> knots[2];  ///< places along the leading and the trailing edge
        std::vector<int> number[2];    ///< of these knots
        bool has_coarse_nose = false;  ///< all along
    };
    struct Term {
        int knot;
        Complex weight;
        double slope;  ///< of the weight by zeta
    };
    /// How much a vertex has of each knot; the plane it moves in.
    struct Share {
        std::vector<Term> terms = {};
        Eigen::Vector3d downstream = Eigen::Vector3d::Zero(), up = Eigen::Vector3d::Zero();
        Complex chord = 1;  ///< of its section
    };
    /// M, the derivative of all edges by the vertices, and M B.
    struct Tangent {
        Points surface;
        Eigen::SparseMatrix<double, Eigen::RowMajor> edges;  ///< 2 knots x 3 n
        Eigen::PartialPivLU<Eigen::MatrixXd> by_knots;
    };

    void lay_out(const std::vector<std::shared_ptr<const Wing>>& wings, const std::vector<int>& fixed, double gap);
    void add_side(const std::shared_ptr<const Wing>& wing, int side, double gap);
    void add_knots(Side& of, int edge, double gap);
    void share_centre();
    void add_sections(const Side& of);
    void place_vertices(const std::vector<int>& fixed);
    bool has_coarse_nose(const Side& of) const;
    void hold_noses();
    Complex fraction(const Side& of, double place, const Eigen::Vector3d& x, Complex& chord) const;
    void place_vertex(int v, const Side& of, double across, double along);
    void drop_fixed_knots();
    Eigen::VectorXd off(const TriMesh& surface, const Points& free, const std::vector<char>& is_linear) const;
    Points held(const Points& free) const;
    double mean_freedom(int triangle) const;
    std::shared_ptr<const Tangent> tangent_at(const Points& surface, bool is_end) const;
    Points in_planes(const Points& motion) const;
    Eigen::Vector3d across_rate(int v, const Eigen::Vector3d& normal, const Eigen::VectorXd& knots) const;

    TriMesh start_;
    KeptRules rules_;
    std::vector<Side> sides_;
    std::vector<Section> sections_;
    int num_knots_ = 0;
    std::vector<Share> shares_;             ///< per vertex
    Points across_;                         ///< n x 3: S = I - across across^T
    Eigen::VectorXd freedom_;               ///< H, per vertex
    bool holds_noses_ = false;              ///< H is not 1
    Eigen::SparseMatrix<double> by_knots_;  ///< B, 3 n x 2 knots
    std::shared_ptr<const Tangent> at_start_;
    mutable std::mutex guard_;
    mutable std::shared_ptr<const Tangent> latest_;
};

}  // namespace strake
