#include "core/primo/attachments.hpp"

#include "core/error.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/surface_map.hpp"

#include <Eigen/Dense>
#include <algorithm>

namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double on_plane_rel = 1e-6;  ///< of the diagonal, like everywhere for half models
constexpr double narrow = 1e-6;  ///< least second moment across the host's longest axis, relative to that along it
constexpr double no_fade = 1e6;  ///< reach of the map of the host's deformation

double wendland(double s) {
    if (s >= 1) return 0;
    const double rest = (1 - s) * (1 - s);
    return rest * rest * (4 * s + 1);
}

std::vector<int> vertices_of(const TriMesh& mesh, const std::vector<int>& triangles) {
    std::vector<int> found;
    for (const int t : triangles)
        for (int k = 0; k < 3; ++k) found.push_back(mesh.triangles(t, k));
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

/// The listed triangles alone, on the listed vertices (ascending).
TriMesh piece(const TriMesh& mesh, const std::vector<int>& triangles, const std::vector<int>& vertices) {
    TriMesh out;
    out.vertices = mesh.vertices(vertices, Eigen::all);
    out.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t i = 0; i < triangles.size(); ++i)
        for (int k = 0; k < 3; ++k)
            out.triangles(static_cast<Eigen::Index>(i), k) = static_cast<int>(
                std::lower_bound(vertices.begin(), vertices.end(), mesh.triangles(triangles[i], k)) - vertices.begin());
    return out;
}

}  // namespace

struct Attachments::Impl {
    struct Sample {
        int vertex;
        double weight;
        bool is_image;  ///< the vertex mirrored in the plane of symmetry
    };

    /// The rigid motion of a part, with data for its derivatives.
    struct Motion {
        Matrix3d R = Matrix3d::Identity();
        Vector3d c = Vector3d::Zero();
        Matrix3d turning;  ///< maps sum_i w_i R (X_i - C) x dx_i to the rotation due to dx
    };

    struct Part {
        std::vector<int> vertices, host;  ///< ascending
        std::vector<int> on_plane;        ///< of `vertices`; empty unless the part reaches the plane
        std::vector<Sample> samples;
        double weight = 0;
        Vector3d centre;                ///< C
        std::optional<SurfaceMap> map;  ///< of `follow`
    };
    Points rest;
    std::optional<SymmetryPlane> symmetry;
    std::vector<int> part_of;
    std::vector<Part> parts;
    std::vector<int> order;  ///< hosts first

    Vector3d mirrored(const Vector3d& x) const {
        return x - 2 * (symmetry->normal.dot(x) - symmetry->offset) * symmetry->normal;
    }
    Vector3d seen(const Points& x, const Sample& s) const {
        return s.is_image ? mirrored(x.row(s.vertex)) : Vector3d(x.row(s.vertex));
    }
    /// The same for vectors.
    Vector3d seen_vector(const Vector3d& f, const Sample& s) const {
        if (!s.is_image) return f;
        return f - 2 * symmetry->normal.dot(f) * symmetry->normal;
    }

    void make(const TriMesh& mesh, const AttachedPart& given, Part& part) const;
    void weigh(const TriMesh& own, const TriMesh& host, double reach, Part& part) const;
    bool can_turn(const Part& part) const;
    double extent(const TriMesh& own, const Part& part) const;
    void sort(const std::vector<AttachedPart>& given);

    Motion motion(const Part& part, const Points& x) const {
        Motion m;
        for (const Sample& s : part.samples) m.c += s.weight * seen(x, s);
        m.c /= part.weight;
        Matrix3d M = Matrix3d::Zero();
        bool is_at_rest = true;
        for (const Sample& s : part.samples) {
            M += s.weight * (seen(x, s) - m.c) * (seen(rest, s) - part.centre).transpose();
            is_at_rest = is_at_rest && x.row(s.vertex) == rest.row(s.vertex);
        }
        if (is_at_rest) {  // to the bit
            m.c = part.centre;
        } else {
            const Eigen::JacobiSVD<Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
            const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant();
            m.R = svd.matrixU() * Vector3d(1, 1, sign < 0 ? -1 : 1).asDiagonal() * svd.matrixV().transpose();
        }
        const Matrix3d N = m.R * M.transpose();
        m.turning = (N.trace() * Matrix3d::Identity() - 0.5 * (N + N.transpose())).inverse();
        return m;
    }

    /// The host's deformation beyond the motion, in the rest frame.
    Points beyond(const Part& part, const Motion& m, const Points& x) const {
        Points u(static_cast<Eigen::Index>(part.host.size()), 3);
        for (Eigen::Index i = 0; i < u.rows(); ++i) {
            const Vector3d arm = x.row(part.host[i]).transpose() - m.c;
            u.row(i) = (m.R.transpose() * arm - (rest.row(part.host[i]).transpose() - part.centre)).transpose();
        }
        return u;
    }

    void place(const Part& part, Points& x) const {
        const Motion m = motion(part, x);
        Points more;
        if (part.map) more = part.map->apply(beyond(part, m, x));
        const bool is_still = m.R == Matrix3d::Identity() && m.c == part.centre;
        for (std::size_t i = 0; i < part.vertices.size(); ++i) {
            Vector3d q = rest.row(part.vertices[i]);
            if (part.map) q += more.row(static_cast<Eigen::Index>(i)).transpose();
            x.row(part.vertices[i]) = is_still ? q : Vector3d(m.c + m.R * (q - part.centre));
        }
        for (const int v : part.on_plane)
            x.row(v) -= (symmetry->normal.dot(x.row(v)) - symmetry->offset) * symmetry->normal.transpose();
    }

    void place_rates(const Part& part, const Points& x, Points& dx) const {
        const Motion m = motion(part, x);
        Vector3d dc = Vector3d::Zero(), twist = Vector3d::Zero();
        for (const Sample& s : part.samples) {
            const Vector3d d = seen_vector(dx.row(s.vertex), s);
            dc += s.weight / part.weight * d;
            twist += s.weight * (m.R * (seen(rest, s) - part.centre)).cross(d);
        }
        const Vector3d omega = m.turning * twist;
        Points more;
        if (part.map) {
            Points du(static_cast<Eigen::Index>(part.host.size()), 3);
            for (Eigen::Index i = 0; i < du.rows(); ++i) {
                const int v = part.host[i];
                const Vector3d arm = x.row(v).transpose() - m.c;
                du.row(i) = (m.R.transpose() * (dx.row(v).transpose() - dc - omega.cross(arm))).transpose();
            }
            more = part.map->apply(du);
        }
        for (std::size_t i = 0; i < part.vertices.size(); ++i) {
            const int v = part.vertices[i];
            Vector3d d = dc + omega.cross(Vector3d(x.row(v).transpose() - m.c));
            if (part.map) d += m.R * more.row(static_cast<Eigen::Index>(i)).transpose();
            dx.row(v) = d;
        }
        for (const int v : part.on_plane) dx.row(v) -= dx.row(v).dot(symmetry->normal) * symmetry->normal.transpose();
    }

    /// The steps of place_rates in reverse.
    void pull_back(const Part& part, const Points& x, Points& g) const {
        const Motion m = motion(part, x);
        for (const int v : part.on_plane) g.row(v) -= g.row(v).dot(symmetry->normal) * symmetry->normal.transpose();
        Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();
        Points local(static_cast<Eigen::Index>(part.map ? part.vertices.size() : 0), 3);
        for (std::size_t i = 0; i < part.vertices.size(); ++i) {
            const int v = part.vertices[i];
            const Vector3d f = g.row(v);
            force += f;
            torque += Vector3d(x.row(v).transpose() - m.c).cross(f);
            if (part.map) local.row(static_cast<Eigen::Index>(i)) = (m.R.transpose() * f).transpose();
            g.row(v).setZero();
        }
        if (part.map) {
            const Points at_host = part.map->transpose(local);
            for (std::size_t i = 0; i < part.host.size(); ++i) {
                const Vector3d f = m.R * at_host.row(static_cast<Eigen::Index>(i)).transpose();
                const Vector3d arm = x.row(part.host[i]).transpose() - m.c;
                g.row(part.host[i]) += f.transpose();
                force -= f;
                torque -= arm.cross(f);
            }
        }
        const Vector3d spin = m.turning.transpose() * torque;
        for (const Sample& s : part.samples) {
            const Vector3d y = m.R * (seen(rest, s) - part.centre);
            const Vector3d f = s.weight / part.weight * force + s.weight * spin.cross(y);
            g.row(s.vertex) += seen_vector(f, s).transpose();
        }
    }
};

void Attachments::Impl::weigh(const TriMesh& own, const TriMesh& host, double reach, Part& part) const {
    const ClosestPointTree tree(own);
    const bool reaches_plane = !part.on_plane.empty();
    const auto distance = [&](const Vector3d& x) {
        double d = tree.find(x).distance;
        // A part on the plane is one body with its mirror image.
        if (reaches_plane) d = std::min(d, tree.find(mirrored(x)).distance);
        return d;
    };
    const Eigen::VectorXd area = vertex_areas(host);
    part.samples.clear();
    part.weight = 0;
    part.centre.setZero();
    for (const bool is_image : {false, true}) {
        if (is_image && !symmetry) break;
        for (std::size_t i = 0; i < part.host.size(); ++i) {
            Sample s{part.host[i], 0, is_image};
            s.weight = area[static_cast<Eigen::Index>(i)] * wendland(distance(seen(rest, s)) / reach);
            if (!(s.weight > 0)) continue;
            part.samples.push_back(s);
            part.weight += s.weight;
            part.centre += s.weight * seen(rest, s);
        }
    }
    if (part.weight > 0) part.centre /= part.weight;
}

/// Whether the samples define a rotation: they do not lie on one line.
bool Attachments::Impl::can_turn(const Part& part) const {
    if (part.samples.size() < 3) return false;
    Matrix3d M = Matrix3d::Zero();
    for (const Sample& s : part.samples) {
        const Vector3d arm = seen(rest, s) - part.centre;
        M += s.weight * arm * arm.transpose();
    }
    const Vector3d moments = Eigen::SelfAdjointEigenSolver<Matrix3d>(M).eigenvalues();
    return moments[1] > narrow * moments[2];
}

/// Diagonal of the part, with its mirror image where it reaches the plane.
double Attachments::Impl::extent(const TriMesh& own, const Part& part) const {
    if (part.on_plane.empty()) return box_diagonal(own);
    TriMesh both = own;
    both.vertices.conservativeResize(2 * own.vertices.rows(), 3);
    for (Eigen::Index v = 0; v < own.vertices.rows(); ++v)
        both.vertices.row(own.vertices.rows() + v) = mirrored(own.vertices.row(v)).transpose();
    both.triangles.conservativeResize(2 * own.triangles.rows(), 3);
    both.triangles.bottomRows(own.triangles.rows()) = own.triangles.array() + own.num_vertices();
    return box_diagonal(both);
}

void Attachments::Impl::make(const TriMesh& mesh, const AttachedPart& given, Part& part) const {
    part.vertices = vertices_of(mesh, given.triangles);
    part.host = vertices_of(mesh, given.host);
    const TriMesh own = piece(mesh, given.triangles, part.vertices), host = piece(mesh, given.host, part.host);
    const double diagonal = box_diagonal(mesh);
    if (symmetry)
        for (const int v : part.vertices)
            if (std::abs(symmetry->normal.dot(rest.row(v)) - symmetry->offset) <= on_plane_rel * diagonal)
                part.on_plane.push_back(v);
    const ClosestPointTree tree(own);
    double gap = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < host.vertices.rows(); ++i)
        gap = std::min(gap, tree.find(host.vertices.row(i)).distance);
    double reach = 1.5 * gap + 0.5 * extent(own, part);
    for (; reach < 100 * diagonal; reach *= 2) {  // until the host has enough vertices within reach
        weigh(own, host, reach, part);
        if (can_turn(part)) break;
    }
    if (!can_turn(part))
        throw InvalidInput(text("attach: part '", given.name, "': its host is too narrow to define a rotation (",
                                part.host.size(), " vertices on one line)"));
    if (given.how == AttachHow::rigid) return;
    SurfaceMapOptions options;
    options.reach = no_fade;
    if (!part.on_plane.empty()) options.symmetry = symmetry;
    part.map.emplace(host, own.vertices, options);
}

/// Sorts each part after the parts that it follows.
void Attachments::Impl::sort(const std::vector<AttachedPart>& given) {
    std::vector<int> state(given.size(), 0);  // 1: on the way, 2: done
    std::vector<int> way;
    const auto visit = [&](const auto& self, int k) -> void {
        if (state[k] == 2) return;
        way.push_back(k);
        if (state[k] == 1) {
            std::string circle;
            for (auto at = std::find(way.begin(), way.end(), k); at != way.end(); ++at)
                circle += (circle.empty() ? "'" : " -> '") + given[*at].name + "'";
            throw InvalidInput(text("attach: parts follow each other in a circle: ", circle));
        }
        state[k] = 1;
        for (const int t : given[k].host)
            if (part_of[t] >= 0 && state[part_of[t]] != 2) self(self, part_of[t]);
        state[k] = 2;
        way.pop_back();
        order.push_back(k);
    };
    for (int k = 0; k < static_cast<int>(given.size()); ++k) visit(visit, k);
}

namespace {

void check_triangles(const AttachedPart& part, const std::vector<int>& triangles, const char* owner, int m) {
    if (triangles.empty()) throw InvalidInput(text("attach: part '", part.name, "': ", owner, " no triangles"));
    for (const int t : triangles)
        if (t < 0 || t >= m)
            throw InvalidInput(text("attach: part '", part.name, "': triangle ", t, " must be in [0, ", m, ")"));
}

/// Fills `part_of`, the number of the part of each triangle, -1 for none.
void number_parts(const std::vector<AttachedPart>& parts, int m, std::vector<int>& part_of) {
    part_of.assign(m, -1);
    for (int k = 0; k < static_cast<int>(parts.size()); ++k) {
        const AttachedPart& part = parts[k];
        check_triangles(part, part.triangles, "has", m);
        check_triangles(part, part.host, "its host has", m);
        for (const int t : part.triangles) {
            if (part_of[t] >= 0 && part_of[t] != k)
                throw InvalidInput(text("attach: triangle ", t, " lies in parts '", parts[part_of[t]].name, "' and '",
                                        part.name, "'"));
            part_of[t] = k;
        }
    }
}

void check_hosts(const std::vector<AttachedPart>& parts, const std::vector<int>& part_of) {
    for (int k = 0; k < static_cast<int>(parts.size()); ++k) {
        const auto own =
            std::count_if(parts[k].host.begin(), parts[k].host.end(), [&](int t) { return part_of[t] == k; });
        if (own > 0)
            throw InvalidInput(text("attach: part '", parts[k].name, "' is attached to itself (its host holds ", own,
                                    " of its triangles)"));
    }
}

void check_unconnected(const TriMesh& mesh, const std::vector<AttachedPart>& parts, const std::vector<int>& part_of) {
    std::vector<int> owner(mesh.num_vertices(), -2);
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int i = 0; i < 3; ++i) {
            int& of = owner[mesh.triangles(t, i)];
            if (of == -2 || of == part_of[t]) {
                of = part_of[t];
                continue;
            }
            throw InvalidInput(text("attach: part '", parts[std::max(of, part_of[t])].name, "' shares vertex ",
                                    mesh.triangles(t, i), " with other triangles; attach whole connected parts only"));
        }
}

}  // namespace

Attachments::Attachments(const TriMesh& rest, const std::vector<AttachedPart>& parts,
                         const std::optional<SymmetryPlane>& symmetry)
    : impl_(std::make_unique<Impl>()) {
    number_parts(parts, rest.num_triangles(), impl_->part_of);
    check_hosts(parts, impl_->part_of);
    check_unconnected(rest, parts, impl_->part_of);
    impl_->rest = rest.vertices;
    impl_->symmetry = symmetry;
    impl_->sort(parts);
    impl_->parts.resize(parts.size());
    for (std::size_t k = 0; k < parts.size(); ++k) impl_->make(rest, parts[k], impl_->parts[k]);
}
Attachments::~Attachments() = default;
Attachments::Attachments(Attachments&&) noexcept = default;
Attachments& Attachments::operator=(Attachments&&) noexcept = default;

const std::vector<int>& Attachments::part_of() const { return impl_->part_of; }

void Attachments::place(Points& vertices) const {
    for (const int k : impl_->order) impl_->place(impl_->parts[k], vertices);
}

void Attachments::place_rates(const Points& vertices, Points& rates) const {
    for (const int k : impl_->order) impl_->place_rates(impl_->parts[k], vertices, rates);
}

void Attachments::pull_back(const Points& vertices, Points& dJ_dv) const {
    for (auto k = impl_->order.rbegin(); k != impl_->order.rend(); ++k)
        impl_->pull_back(impl_->parts[*k], vertices, dJ_dv);
}

std::vector<Eigen::Quaterniond> Attachments::rotations(const Points& vertices) const {
    std::vector<Eigen::Quaterniond> all;
    for (const Impl::Part& part : impl_->parts) all.emplace_back(impl_->motion(part, vertices).R);
    return all;
}

}  // namespace strake
