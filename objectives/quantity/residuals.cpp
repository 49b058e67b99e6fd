#include "objectives/quantity/residuals.hpp"

#include "core/error.hpp"
#include "objectives/quantity/finite.hpp"

namespace strake {

ResidualRows::ResidualRows(int points, int width, int num_vertices) {
    rows_.width = width;
    rows_.r = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(points) * width);
    rows_.weight = Eigen::VectorXd::Constant(points, 1.0 / points);
    rows_.dr_dv.resize(rows_.r.size(), 3 * static_cast<Eigen::Index>(num_vertices));
}

void ResidualRows::add(int row, int v, const Eigen::Vector3d& dr_dv) {
    for (int c = 0; c < 3; ++c) entries_.emplace_back(row, 3 * v + c, dr_dv[c]);
}

Residuals ResidualRows::finish(const std::string& what) {
    for (Eigen::Index row = 0; row < rows_.r.size(); ++row)
        if (!std::isfinite(rows_.r[row]))
            throw InvalidInput(text(what, " ", row / rows_.width, ": the residual is not finite (", rows_.r[row], ")"));
    for (const auto& entry : entries_)
        if (!std::isfinite(entry.value()))
            throw InvalidInput(text(what, " ", entry.row() / rows_.width, ": the derivative with respect to vertex ",
                                    entry.col() / 3, " is not finite"));
    rows_.dr_dv.setFromTriplets(entries_.begin(), entries_.end());
    return std::move(rows_);
}

ResidualFunction checked(const std::string& name, int num_vertices, int num_triangles,
                         const ResidualFunction& residuals) {
    return [=](const TriMesh& surface, const TriMesh& matched) {
        for (const TriMesh* mesh : {&surface, &matched}) {
            require_same_counts(name, *mesh, num_vertices, num_triangles);
            if (const auto failure = vertices_finite(name, *mesh)) throw InvalidInput(failure->message);
        }
        return residuals(surface, matched);
    };
}

Quantity sum_of_squares(const std::string& name, int num_vertices, int num_triangles,
                        const ResidualFunction& residuals) {
    Quantity quantity;
    quantity.names = {name};
    quantity.residuals = checked(name, num_vertices, num_triangles, residuals);
    quantity.evaluate = [=](const QuantityRequest& request) {
        require_same_counts(name, request.surface, num_vertices, num_triangles);
        if (auto failure = vertices_finite(name, request.surface)) return QuantityResult{{}, {}, failure};
        Residuals at;
        try {
            at = residuals(request.surface, request.surface);
        } catch (const InvalidInput& error) {
            return QuantityResult{{}, {}, Failure{"undefined", error.what()}};
        }
        double J = 0;  // in order, whatever the vector unit
        for (Eigen::Index i = 0; i < at.r.size(); ++i) J += at.r[i] * at.r[i];
        Points dJ_dv;
        if (request.want_sensitivities) {
            const Eigen::VectorXd g = 2 * (at.dr_dv.transpose() * at.r);
            dJ_dv = Eigen::Map<const Points>(g.data(), num_vertices, 3);
        }
        return finite({name}, one_value(J, std::move(dJ_dv)));
    };
    return quantity;
}

}  // namespace strake
