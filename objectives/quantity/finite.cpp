#include "objectives/quantity/finite.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <cmath>

namespace strake {
namespace {

int first_non_finite_row(const Points& rows) {
    // x - x is 0, or NaN where x is not finite; a sum is vectorised, allFinite() is not.
    const Eigen::Map<const Eigen::ArrayXd> all(rows.data(), rows.size());
    if ((all - all).sum() == 0) return -1;
    for (int k = 0; k < static_cast<int>(rows.rows()); ++k)
        if (!rows.row(k).allFinite()) return k;
    return -1;
}

}  // namespace

std::optional<Failure> vertices_finite(const std::string& quantity, const TriMesh& surface) {
    const int k = first_non_finite_row(surface.vertices);
    if (k < 0) return {};
    return Failure{"undefined",
                   text(quantity, ": vertex ", k, " of the surface is not finite: (", surface.vertices(k, 0), ", ",
                        surface.vertices(k, 1), ", ", surface.vertices(k, 2), ")")};
}

QuantityResult one_value(double value, Points dJ_dv) {
    QuantityResult result;
    result.values = {value};
    if (dJ_dv.rows() > 0) result.dJ_dv.push_back(std::move(dJ_dv));
    return result;
}

QuantityResult finite(const std::vector<std::string>& names, QuantityResult result) {
    const auto undefined = [](const std::string& why) { return QuantityResult{{}, {}, Failure{"undefined", why}}; };
    for (std::size_t i = 0; i < result.values.size(); ++i)
        if (!std::isfinite(result.values[i]))
            return undefined(text(names[i], " = ", result.values[i], ": the surface is too large or too small for it"));
    for (std::size_t i = 0; i < result.dJ_dv.size(); ++i)
        if (const int k = first_non_finite_row(result.dJ_dv[i]); k >= 0)
            return undefined(text(names[i], ": the sensitivity to vertex ", k, " is not finite"));
    for (std::size_t i = 0; i < result.dJ_dp.size(); ++i)
        if (!result.dJ_dp[i].allFinite())
            return undefined(text(names[i], ": a derivative by the case's variables is not finite"));
    return result;
}

Quantity checked_quantity(const std::string& name, std::vector<std::string> names, const TriMesh& start,
                          std::function<QuantityResult(const QuantityRequest&)> measure) {
    if (const auto failure = vertices_finite(name, start)) throw InvalidInput(failure->message);
    // Fifth powers of lengths must fit into a double: no false zeros.
    const double diagonal = box_diagonal(start);
    if (!(diagonal >= 1e-50 && diagonal <= 1e50))
        throw InvalidInput(text(name, ": the surface's diagonal ", diagonal, " must be in [1e-50, 1e50]"));
    Quantity quantity;
    quantity.names = std::move(names);
    quantity.evaluate = [name, names = quantity.names, nv = start.num_vertices(), nt = start.num_triangles(),
                         measure = std::move(measure)](const QuantityRequest& request) {
        require_same_counts(name, request.surface, nv, nt);
        if (auto failure = vertices_finite(name, request.surface)) return QuantityResult{{}, {}, failure};
        try {
            return finite(names, measure(request));
        } catch (const InvalidInput& error) {
            return QuantityResult{{}, {}, Failure{"undefined", error.what()}};
        }
    };
    return quantity;
}

void require_same_counts(const std::string& quantity, const TriMesh& surface, int num_vertices, int num_triangles) {
    if (surface.num_vertices() == num_vertices && surface.num_triangles() == num_triangles) return;
    throw InvalidInput(text(quantity, ": made for a surface of ", num_vertices, " vertices and ", num_triangles,
                            " triangles, evaluated on one of ", surface.num_vertices(), " and ",
                            surface.num_triangles()));
}

}  // namespace strake
