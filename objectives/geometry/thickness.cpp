#include "objectives/geometry/thickness.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/text/number_table.hpp"
#include "objectives/quantity/finite.hpp"
#include "objectives/quantity/residuals.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace strake {
namespace {

using Eigen::Vector3d;

constexpr double same_place_rel = 1e-9;  // of the diagonal: crossings of neighbours at their common edge

struct Crossing {
    double s = 0;
    int triangle = 0;
    std::array<Vector3d, 3> ds_dv;
};

/// Where `line` crosses triangle t, borders included; a triangle seen edge-on is not crossed.
std::optional<Crossing> crossing(const TriMesh& mesh, int t, const Vector3d& o, const Vector3d& d) {
    const auto corner = [&](int k) { return Vector3d(Vector3d(mesh.vertices.row(mesh.triangles(t, k))) - o); };
    const std::array<Vector3d, 3> p{corner(0), corner(1), corner(2)};
    std::array<double, 3> b;
    for (int k = 0; k < 3; ++k) {
        // From the smaller to the larger vertex: neighbours must get the same bits, or a line passes between them.
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const bool turn = mesh.triangles(t, i) > mesh.triangles(t, j);
        b[k] = d.dot(p[turn ? j : i].cross(p[turn ? i : j])) * (turn ? -1 : 1);
    }
    const bool inside = (b[0] >= 0 && b[1] >= 0 && b[2] >= 0) || (b[0] <= 0 && b[1] <= 0 && b[2] <= 0);
    const double sum = b[0] + b[1] + b[2];
    if (!inside || sum == 0) return {};
    const Vector3d n = (p[1] - p[0]).cross(p[2] - p[0]);
    const double along = n.dot(d);
    if (along == 0) return {};
    Crossing at;
    at.triangle = t;
    at.s = n.dot(p[0]) / along;
    for (int k = 0; k < 3; ++k) at.ds_dv[k] = b[k] / sum / along * n;
    return at;
}

bool touch(const TriMesh& mesh, int t, int u) {
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l)
            if (mesh.triangles(t, k) == mesh.triangles(u, l)) return true;
    return false;
}

/// All crossings in the order of s, each place once.
std::vector<Crossing> crossings(const TriMesh& mesh, const Vector3d& o, const Vector3d& d, double same_place) {
    std::vector<Crossing> all;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (auto at = crossing(mesh, t, o, d)) all.push_back(*at);
    std::stable_sort(all.begin(), all.end(), [](const Crossing& a, const Crossing& b) { return a.s < b.s; });
    std::vector<Crossing> distinct;
    for (const Crossing& at : all)
        if (distinct.empty() || at.s - distinct.back().s > same_place ||
            !touch(mesh, at.triangle, distinct.back().triangle))
            distinct.push_back(at);
    return distinct;
}

struct Measured {
    double thickness = 0;
    Crossing from, to;
};

std::string place(const std::string& name, const ThicknessLine& line, int number) {
    return line.line > 0 ? text(name, ": line ", number, " (row ", line.line, " of the file)")
                         : text(name, ": line ", number);
}

/// @throws InvalidInput for fewer than two crossings.
Measured measure(const std::string& name, const ThicknessLine& line, int number, const TriMesh& mesh,
                 double same_place) {
    const Vector3d d = line.direction.stableNormalized();
    const std::vector<Crossing> all = crossings(mesh, line.at, d, same_place);
    if (all.size() < 2)
        throw InvalidInput(text(place(name, line, number), " through (", line.at.transpose(), ") along (",
                                line.direction.transpose(), ") crosses the surface ",
                                all.empty() ? "nowhere" : "only once", "; two crossings are needed"));
    const auto ahead = std::find_if(all.begin(), all.end(), [](const Crossing& at) { return at.s > 0; });
    const std::size_t i = static_cast<std::size_t>(ahead - all.begin());
    // Neighbours on either side of the point, else the two nearest.
    const std::size_t to = std::clamp<std::size_t>(i, 1, all.size() - 1);
    return {all[to].s - all[to - 1].s, all[to - 1], all[to]};
}

void check(const std::string& name, const std::vector<ThicknessLine>& lines) {
    if (lines.empty()) throw InvalidInput(text(name, ": no lines"));
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const ThicknessLine& line = lines[i];
        const std::string where = place(name, line, static_cast<int>(i) + 1);
        if (!line.at.allFinite() || !line.direction.allFinite()) throw InvalidInput(text(where, " is not finite"));
        if (line.direction.isZero(0)) throw InvalidInput(text(where, " has a direction of length zero"));
        if (line.target.has_value() != lines[0].target.has_value())
            throw InvalidInput(text(where, line.target ? " has a target thickness, line 1 has none"
                                                       : " has no target thickness, line 1 has one"));
        if (line.target && (!(*line.target > 0) || !std::isfinite(*line.target)))
            throw InvalidInput(text(where, ": the target thickness ", *line.target, " must be > 0 and finite"));
    }
}

class Lines {
public:
    Lines(std::string name, const TriMesh& start, std::vector<ThicknessLine> lines)
        : name_(std::move(name)), lines_(std::move(lines)), same_place_(same_place_rel * box_diagonal(start)) {}

    int size() const { return static_cast<int>(lines_.size()); }
    const ThicknessLine& operator[](int i) const { return lines_[static_cast<std::size_t>(i)]; }
    Measured measured(int i, const TriMesh& mesh) const { return measure(name_, (*this)[i], i + 1, mesh, same_place_); }

    Residuals residuals(const TriMesh& mesh) const {
        ResidualRows rows(size(), 1, mesh.num_vertices());
        const double root = std::sqrt(1.0 / size());
        for (int i = 0; i < size(); ++i) {
            const Measured at = measured(i, mesh);
            rows.set(i, root * (at.thickness - *(*this)[i].target));
            for (int k = 0; k < 3; ++k) {
                rows.add(i, mesh.triangles(at.to.triangle, k), root * at.to.ds_dv[k]);
                rows.add(i, mesh.triangles(at.from.triangle, k), -root * at.from.ds_dv[k]);
            }
        }
        return rows.finish(name_ + ": line");
    }

    QuantityResult values(const QuantityRequest& request, ThicknessValues which) const {
        std::vector<Measured> all;
        try {
            for (int i = 0; i < size(); ++i) all.push_back(measured(i, request.surface));
        } catch (const InvalidInput& error) {
            return {{}, {}, Failure{"undefined", error.what()}};
        }
        if (which == ThicknessValues::smallest)
            all = {*std::min_element(all.begin(), all.end(),
                                     [](const Measured& a, const Measured& b) { return a.thickness < b.thickness; })};
        QuantityResult result;
        for (const Measured& at : all) {
            Points dt_dv;
            if (request.want_sensitivities) {
                dt_dv = Points::Zero(request.surface.num_vertices(), 3);
                for (int k = 0; k < 3; ++k) {
                    dt_dv.row(request.surface.triangles(at.to.triangle, k)) += at.to.ds_dv[k];
                    dt_dv.row(request.surface.triangles(at.from.triangle, k)) -= at.from.ds_dv[k];
                }
            }
            QuantityResult one = finite({name_}, one_value(at.thickness, std::move(dt_dv)));
            if (one.failure) return one;
            result.values.push_back(one.values[0]);
            if (request.want_sensitivities) result.dJ_dv.push_back(std::move(one.dJ_dv[0]));
        }
        return result;
    }

private:
    std::string name_;
    std::vector<ThicknessLine> lines_;
    double same_place_;
};

}  // namespace

Quantity thickness(const std::string& name, const TriMesh& start, const std::vector<ThicknessLine>& lines,
                   ThicknessValues values) {
    check(name, lines);
    if (const auto failure = vertices_finite(name, start)) throw InvalidInput(failure->message);
    const Lines all(name, start, lines);
    for (int i = 0; i < all.size(); ++i) all.measured(i, start);
    Quantity quantity;
    if (values == ThicknessValues::smallest)
        quantity.names = {name};
    else
        for (int i = 1; i <= all.size(); ++i) quantity.names.push_back(text(name, ".", i));
    const int nv = start.num_vertices(), nt = start.num_triangles();
    quantity.evaluate = [=](const QuantityRequest& request) {
        require_same_counts(name, request.surface, nv, nt);
        if (auto failure = vertices_finite(name, request.surface)) return QuantityResult{{}, {}, failure};
        return all.values(request, values);
    };
    if (lines[0].target)
        quantity.residuals =
            checked(name, nv, nt, [all](const TriMesh& surface, const TriMesh&) { return all.residuals(surface); });
    return quantity;
}

std::vector<ThicknessLine> read_thickness_lines(const std::filesystem::path& file) {
    std::vector<ThicknessLine> lines;
    for (const TableRow& row : read_table(file, {"x", "y", "z", "dx", "dy", "dz", "target"}, 6)) {
        const std::vector<double>& v = row.values;
        ThicknessLine line{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {}, row.line};
        if (v.size() > 6) line.target = v[6];
        if (line.direction.isZero(0))
            throw InputError(text(file.string(), ":", row.line, ": the direction has length zero"));
        if (line.target && !(*line.target > 0))
            throw InputError(text(file.string(), ":", row.line, ": target = ", *line.target, " must be > 0"));
        lines.push_back(line);
    }
    return lines;
}

}  // namespace strake
