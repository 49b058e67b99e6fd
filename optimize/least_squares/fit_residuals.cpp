#include "optimize/least_squares/fit_residuals.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/least_squares/robust.hpp"

namespace strake {
namespace {

bool is_called(const Quantity& quantity, const std::string& name) {
    if (quantity.names.empty()) return false;
    for (const std::string& value : quantity.names)
        if (value != name && value.compare(0, name.size() + 1, name + ".") != 0) return false;
    return true;
}

const Quantity& find(const Problem& problem, const std::string& name) {
    std::string known;
    for (const Quantity& quantity : problem.quantities) {
        if (is_called(quantity, name)) {
            if (quantity.residuals) return quantity;
            throw InvalidInput(text("quantity '", name,
                                    "' has no residuals and cannot be fitted; target_shape and measured_points have, "
                                    "thickness and section_area with a wanted value"));
        }
        if (quantity.residuals && !quantity.names.empty())
            known += (known.empty() ? "" : ", ") + quantity.names[0].substr(0, quantity.names[0].find('.'));
    }
    throw InvalidInput(
        text("no quantity is called '", name, "'; with residuals there are: ", known.empty() ? "none" : known));
}

Residuals residuals_of(const Quantity& quantity, const TriMesh& surface, const TriMesh& matched) {
    try {
        return quantity.residuals(surface, matched);
    } catch (const InvalidInput& refused) {
        if (!quantity.failing_shortens_step) throw;
        throw ResidualsUndefined(refused.what());
    }
}

}  // namespace

FitResiduals::FitResiduals(const Problem& problem)
    : loss_(problem.fitting.loss), scale_(problem.fitting.loss_scale * box_diagonal(problem.surface)) {
    if (problem.fit.empty()) throw InvalidInput("the case has nothing to fit: give fit: [quantity, ...]");
    for (const std::string& name : problem.fit) fitted_.push_back(&find(problem, name));
    if (loss_ != Loss::none && (!(scale_ > 0) || !std::isfinite(scale_)))
        throw InvalidInput(text("loss_scale = ", problem.fitting.loss_scale, " must be > 0 and finite"));
    if (problem.fitting.icp_iterations < 0)
        throw InvalidInput(text("icp_iterations = ", problem.fitting.icp_iterations, " must be >= 0"));
}

FitResiduals::Rows FitResiduals::at(const TriMesh& surface, const TriMesh& matched) const {
    Rows rows;
    for (const Quantity* quantity : fitted_) {
        const std::string& name = quantity->names[0];
        Residuals own = residuals_of(*quantity, surface, matched);
        if (own.dr_dv.rows() != own.r.size() || own.dr_dv.cols() != 3 * surface.num_vertices() || own.width < 1 ||
            own.weight.size() * own.width != own.r.size())
            throw SolverError(text(name, ": ", own.r.size(), " residuals with derivatives ", own.dr_dv.rows(), " x ",
                                   own.dr_dv.cols(), " and ", own.weight.size(), " weights do not fit together"));
        own = robust(loss_, scale_, std::move(own));
        for (Eigen::Index i = 0; i < own.r.size(); ++i)
            if (!std::isfinite(own.r[i])) throw SolverError(text(name, ": residual ", i, " is not finite"));
        for (Eigen::Index i = 0; i < own.dr_dv.outerSize(); ++i)
            for (decltype(own.dr_dv)::InnerIterator entry(own.dr_dv, i); entry; ++entry)
                if (!std::isfinite(entry.value()))
                    throw SolverError(text(name, ": the derivative of residual ", i, " is not finite"));
        const Eigen::Index before = rows.r.size();
        rows.r.conservativeResize(before + own.r.size());
        rows.r.tail(own.r.size()) = own.r;
        rows.dr_dv.push_back(std::move(own.dr_dv));
    }
    return rows;
}

void FitResiduals::set_column(const Rows& rows, int j, const Points& dv, RowMajorMatrix& dr_dx) {
    if (!dv.allFinite()) throw SolverError("the response to a variable is not finite");
    const Eigen::Map<const Eigen::VectorXd> flat(dv.data(), dv.size());
    Eigen::Index row = 0;
    for (const auto& own : rows.dr_dv) {
        dr_dx.col(j).segment(row, own.rows()) = own * flat;
        row += own.rows();
    }
}

}  // namespace strake
