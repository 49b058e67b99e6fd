#pragma once
#include "optimize/space/rest_facts.hpp"

#include <limits>

/// How far the surface may be from its datum: a property of shapes, whatever the
/// variables are. Each vertex has up to three conditions, direction.(v - datum) <= limit, all convex: the distance in
/// any direction, and where the sides differ the part along the datum's normal and that against it.
namespace strake {

/// n x 3 unit normals of the vertices: the area-weighted mean of their triangles'; zero where these cancel.
Points vertex_normals(const TriMesh& mesh);

class MotionLimit {
public:
    /// A condition of one vertex, linear about the shape that it was taken at. On a convex limit it cuts nothing off.
    struct Row {
        int vertex = 0;
        Eigen::RowVector3d direction;  ///< unit
        double value = 0;              ///< direction.(v - datum) - limit: <= 0 within
        double limit = 0;
    };
    /// Where the limit is used most.
    struct Use {
        int vertex = -1;    ///< -1: no vertex has a limit
        double share = 0;   ///< of its limit
        double limit = 0;   ///< length
        int num_there = 0;  ///< vertices that use the share that was asked for
    };

    MotionLimit() = default;  ///< none
    /// @param datum the surface under the given loads and strains, all variables zero; n x 3.
    MotionLimit(const RestFacts& rest, Points datum);

    bool is_none() const { return datum_.rows() == 0; }
    /// Every vertex keeps this share of its limit to spare. Limits of zero are kept to half the tolerance of `excess`.
    bool is_within(const Points& vertices, double slack) const;
    /// Of limits above zero. @param nearly share of its limit at which a vertex counts as being there
    Use max_use(const Points& vertices, double nearly) const;
    /// In words, by how much a vertex is beyond (more than 1e-9 of the limit); empty: the shape is within.
    std::string excess(const Points& vertices) const;
    /// Conditions of vertices that use at least `min_used` of their limit, spread over the surface: the nearest to
    /// their limits first, at most `count`.
    std::vector<Row> rows(const Points& vertices, double min_used, int count) const;
    /// A length that limits are compared with, > 0.
    double reference() const { return reference_; }
    double diagonal() const { return diagonal_; }
    const Points& datum() const { return datum_; }

private:
    template <class Visit>
    void each(const Points& vertices, const Visit& visit) const;

    Points datum_, normal_;  ///< normal_: empty where the sides do not differ
    Eigen::VectorXd outward_, inward_;
    double reference_ = 0, diagonal_ = 0;
};

/// Shapes are limited at all.
bool limits_motion(const Parameters& parameters);
/// Whether designs that are limited keep the border of what is held smooth (`keep: smooth_border`). Not beside a
/// planform, which moves the root's neighbours by itself, and whose ranges say how far.
bool limits_border(const Parameters& parameters);

/// The same problem without a limit that nobody has written: only a run has one by default. Its variables keep their
/// units.
Parameters with_stated_limit(Parameters parameters);

/// The largest limit of a vertex, in diagonals; infinity: none.
double largest_limit(const Parameters& parameters);

/// Response of the variables at x = 1, in diagonals.
double variable_scale(const Parameters& parameters);

/// The variable is bounded by what the user has said of it alone.
bool has_own_limit(const UserVariable& variable);

}  // namespace strake
