#include "objectives/aero/projected_area.hpp"

#include "objectives/aero/visible_area.hpp"
#include "objectives/quantity/finite.hpp"

namespace strake {

Quantity projected_area(const std::string& name, const TriMesh& start, const Stream& stream) {
    check_stream(name, stream);
    return checked_quantity(name, {name}, start, [=](const QuantityRequest& request) {
        const TriMesh& mesh = request.surface;
        const StreamState at = stream_state(name, stream, request.parameters);
        const VisibleAreas visible(mesh, at.axes.drag, request.wants(0));
        double sum = 0;
        for (int t = 0; t < mesh.num_triangles(); ++t) sum += visible.area(t);
        QuantityResult result{{sum}, {}, {}};
        if (!request.wants(0)) return result;
        const Eigen::VectorXd ones = Eigen::VectorXd::Ones(mesh.num_triangles());
        result.dJ_dv.push_back(Points::Zero(mesh.num_vertices(), 3));
        visible.add_gradient(ones, result.dJ_dv[0]);
        result.dJ_dp.push_back(
            own_derivatives(at, request,
                            std::array<double, 2>{visible.derivative_along(ones, at.by_angle[0].drag),
                                                  visible.derivative_along(ones, at.by_angle[1].drag)}));
        return result;
    });
}

}  // namespace strake
