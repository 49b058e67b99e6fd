#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

/// Creases, open boundaries and borders of the input as polylines, each measured by its arc length. A vertex of the
/// output that slides on one is a number s, its place a point of a segment of the input. Internal to core/remesh.
namespace strake {

/// What stays as it is: kept, where there is no manifold, or parts touch; held, at the end of a crease.
enum class FeatureKind : char { crease, boundary, border, kept, held, held_crease, rounded };
inline bool is_rigid(FeatureKind kind) {
    return kind == FeatureKind::kept || kind == FeatureKind::held || kind == FeatureKind::held_crease;
}

/// An edge whose ends lie on curve `curve` at s[0] < s[1]. On a closed curve s runs on beyond its length.
struct FeatureEdge {
    int curve;
    FeatureKind kind;
    std::array<int, 2> v;
    std::array<double, 2> s;
    /// 0 or 1: which end v is. (An edge has two different ends.)
    int end_at(int vertex) const { return v[1] == vertex; }
};

class Curves {
public:
    /// Appends a polyline of at least two points, of which closed ones repeat the first as the last.
    /// @param halves a half-edge of the input along each segment.
    int add(const std::vector<Eigen::Vector3d>& points, const std::vector<int>& halves,
            const std::vector<double>& folds, bool closed);
    int size() const { return static_cast<int>(begin_.size()) - 1; }
    double length(int curve) const { return arc_[begin_[curve + 1] - 1]; }
    bool is_closed(int curve) const { return closed_[curve] != 0; }

    Eigen::Vector3d at(int curve, double s) const;
    int half_at(int curve, double s) const;  ///< of the input, along the segment
    int triangle_at(int curve, double s) const { return half_at(curve, s) / 3; }
    /// The largest fold of the segments between s0 and s1 (s0 < s1), and where: the middle of what lies between.
    struct Fold {
        double angle, s;
    };
    Fold largest_fold(int curve, double s0, double s1) const;
    /// Arc length of the input's vertex nearest to s.
    double nearest_vertex(int curve, double s) const;
    /// Whether the input stays within `slack` of the chord from s0 to s1 (s0 < s1), or within what an arc of its radius
    /// would: 1.05 l^2 / 8R, if that is below five times the slack and the turning below 60 degrees.
    bool chord_fits(int curve, double s0, double s1, double slack) const;

private:
    struct Place {
        int segment;    ///< index of its first point
        double offset;  ///< what to add to arc_ for the period that s is in
    };
    Place place(int curve, double s) const;
    double turn(int curve, int point) const;
    std::vector<int> begin_{0};  ///< first point of each curve
    std::vector<Eigen::Vector3d> points_;
    std::vector<int> halves_;    ///< per point: half-edge along the segment that begins here
    std::vector<double> folds_;  ///< per point: of that segment, radians
    std::vector<double> arc_;
    std::vector<double> turn_;  ///< per point, radians; 0 at ends of open curves
    std::vector<char> closed_;
};

}  // namespace strake
