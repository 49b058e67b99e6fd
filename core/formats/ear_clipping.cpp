#include "core/formats/ear_clipping.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace strake {
namespace {

using Triple = std::array<int, 3>;

class EarClipping {
public:
    EarClipping(const Points& polygon, const Eigen::Vector3d& normal, const std::function<bool(int, int)>& is_taken)
        : is_taken_(is_taken), n_(static_cast<int>(polygon.rows())) {
        const Eigen::Vector3d u = normal.unitOrthogonal(), w = normal.cross(u);
        for (int i = 0; i < n_; ++i) {
            // Far from the origin the products would lose the digits that distinguish the corners.
            const Eigen::Vector3d arm = polygon.row(i) - polygon.row(0);
            at_.push_back({arm.dot(u), arm.dot(w)});
            before_.push_back((i + n_ - 1) % n_);
            after_.push_back((i + 1) % n_);
        }
        quality_.assign(static_cast<std::size_t>(n_), 0);
    }

    std::vector<Triple> run() {
        std::vector<Triple> triangles;
        look_at_all();
        for (int left = n_; left > 3; --left) {
            int ear = best();
            if (!(quality_[ear] > 0)) {  // a corner inside an ear may be cut off by now
                look_at_all();
                ear = best();
            }
            if (!(quality_[ear] > 0)) return {};
            const int a = before_[ear], b = after_[ear];
            triangles.push_back({a, ear, b});
            after_[a] = b;
            before_[b] = a;
            quality_[ear] = -1;
            if (left == 4) {
                if (!(cross(before_[a], a, b) > 0)) return {};
                triangles.push_back({before_[a], a, b});
                return triangles;
            }
            for (const int v : {a, b}) quality_[v] = quality(v);
        }
        return {{0, 1, 2}};
    }

private:
    int best() const { return static_cast<int>(std::max_element(quality_.begin(), quality_.end()) - quality_.begin()); }
    void look_at_all() {
        for (int v = 0; v < n_; ++v)
            if (quality_[v] >= 0) quality_[v] = quality(v);
    }
    double cross(int i, int j, int k) const {
        const Eigen::Vector2d a = at_[j] - at_[i], b = at_[k] - at_[i];
        return a.x() * b.y() - a.y() * b.x();
    }
    double quality(int v) const {
        const int a = before_[v], b = after_[v];
        const double area = cross(a, v, b);
        const double sides =
            (at_[v] - at_[a]).squaredNorm() + (at_[b] - at_[v]).squaredNorm() + (at_[a] - at_[b]).squaredNorm();
        if (!(area > 1e-12 * sides) || (is_taken_ && is_taken_(a, b))) return 0;
        const double margin = -1e-12 * sides;
        for (int i = after_[b]; i != a; i = after_[i])
            if (cross(a, v, i) >= margin && cross(v, b, i) >= margin && cross(b, a, i) >= margin) return 0;
        return area / sides;
    }

    const std::function<bool(int, int)>& is_taken_;
    int n_;
    std::vector<Eigen::Vector2d> at_;
    std::vector<int> before_, after_;
    std::vector<double> quality_;  ///< of the ear at each corner; 0: none, -1: cut off
};

}  // namespace

Eigen::Vector3d polygon_area_vector(const Points& p) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const Eigen::RowVector3d origin = p.row(0);
    for (Eigen::Index i = 0; i < p.rows(); ++i)
        sum += (p.row(i) - origin).transpose().cross((p.row((i + 1) % p.rows()) - origin).transpose());
    return sum;
}

std::vector<Triple> clip_ears(const Points& polygon, const Eigen::Vector3d& normal,
                              const std::function<bool(int, int)>& is_taken) {
    return EarClipping(polygon, normal, is_taken).run();
}

}  // namespace strake
