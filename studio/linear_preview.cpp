#include "studio/linear_preview.hpp"

#include "optimize/space/motion_limit.hpp"
#include "optimize/space/space_facts.hpp"

#include <algorithm>
#include <map>

namespace strake {
namespace {

struct Cancelled {};

Points vertex_normals(const RestFacts& rest) {
    Points normals = Points::Zero(rest.surface.num_vertices(), 3);
    for (int t = 0; t < rest.surface.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) normals.row(rest.surface.triangles(t, k)) += rest.area[t] * rest.normal.row(t);
    for (Eigen::Index v = 0; v < normals.rows(); ++v)
        if (const double length = normals.row(v).norm(); length > 0) normals.row(v) /= length;
    return normals;
}

}  // namespace

LinearPreview::LinearPreview(DesignSpace space)
    : space_(std::move(space)), modes_(static_cast<std::size_t>(space_.size())) {
    thread_ = std::thread([this] { compute(); });
}

LinearPreview::~LinearPreview() {
    ends_ = true;
    thread_.join();
}

void LinearPreview::compute() {
    try {
        normal_ = vertex_normals(*space_.rest);
        outward_ = inward_ = Eigen::VectorXd::Zero(normal_.rows());
        std::map<std::string, int> number;
        for (int j = 0; j < space_.size(); ++j) number[space_.variables[static_cast<std::size_t>(j)].name] = j;
        space_facts(space_, [&](const Variable& variable, const Points& moved) {
            if (ends_) throw Cancelled();
            keep(number.at(variable.name), moved);
        });
        finish();
    } catch (const Cancelled&) {
    } catch (const std::exception& error) {
        const std::lock_guard lock(busy_);
        trouble_ = error.what();
    }
    done_ = true;
}

void LinearPreview::keep(int j, const Points& moved) {
    for (Eigen::Index v = 0; v < moved.rows(); ++v) {
        const double along = moved.row(v).dot(normal_.row(v)), low = space_.lower[j] * along,
                     high = space_.upper[j] * along;
        outward_[v] += std::max({low, high, 0.0});
        inward_[v] += std::max({-low, -high, 0.0});
    }
    const std::size_t size = static_cast<std::size_t>(moved.size());
    if (bytes_ + size * sizeof(float) <= max_bytes) {
        auto mode = std::make_shared<std::vector<float>>();
        mode->reserve(size);
        for (Eigen::Index v = 0; v < moved.rows(); ++v)
            for (int c = 0; c < 3; ++c) mode->push_back(static_cast<float>(moved(v, c)));
        const std::lock_guard lock(busy_);
        bytes_ += size * sizeof(float);
        modes_[static_cast<std::size_t>(j)] = std::move(mode);
    }
    ready_ = j + 1;
}

/// No vertex goes beyond the motion limit, whatever the variables add up to.
void LinearPreview::finish() {
    const RestFacts& rest = *space_.rest;
    const Parameters& limits = rest.parameters;
    const auto limit = [&](const Eigen::VectorXd& by_vertex, Eigen::Index v) {
        return rest.diagonal * (by_vertex.size() > 0 ? by_vertex[v] : limits.max_displacement);
    };
    const bool is_limited = limits_motion(limits);
    auto made = std::make_shared<Envelope>();
    made->outward.resize(outward_.size());
    made->inward.resize(inward_.size());
    for (Eigen::Index v = 0; v < outward_.size(); ++v) {
        const double out = is_limited ? limit(limits.max_outward, v) : outward_[v],
                     in = is_limited ? limit(limits.max_inward, v) : inward_[v];
        made->outward[v] = static_cast<float>(std::min(outward_[v], out));
        made->inward[v] = static_cast<float>(std::min(inward_[v], in));
    }
    const std::lock_guard lock(busy_);
    envelope_ = std::move(made);
}

std::string LinearPreview::trouble() const {
    const std::lock_guard lock(busy_);
    return trouble_;
}

std::shared_ptr<const std::vector<float>> LinearPreview::mode(int j) const {
    const std::lock_guard lock(busy_);
    return j >= 0 && static_cast<std::size_t>(j) < modes_.size() ? modes_[static_cast<std::size_t>(j)] : nullptr;
}

std::shared_ptr<const LinearPreview::Envelope> LinearPreview::envelope() const {
    const std::lock_guard lock(busy_);
    return envelope_;
}

}  // namespace strake
