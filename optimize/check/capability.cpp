#include "optimize/check/capability.hpp"

#include "core/error.hpp"
#include "core/fields/typical_motions.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/space/response_metric.hpp"
#include "optimize/space/rest_shell.hpp"
#include "optimize/space/shape_map.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int more_fields_than = 60;   ///< what `fields: auto` has after the first ones
constexpr double worth_a_word = 0.02;  ///< a remedy makes this much more of a motion
constexpr int mode_iterations = 4;     ///< of the block of soft modes: each is a few percent off at most
constexpr double mode_tolerance = 1e-6;

/// Columns of weighted motions, and back: rows x, y, z of one vertex after the other.
MatrixXd flat(const std::vector<Points>& motions, const VectorXd& weight) {
    MatrixXd columns(3 * weight.size(), static_cast<Eigen::Index>(motions.size()));
    for (std::size_t k = 0; k < motions.size(); ++k)
        for (Eigen::Index v = 0; v < weight.size(); ++v)
            columns.block<3, 1>(3 * v, static_cast<Eigen::Index>(k)) = weight[v] * motions[k].row(v).transpose();
    return columns;
}

/// @param weight of the vertices; zero: no motion
std::vector<Points> motions_of(const MatrixXd& columns, const VectorXd& weight) {
    std::vector<Points> motions(static_cast<std::size_t>(columns.cols()), Points::Zero(weight.size(), 3));
    for (Eigen::Index k = 0; k < columns.cols(); ++k)
        for (Eigen::Index v = 0; v < weight.size(); ++v)
            motions[static_cast<std::size_t>(k)].row(v) = weight[v] * columns.block<3, 1>(3 * v, k).transpose();
    return motions;
}

/// Loads that differ smoothly over the body, to begin with.
std::vector<Points> smooth_loads(const RestFacts& rest, int count) {
    const Eigen::RowVector3d middle = rest.surface.vertices.colwise().mean();
    const Points x = (rest.surface.vertices.rowwise() - middle) / rest.diagonal;
    std::vector<Points> loads(static_cast<std::size_t>(count), Points(x.rows(), 3));
    for (int b = 0; b < count; ++b)
        for (int c = 0; c < 3; ++c) {
            const VectorXd slope =
                b % 3 == c ? VectorXd(x.col((b + b / 3) % 3) * (1 + b)) : VectorXd(x.col((b + c) % 3));
            loads[static_cast<std::size_t>(b)].col(c) = b % 3 == c ? VectorXd(slope.array() + 1) : slope;
        }
    return loads;
}

/// The softest motions of the shell at rest: by powers of its compliance on a block of smooth loads, orthogonal by
/// area.
std::vector<TypicalMotion> soft_modes(const DesignSpace& space, int count) {
    const RestFacts& rest = *space.rest;
    const std::unique_ptr<PrimoShell> shell = shell_at_rest(space);
    if (!shell) return {};
    const int block = count + 3;
    const VectorXd weight = rest.vertex_area.cwiseSqrt();
    VectorXd inverse = VectorXd::Zero(weight.size());
    for (Eigen::Index v = 0; v < weight.size(); ++v)
        if (weight[v] > 0) inverse[v] = 1 / weight[v];
    MatrixXd modes = flat(smooth_loads(rest, block), weight), ritz;
    for (int i = 0; i < mode_iterations; ++i) {
        const Eigen::HouseholderQR<MatrixXd> qr(modes);
        const MatrixXd basis = qr.householderQ() * MatrixXd::Identity(modes.rows(), block);
        std::vector<Points> forces = motions_of(basis, weight);
        for (Points& force : forces) force = pulled_to_shell(rest, kept_forces(rest, force));
        modes = flat(surface_response(rest, shell.get(), forces, mode_tolerance, nullptr), weight);
        ritz = basis.transpose() * modes;
    }
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(0.5 * (ritz + ritz.transpose()));
    const std::vector<Points> soft = motions_of(modes * eigen.eigenvectors().rowwise().reverse(), inverse);
    std::vector<TypicalMotion> all;
    for (int k = 0; k < count; ++k) {
        const Points& u = soft[static_cast<std::size_t>(k)];
        if (const double size = u.rowwise().norm().maxCoeff(); size > 0)
            all.push_back({text("soft mode ", k + 1), u / size});
    }
    return all;
}

/// A line of the case, and what it adds.
struct Remedy {
    std::string line;
    MatrixXd columns;
};

MatrixXd field_columns(const RestFacts& rest, const FieldConditions& conditions, const CapabilityOptions& options,
                       int number) {
    const DisplacementFields fields(rest.surface, conditions, {number, options.axis});
    MatrixXd columns;
    for (int b = 0; b < fields.size(); ++b) {
        const VectorXd one = sampled_motion(rest, kept_rates(rest, fields.field(b), nullptr));
        if (b == 0) columns.resize(one.size(), fields.size());
        columns.col(b) = one;
    }
    return columns;
}

MatrixXd joined(const MatrixXd& a, const MatrixXd& b) {
    MatrixXd both(std::max(a.rows(), b.rows()), a.cols() + b.cols());
    if (a.cols() > 0) both.leftCols(a.cols()) = a;
    if (b.cols() > 0) both.rightCols(b.cols()) = b;
    return both;
}

/// Where nothing is held, motions of the body as a whole say nothing of its shape.
MatrixXd rigid_columns(const RestFacts& rest, const FieldConditions& conditions) {
    MatrixXd columns;
    for (const Points& motion : rigid_motions(rest.surface, conditions.cut ? conditions.cut : conditions.mirror))
        columns = joined(columns, sampled_motion(rest, motion));
    return columns;
}

std::vector<Remedy> remedies(const std::shared_ptr<const RestFacts>& rest, const FieldConditions& conditions,
                             const CapabilityOptions& options, int finest) {
    const Parameters& p = rest->parameters;
    std::vector<Remedy> all;
    const int present = p.fields ? p.fields->size() : 0;
    for (const int number : {27, more_fields_than}) {
        if (present >= number) continue;
        try {
            all.push_back({text("parameters.fields: ", number == 27 && !p.fields ? "auto" : std::to_string(number)),
                           field_columns(*rest, conditions, options, number)});
        } catch (const InvalidInput&) {  // nothing is left that could move
        }
    }
    const bool has_loads = std::ranges::any_of(p.kinds, [](VariableKind kind) { return is_load(kind); });
    if (has_loads || finest < 1) return all;
    auto other = std::make_shared<RestFacts>(*rest);
    other->parameters.kinds = {VariableKind::normal_load};
    const DesignSpace space = design_space(other, finest);
    if (space.size() <= options.max_variables)
        all.push_back({"parameters.variables: [normal]", responses_at_rest(space).samples});
    return all;
}

/// What the variables of a level can make.
struct Columns {
    MatrixXd all;
    MatrixXd of_planform;  ///< those of `all` that change wings
};

/// Stiffness moves nothing at rest, and parameters nothing at all.
Columns columns_of(const DesignSpace& space) {
    const MatrixXd all = responses_at_rest(space).samples.leftCols(space.num_shape());
    std::vector<int> of_planform;
    for (int j = 0; j < space.num_shape(); ++j)
        if (space.variables[static_cast<std::size_t>(j)].kind == VariableKind::planform) of_planform.push_back(j);
    return {all, all(Eigen::all, of_planform)};
}

/// A motion as it is asked for, and what of it edges of wings allow that stay. All else that loads and fields do along
/// it, between the edges, is no part of it: sections that bulge are no sweep.
struct WantedMotion {
    VectorXd whole, allowed;

    WantedMotion(const RestFacts& rest, const Points& motion)
        : whole(sampled_motion(rest, motion)),
          allowed(rest.parameters.kept_sections ? sampled_motion(rest, kept_rates(rest, motion, nullptr)) : whole) {}

    double made_by(const Columns& columns) const {
        const double size = whole.squaredNorm();
        if (!(size > 0)) return 0;
        const double part = std::min(1.0, allowed.squaredNorm() / size);
        return std::max(part * share_made(columns.all, allowed), share_made(columns.of_planform, whole));
    }
};

std::vector<Columns> columns_by_level(const std::shared_ptr<const RestFacts>& rest, const FieldConditions& conditions,
                                      const CapabilityOptions& options, Capability& found,
                                      std::optional<DesignSpace>& first) {
    const MatrixXd rigid = conditions.held.empty() ? rigid_columns(*rest, conditions) : MatrixXd();
    const int finest = static_cast<int>(rest->tree->levels.size()) - 1;
    std::vector<Columns> columns;
    for (int level = rest->parameters.fields ? 0 : std::min(1, finest); level <= finest; ++level) {
        const DesignSpace space = design_space(rest, level);
        if (space.num_shape() > options.max_variables) {
            found.levels_not_asked = finest - level + 1;
            break;
        }
        if (!first) first = space;
        found.levels.push_back(level);
        found.variables.push_back(space.num_shape());
        columns.push_back(columns_of(space));
        columns.back().all = joined(columns.back().all, rigid);
    }
    return columns;
}

/// The first line of the case with which nothing is missing, else the one that adds most.
void add_remedy(const std::vector<Remedy>& possible, const Columns& present, const WantedMotion& wanted, double enough,
                MotionShare& share) {
    for (const Remedy& remedy : possible) {
        const double with = wanted.made_by({joined(present.all, remedy.columns), present.of_planform});
        if (with < std::max(share.by_level.back(), share.with_remedy) + worth_a_word) continue;
        share.remedy = remedy.line;
        share.with_remedy = with;
        if (with >= enough) return;
    }
}

}  // namespace

double share_made(const MatrixXd& columns, const VectorXd& motion) {
    const double whole = motion.squaredNorm();
    if (columns.cols() == 0 || !(whole > 0)) return 0;
    MatrixXd scaled = columns;
    for (Eigen::Index j = 0; j < scaled.cols(); ++j)
        if (const double size = scaled.col(j).norm(); size > 0) scaled.col(j) /= size;
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(scaled);
    const VectorXd share = qr.householderQ().transpose() * motion;
    return std::clamp(share.head(qr.rank()).squaredNorm() / whole, 0.0, 1.0);
}

Capability capability(const std::shared_ptr<const RestFacts>& rest, const FieldConditions& conditions,
                      const CapabilityOptions& options) {
    Capability found;
    CapabilityOptions asked = options;
    if (!asked.axis && rest->parameters.fields)
        asked.axis = Eigen::Vector3d(rest->parameters.fields->frame().axes.col(0));
    const int finest = static_cast<int>(rest->tree->levels.size()) - 1;
    std::optional<DesignSpace> first;
    const std::vector<Columns> columns = columns_by_level(rest, conditions, asked, found, first);
    std::vector<TypicalMotion> motions = typical_motions(rest->surface, conditions, asked.axis);
    if (first && asked.soft_modes > 0)
        for (TypicalMotion& mode : soft_modes(*first, asked.soft_modes)) motions.push_back(std::move(mode));
    std::optional<std::vector<Remedy>> possible;
    for (const TypicalMotion& motion : motions) {
        const WantedMotion wanted(*rest, motion.displacement);
        MotionShare share{motion.name, {}, "", 0};
        for (const Columns& level : columns) share.by_level.push_back(wanted.made_by(level));
        if (!share.by_level.empty() && share.by_level.back() < asked.enough) {
            if (!possible) possible = remedies(rest, conditions, asked, finest);
            add_remedy(*possible, columns.back(), wanted, asked.enough, share);
        }
        found.motions.push_back(std::move(share));
    }
    return found;
}

}  // namespace strake
