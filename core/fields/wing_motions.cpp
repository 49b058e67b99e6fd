#include "core/fields/wing_motions.hpp"

#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

using Eigen::Vector3d;

constexpr int out = 0, aft = 1, up = 2;  ///< axes of the frame
constexpr double same_direction = 1e-6;
constexpr int max_along_span = 16, max_along_chord = 10, max_across = 3;
constexpr double opposite_later = 0.5;  ///< sides that move in opposite ways come so much after those that move alike

struct Ordered {
    double order;
    int rank;
    FieldCandidate candidate;
};

class Listing {
public:
    Listing(const WingCoordinates& wing, bool is_symmetric, bool keeps_planform,
            const std::vector<std::string>& motions)
        : has_opposite_(wing.lines().is_both && !is_symmetric),
          keeps_planform_(keeps_planform),
          motions_(motions),
          name_(wing.lines().name),
          flatness_(flatness(wing.lines())) {}

    std::vector<FieldCandidate> up_to(double last) {
        found_.clear();
        last_ = last;
        for (int i = 0; i <= max_along_span; ++i)
            for (int j = 0; j <= max_along_chord; ++j)
                for (int k = 0; k <= max_across; ++k) {
                    if (keeps_planform_)
                        shapes(i, j, k);
                    else
                        all(i, j, k);
                }
        std::stable_sort(found_.begin(), found_.end(), [](const Ordered& a, const Ordered& b) {
            return a.order != b.order ? a.order < b.order : a.rank < b.rank;
        });
        std::vector<FieldCandidate> candidates;
        for (Ordered& one : found_) candidates.push_back(std::move(one.candidate));
        return candidates;
    }

private:
    /// Mean of thickness over chord.
    static double flatness(const WingLines& lines) {
        double sum = 0;
        for (const auto& section : lines.sections) sum += section.thickness / section.chord;
        return sum / static_cast<double>(lines.sections.size());
    }

    /// What leaves leading and trailing edge: j along the chord, k across.
    void shapes(int i, int j, int k) {
        if (k == 0 && j >= 2) add(i + 0.75 * (j - 2), 0, up, i, j, k, text("camber.", j));
        if (k == 1) add(i + 0.75 * j + 0.6, 1, up, i, j, k, text("thickness.", j));
        if (k >= 2) add(i + 0.75 * j + 2.0 * k, 2, up, i, j, k, text("bend.", j, "_", k));
        if (j >= 2 || k >= 1) add(i + 0.75 * j + 2.0 * k + 3, 3, aft, i, j, k, text("stretch.", j, "_", k));
    }

    void all(int i, int j, int k) {
        if (k == 0 && j == 0) {
            add(i, 0, up, i, j, k, "move_up");
            add(i + 0.3, 1, aft, i, j, k, "move_aft");
            if (i > 0) add(i == 1 ? 0.9 : i, 2, out, i, j, k, "move_out");
        } else if (k == 0 && j == 1) {
            add(i + 0.3, 0, up, i, j, k, "twist");
            add(i + 0.6, 1, aft, i, j, k, "chord");
        } else if (k == 0) {
            add(i + 0.5 + 0.6 * (j - 2), 0, up, i, j, k, text("camber.", j));
        } else if (k == 1) {
            add(i + 0.8 + 0.7 * j, 2, up, i, j, k, text("thickness.", j));
        } else {
            add(i + 0.75 * j + 2.0 * k, 4, up, i, j, k, text("bend.", j, "_", k));
        }
        if (j >= 2 || k >= 1) add(i + 0.75 * j + k + 2, 5, aft, i, j, k, text("stretch.", j, "_", k));
        if (i > 0 && j + k >= 1) add(i + 0.75 * j + k + 0.75, 6, out, i, j, k, text("tilt.", j, "_", k));
    }

    void add(double order, int rank, int axis, int i, int j, int k, const std::string& what) {
        const std::string name = text(name_, ".", what, ".s", i);
        if (!motions_.empty() && std::ranges::find(motions_, strake::motion_of(name)) == motions_.end()) return;
        const bool is_out = axis == out;
        if (order <= last_) add_one(order, rank, axis, number_along(i, is_out), j, k, name);
        if (has_opposite_ && i > 0 && order + opposite_later <= last_)
            add_one(order + opposite_later, rank, axis, number_along(i, !is_out), j, k, text(name, ".opposite"));
    }

    void add_one(double order, int rank, int axis, int along, int j, int k, std::string name) {
        FieldCandidate candidate{{{axis, {along, j, k}, 1}}, std::move(name)};
        // A rotation: what is above the chord goes aft as the nose goes up.
        if (axis == up && j == 1 && k == 0) {
            candidate.terms[0].factor = -1;
            candidate.terms.push_back({aft, {along, 0, 1}, flatness_});
        }
        found_.push_back({order, rank, std::move(candidate)});
    }

    static int number_along(int i, bool is_odd) { return i == 0 ? 0 : 2 * i - (is_odd ? 1 : 0); }

    bool has_opposite_, keeps_planform_;
    const std::vector<std::string>& motions_;
    std::string name_;
    double flatness_, last_ = 0;
    std::vector<Ordered> found_;
};

}  // namespace

const std::vector<std::string>& wing_motions() {
    static const std::vector<std::string> motions{"move",      "twist", "chord",   "camber",
                                                  "thickness", "bend",  "stretch", "tilt"};
    return motions;
}

FieldFrame wing_frame(const TriMesh& rest, const WingLines& lines, const std::optional<SymmetryPlane>& plane,
                      bool is_half) {
    if (plane && plane->normal.cross(lines.span).norm() > same_direction)
        throw InvalidInput("fields: the plane of symmetry must be normal to the span of the wing");
    FieldFrame frame;
    frame.axes << lines.span, lines.downstream, lines.up;
    for (int k = 0; k < 3; ++k) {
        const Eigen::VectorXd at = rest.vertices * frame.axes.col(k);
        double low = at.minCoeff(), high = at.maxCoeff();
        if (k == out && plane) {
            const double middle = plane->offset * plane->normal.dot(lines.span);
            const double reach = is_half ? std::max(high - middle, middle - low) : 0.5 * (high - low);
            low = middle - reach, high = middle + reach;
        }
        frame.middle[k] = 0.5 * (low + high);
        frame.half[k] = 0.5 * (high - low);
        Eigen::Index letter = 0;
        frame.axes.col(k).cwiseAbs().maxCoeff(&letter);
        frame.letter[static_cast<std::size_t>(k)] = "xyz"[letter];
    }
    if (plane) frame.plane_axis = out;
    return frame;
}

std::vector<FieldCandidate> wing_candidates(const WingCoordinates& wing, bool is_symmetric, bool keeps_planform,
                                            int count, const std::vector<std::string>& motions) {
    Listing list(wing, is_symmetric, keeps_planform, motions);
    std::vector<FieldCandidate> candidates;
    const double most = max_along_span + max_along_chord + 3.0 * max_across;
    for (double last = 3; last <= most; last *= 1.25) {
        candidates = list.up_to(last);
        if (static_cast<int>(candidates.size()) >= count) break;
    }
    return candidates;
}

}  // namespace strake
