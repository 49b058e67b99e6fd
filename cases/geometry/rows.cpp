#include "cases/geometry/rows.hpp"

#include "core/error.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace strake::example {
namespace {

/// How bad a triangle is: 1 for an equilateral one, growing without limit towards a sliver.
double badness(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const double edges = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
    const double doubled_area = (b - a).cross(c - a).norm();
    const double q = edges / std::max(2.0 * std::sqrt(3.0) * doubled_area, 1e-300);
    return q * q;
}

/// Best path through the strip: cell (i, j) says that rows a[0..i] and b[0..j] are stitched. Only j near the
/// straight line i -> j are looked at.
class StripPath {
public:
    StripPath(const SurfaceBuilder& builder, const std::vector<int>& a, const std::vector<int>& b)
        : builder_(builder), a_(a), b_(b), na_(static_cast<int>(a.size()) - 1), nb_(static_cast<int>(b.size()) - 1) {
        cost_.assign(static_cast<std::size_t>(na_ + 1) * width, std::numeric_limits<double>::infinity());
        from_a_.assign(cost_.size(), 0);
        fill();
    }
    bool advances_a(int i, int j) const { return from_a_[index(i, j)] != 0; }

private:
    static constexpr int half = 8, width = 2 * half + 1;
    int centre(int i) const { return na_ == 0 ? nb_ / 2 : static_cast<int>(std::llround(double(i) * nb_ / na_)); }
    bool inside(int i, int j) const {
        return i >= 0 && j >= 0 && i <= na_ && j <= nb_ && std::abs(j - centre(i)) <= half;
    }
    std::size_t index(int i, int j) const { return static_cast<std::size_t>(i) * width + (j - centre(i) + half); }
    double step_cost(int p, int q, int r) const {
        if (p == q || q == r || p == r) return 0;
        const auto& points = builder_.vertices;
        const auto on_plane = [&](int v) { return points[v][builder_.mirror_axis] == 0; };
        if (on_plane(p) && on_plane(q) && on_plane(r)) return 1e12;
        return badness(points[p], points[q], points[r]);
    }
    void fill() {
        for (int i = 0; i <= na_; ++i) {
            for (int j = std::max(0, centre(i) - half); j <= std::min(nb_, centre(i) + half); ++j) {
                const std::size_t here = index(i, j);
                if (i == 0 && j == 0) cost_[here] = 0;
                if (inside(i - 1, j)) {
                    cost_[here] = cost_[index(i - 1, j)] + step_cost(a_[i - 1], a_[i], b_[j]);
                    from_a_[here] = 1;
                }
                if (inside(i, j - 1)) {
                    const double cost = cost_[index(i, j - 1)] + step_cost(a_[i], b_[j], b_[j - 1]);
                    if (cost < cost_[here]) {
                        cost_[here] = cost;
                        from_a_[here] = 0;
                    }
                }
            }
        }
    }
    const SurfaceBuilder& builder_;
    const std::vector<int>&a_, &b_;
    int na_, nb_;
    std::vector<double> cost_;
    std::vector<char> from_a_;
};

}  // namespace

double ArcTable::parameter(double wanted) const {
    const int pieces = static_cast<int>(length.size()) - 1;
    const auto upper = std::upper_bound(length.begin(), length.end(), wanted);
    const int k = std::clamp(static_cast<int>(upper - length.begin()) - 1, 0, pieces - 1);
    const double piece = length[k + 1] - length[k];
    const double share = piece > 0 ? std::clamp((wanted - length[k]) / piece, 0.0, 1.0) : 0.0;
    return (k + share) / pieces;
}

ArcTable arc_table(const Curve& curve, int samples, const std::function<double(double)>& weight) {
    ArcTable table{std::vector<double>(samples + 1, 0.0)};
    Eigen::Vector3d last = curve(0);
    for (int k = 1; k <= samples; ++k) {
        const Eigen::Vector3d next = curve(double(k) / samples);
        const double w = weight ? weight((k - 0.5) / samples) : 1.0;
        table.length[k] = table.length[k - 1] + w * (next - last).norm();
        last = next;
    }
    return table;
}

ArcTable mean_of(const ArcTable& a, const ArcTable& b) {
    ArcTable mean = a;
    for (std::size_t k = 0; k < mean.length.size(); ++k) mean.length[k] = 0.5 * (a.length[k] + b.length[k]);
    return mean;
}

int SurfaceBuilder::add(const Eigen::Vector3d& point) {
    vertices.push_back(point);
    return static_cast<int>(vertices.size()) - 1;
}

void SurfaceBuilder::stitch(const std::vector<int>& a, const std::vector<int>& b, bool flip) {
    const StripPath path(*this, a, b);
    int i = static_cast<int>(a.size()) - 1, j = static_cast<int>(b.size()) - 1;
    std::vector<std::array<int, 3>> strip;
    while (i > 0 || j > 0) {
        std::array<int, 3> t;
        if (path.advances_a(i, j)) {
            t = {a[i - 1], a[i], b[j]};
            --i;
        } else {
            t = {a[i], b[j], b[j - 1]};
            --j;
        }
        if (t[0] == t[1] || t[1] == t[2] || t[0] == t[2]) continue;
        if (flip) std::swap(t[1], t[2]);
        strip.push_back(t);
    }
    triangles.insert(triangles.end(), strip.rbegin(), strip.rend());
}

void SurfaceBuilder::mirror() {
    const int num_vertices = static_cast<int>(vertices.size());
    const std::size_t num_triangles = triangles.size();
    std::vector<int> image(num_vertices);
    for (int v = 0; v < num_vertices; ++v) {
        image[v] = v;
        if (vertices[v][mirror_axis] == 0) continue;
        Eigen::Vector3d point = vertices[v];
        point[mirror_axis] = -point[mirror_axis];
        image[v] = add(point);
    }
    for (std::size_t t = 0; t < num_triangles; ++t) {
        const auto [p, q, r] = triangles[t];
        triangles.push_back({image[p], image[r], image[q]});
    }
}

TriMesh SurfaceBuilder::mesh() const {
    TriMesh mesh;
    mesh.vertices.resize(static_cast<int>(vertices.size()), 3);
    for (std::size_t v = 0; v < vertices.size(); ++v) mesh.vertices.row(v) = vertices[v].transpose();
    mesh.triangles.resize(static_cast<int>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t)
        mesh.triangles.row(t) << triangles[t][0], triangles[t][1], triangles[t][2];
    return mesh;
}

TriMesh with_triangle_count(int triangles, int least, double first_edge_length,
                            const std::function<TriMesh(double)>& build) {
    constexpr int most = 5'000'000;
    if (triangles < least || triangles > most)
        throw InvalidInput(text("triangles = ", triangles, " must be in [", least, ", ", most, "]"));
    double edge_length = first_edge_length;
    TriMesh best;
    double best_error = std::numeric_limits<double>::infinity();
    for (int attempt = 0; attempt < 6 && best_error > 0.02; ++attempt) {
        TriMesh mesh = build(edge_length);
        const double ratio = double(mesh.num_triangles()) / triangles;
        edge_length *= std::sqrt(ratio);
        if (std::abs(ratio - 1) < best_error) {
            best_error = std::abs(ratio - 1);
            best = std::move(mesh);
        }
    }
    return best;
}

}  // namespace strake::example
