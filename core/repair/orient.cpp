#include "core/error.hpp"
#include "core/mesh/topology.hpp"
#include "core/repair/surface_parts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace strake::mending {
namespace {

/// A sheet and the volume that it encloses.
struct MeasuredSheet : Sheet {
    bool has_volume = false;  ///< closed by itself or by flat lids
    double volume = 0;        ///< of its triangles after those of `turned`
    Box box{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
};

std::array<int, 3> corners_of(const TriMesh& mesh, const MeasuredSheet& sheet, std::size_t i) {
    const auto c = mesh.triangles.row(sheet.triangles[i]);
    return sheet.turned[i] ? std::array{c[0], c[2], c[1]} : std::array{c[0], c[1], c[2]};
}

/// Six times the volume under the sheet, seen from `origin`.
double cone(const TriMesh& mesh, const MeasuredSheet& sheet, const Eigen::Vector3d& origin) {
    double sum = 0;
    for (std::size_t i = 0; i < sheet.triangles.size(); ++i) {
        const auto c = corners_of(mesh, sheet, i);
        const Eigen::Vector3d a = mesh.vertices.row(c[0]).transpose() - origin,
                              b = mesh.vertices.row(c[1]).transpose() - origin,
                              d = mesh.vertices.row(c[2]).transpose() - origin;
        sum += a.dot(b.cross(d));
    }
    return sum;
}

/// Sides that no other triangle of the sheet shares, as they run.
std::vector<std::array<int, 2>> rim_of(const TriMesh& mesh, const MeasuredSheet& sheet) {
    std::vector<std::array<int, 3>> sides;  // smaller, larger, sense
    for (std::size_t i = 0; i < sheet.triangles.size(); ++i) {
        const auto c = corners_of(mesh, sheet, i);
        for (int k = 0; k < 3; ++k) {
            const int a = c[k], b = c[(k + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), a < b});
        }
    }
    std::sort(sides.begin(), sides.end());
    std::vector<std::array<int, 2>> rim;
    for (std::size_t i = 0; i < sides.size();) {
        const std::size_t first = i;
        int sense = 0;
        for (; i < sides.size() && sides[i][0] == sides[first][0] && sides[i][1] == sides[first][1]; ++i)
            sense += sides[i][2] ? 1 : -1;
        for (int k = 0; k < std::abs(sense); ++k)
            rim.push_back(sense > 0 ? std::array{sides[first][0], sides[first][1]}
                                    : std::array{sides[first][1], sides[first][0]});
    }
    return rim;
}

/// Whether each connected group of rim sides is planar.
bool has_flat_lids(const TriMesh& mesh, const std::vector<std::array<int, 2>>& rim, double tolerance, double& lids) {
    std::vector<int> vertices;
    for (const auto& side : rim) vertices.insert(vertices.end(), side.begin(), side.end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    std::vector<int> up(vertices.size());
    for (std::size_t i = 0; i < up.size(); ++i) up[i] = static_cast<int>(i);
    const auto number = [&](int v) {
        return static_cast<int>(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin());
    };
    const auto root = [&](int i) {
        while (up[i] != i) i = up[i] = up[up[i]];
        return i;
    };
    for (const auto& [a, b] : rim) {
        const int one = root(number(a)), other = root(number(b));
        up[std::max(one, other)] = std::min(one, other);
    }
    std::vector<Eigen::Vector3d> vector_area(vertices.size(), Eigen::Vector3d::Zero());
    const auto at = [&](int v) -> Eigen::Vector3d { return mesh.vertices.row(v); };
    for (const auto& [a, b] : rim) {
        const int r = root(number(a));
        const Eigen::Vector3d origin = at(vertices[r]);
        vector_area[r] += 0.5 * (at(a) - origin).cross(at(b) - origin);
    }
    lids = 0;
    const Eigen::Vector3d center = at(vertices[0]);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const int r = root(static_cast<int>(i));
        const Eigen::Vector3d normal = vector_area[r].normalized();
        if (!(vector_area[r].norm() > 0) || std::abs(normal.dot(at(vertices[i]) - at(vertices[r]))) > tolerance)
            return false;
        // The lid runs against the rim; its cone as seen from `center`, which the caller uses, too.
        if (r == static_cast<int>(i)) lids -= 2 * (at(vertices[r]) - center).dot(vector_area[r]);
    }
    return true;
}

void measure(const TriMesh& mesh, MeasuredSheet& sheet, double diagonal) {
    sheet.box.min = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
    sheet.box.max = -sheet.box.min;
    for (const int t : sheet.triangles)
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector3d x = mesh.vertices.row(mesh.triangles(t, k));
            sheet.box.min = sheet.box.min.cwiseMin(x);
            sheet.box.max = sheet.box.max.cwiseMax(x);
        }
    if (!sheet.orientable) return;
    const auto rim = rim_of(mesh, sheet);
    if (rim.empty()) {
        sheet.has_volume = true;
        sheet.volume = cone(mesh, sheet, 0.5 * (sheet.box.min + sheet.box.max)) / 6;
        return;
    }
    std::vector<int> vertices;
    for (const auto& side : rim) vertices.insert(vertices.end(), side.begin(), side.end());
    const int first = *std::min_element(vertices.begin(), vertices.end());
    double lids = 0;
    if (!has_flat_lids(mesh, rim, 1e-6 * diagonal, lids)) return;
    sheet.volume = (cone(mesh, sheet, mesh.vertices.row(first)) + lids) / 6;
    const double size = (sheet.box.max - sheet.box.min).norm();
    sheet.has_volume = std::abs(sheet.volume) > 1e-6 * size * size * size;  // a flat sheet has no outside
}

/// How often the sheet winds around x: Van Oosterom & Strackee, IEEE Trans. Biomed. Eng. 30 (1983).
double winding(const TriMesh& mesh, const MeasuredSheet& sheet, const Eigen::Vector3d& x) {
    double sum = 0;
    for (std::size_t i = 0; i < sheet.triangles.size(); ++i) {
        const auto c = corners_of(mesh, sheet, i);
        const Eigen::Vector3d a = mesh.vertices.row(c[0]).transpose() - x, b = mesh.vertices.row(c[1]).transpose() - x,
                              d = mesh.vertices.row(c[2]).transpose() - x;
        const double la = a.norm(), lb = b.norm(), ld = d.norm();
        sum += std::atan2(a.dot(b.cross(d)), la * lb * ld + a.dot(b) * ld + b.dot(d) * la + d.dot(a) * lb);
    }
    return sum / (2 * std::numbers::pi);
}

/// Which sheets lie inside of others.
class Nesting {
public:
    Nesting(const TriMesh& mesh, const std::vector<MeasuredSheet>& sheets) : mesh_(mesh) {
        for (const MeasuredSheet& sheet : sheets)
            if (sheet.has_volume) closed_.push_back(&sheet);
        // Only what is larger can hold a sheet.
        std::stable_sort(closed_.begin(), closed_.end(),
                         [](const MeasuredSheet* a, const MeasuredSheet* b) { return size(*a) > size(*b); });
    }

    bool holds(const MeasuredSheet& inner) {
        for (const MeasuredSheet* outer : closed_) {
            if (!(size(*outer) > size(inner))) return false;
            if (looked_at_ > max_looked_at) return true;  // thousands of parts: keep its orientation
            ++looked_at_;
            if (is_inside(inner, *outer)) return true;
        }
        return false;
    }

private:
    static constexpr std::size_t max_looked_at = 300'000'000;  ///< triangles: seconds

    static double size(const MeasuredSheet& sheet) { return (sheet.box.max - sheet.box.min).norm(); }
    bool is_inside(const MeasuredSheet& inner, const MeasuredSheet& outer) {
        if (!((inner.box.min - outer.box.min).minCoeff() > 0 && (outer.box.max - inner.box.max).minCoeff() > 0))
            return false;
        const std::size_t step = std::max<std::size_t>(1, inner.triangles.size() / 8);
        for (std::size_t i = 0; i < inner.triangles.size(); i += step) {
            looked_at_ += outer.triangles.size();
            if (std::abs(winding(mesh_, outer, mesh_.vertices.row(mesh_.triangles(inner.triangles[i], 0)))) < 0.5)
                return false;
        }
        return true;
    }

    const TriMesh& mesh_;
    std::vector<const MeasuredSheet*> closed_;
    std::size_t looked_at_ = 0;
};

/// Area of the triangles to reverse minus that of the others.
double turned_majority(const TriMesh& mesh, const MeasuredSheet& sheet) {
    double sum = 0;
    for (std::size_t i = 0; i < sheet.triangles.size(); ++i)
        sum += (sheet.turned[i] ? 1 : -1) * area_vector(mesh, sheet.triangles[i]).norm();
    return sum;
}

/// Reverses the triangles; the first corner stays first.
void turn(Surface& surface, const MeasuredSheet& sheet, bool all_turned, const std::string& why) {
    RepairItem item{RepairKind::orient, -1, -1, Eigen::Vector3d::Zero(), 0, 0, ""};
    for (std::size_t i = 0; i < sheet.triangles.size(); ++i) {
        const int t = sheet.triangles[i];
        if (static_cast<bool>(sheet.turned[i]) == all_turned) continue;
        if (item.triangles++ == 0) {
            item.triangle = surface.source[t];
            item.at = surface.center(t);
        }
        item.size += area_vector(surface.mesh, t).norm();
        std::swap(surface.mesh.triangles(t, 1), surface.mesh.triangles(t, 2));
    }
    if (item.triangles == 0) return;
    item.words = text(item.triangles, " of ", sheet.triangles.size(), " connected triangles turned, the first is ",
                      item.triangle, ": ", why);
    surface.items.push_back(std::move(item));
}

}  // namespace

void orient(Surface& surface) {
    const TriMesh& mesh = surface.mesh;
    const Adjacency adjacent = adjacency(mesh);
    std::vector<MeasuredSheet> sheets;
    for (Sheet& found : sheets_of(mesh, adjacent)) {
        sheets.emplace_back().Sheet::operator=(std::move(found));
        measure(mesh, sheets.back(), surface.diagonal);
    }
    Nesting nesting(mesh, sheets);
    for (const MeasuredSheet& sheet : sheets) {
        if (!sheet.orientable) continue;
        const bool is_nested = sheet.has_volume && nesting.holds(sheet);
        if (sheet.has_volume && !is_nested)
            turn(surface, sheet, sheet.volume < 0, "the outside is outward");
        else
            turn(surface, sheet, turned_majority(mesh, sheet) > 0,
                 is_nested ? "inside of another part, as most of its area" : "as most of the area");
    }
}

}  // namespace strake::mending
