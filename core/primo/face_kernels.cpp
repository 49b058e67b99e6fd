#include "core/primo/face_kernels.hpp"

#include <algorithm>

#include "core/parallel.hpp"
#include "core/primo/linear/lanes.hpp"

namespace strake {
namespace {

/// A vector at each of four points.
struct FourVectors {
    Four x, y, z;
};

STRAKE_INLINE FourVectors load(const Quad& q) { return {four(q.x).lanes, four(q.y).lanes, four(q.z).lanes}; }

/// T a
STRAKE_INLINE FourVectors turned_only(const double* T, const FourVectors& a) {
    return {(T[0] * a.x + T[3] * a.y) + T[6] * a.z, (T[1] * a.x + T[4] * a.y) + T[7] * a.z,
            (T[2] * a.x + T[5] * a.y) + T[8] * a.z};
}
/// a + T a
STRAKE_INLINE FourVectors arms(const double* T, const Quad& rest) {
    const FourVectors a = load(rest), t = turned_only(T, a);
    return {a.x + t.x, a.y + t.y, a.z + t.z};
}
/// Velocities of the points at arms a: w x a + v.
STRAKE_INLINE FourVectors velocities(const double* twist, const FourVectors& a) {
    return {(twist[1] * a.z - twist[2] * a.y) + twist[3], (twist[2] * a.x - twist[0] * a.z) + twist[4],
            (twist[0] * a.y - twist[1] * a.x) + twist[5]};
}
STRAKE_INLINE void store_difference(const FourVectors& a, const FourVectors& b, Quad& to) {
    four(to.x).lanes = a.x - b.x;
    four(to.y).lanes = a.y - b.y;
    four(to.z).lanes = a.z - b.z;
}
/// Adds sign times the forces at the arms.
STRAKE_INLINE void add_wrench(const FourVectors& a, const FourVectors& f, double sign, double* to) {
    to[0] += sign * sum(a.y * f.z - a.z * f.y);
    to[1] += sign * sum(a.z * f.x - a.x * f.z);
    to[2] += sign * sum(a.x * f.y - a.y * f.x);
    to[3] += sign * sum(f.x);
    to[4] += sign * sum(f.y);
    to[5] += sign * sum(f.z);
}
STRAKE_INLINE void add_own(const FourVectors& a, const FourVectors& f, double w, double sign, OwnBlock& to) {
    const Four products[6] = {a.x * a.x, a.y * a.y, a.z * a.z, a.x * a.y, a.y * a.z, a.z * a.x};
    for (int q = 0; q < 6; ++q) to.square[q] += w * sum(products[q]);
    to.arm[0] += w * sum(a.x);
    to.arm[1] += w * sum(a.y);
    to.arm[2] += w * sum(a.z);
    to.weight += w;
    const Four moments[6] = {
        f.x * a.x, f.y * a.y, f.z * a.z, f.x * a.y + f.y * a.x, f.y * a.z + f.z * a.y, f.z * a.x + f.x * a.z};
    for (int q = 0; q < 6; ++q) to.moment[q] += (q < 3 ? sign : 0.5 * sign) * sum(moments[q]);
}
/// -w sum_g J(p)^T J(q), column by column: p at the arms of the block's row, q at those of its column.
STRAKE_INLINE void coupling(const FourVectors& p, const FourVectors& q, double w, double* to) {
    const double xx = w * sum(q.x * p.x), xy = w * sum(q.x * p.y), xz = w * sum(q.x * p.z);
    const double yx = w * sum(q.y * p.x), yy = w * sum(q.y * p.y), yz = w * sum(q.y * p.z);
    const double zx = w * sum(q.z * p.x), zy = w * sum(q.z * p.y), zz = w * sum(q.z * p.z);
    const double px = w * sum(p.x), py = w * sum(p.y), pz = w * sum(p.z);
    const double qx = w * sum(q.x), qy = w * sum(q.y), qz = w * sum(q.z), all = -4 * w;
    const double block[36] = {-(yy + zz), yx, zx,         0,  qz,  -qy, xy,  -(xx + zz), zy, -qz, 0, qx,
                              xz,         yz, -(xx + yy), qy, -qx, 0,   0,   -pz,        py, all, 0, 0,
                              pz,         0,  -px,        0,  all, 0,   -py, px,         0,  0,   0, all};
    for (int k = 0; k < 36; ++k) to[k] = block[k];
}

constexpr int faces_at_once = 512;  // faces, prisms or vertices of one thread

template <class Work>
void for_lanes(int n, const Work& work) {
    for_blocks(n, faces_at_once,
               [&](int begin, int end) { run_lanes([&]() __attribute__((always_inline)) { work(begin, end); }); });
}

}  // namespace

OwnBlock& OwnBlock::operator+=(const OwnBlock& other) {
    for (int q = 0; q < 6; ++q) square[q] += other.square[q], moment[q] += other.moment[q];
    for (int q = 0; q < 3; ++q) arm[q] += other.arm[q];
    weight += other.weight;
    return *this;
}

void OwnBlock::add_moment(const Eigen::Vector3d& f, const Eigen::Vector3d& a) {
    for (int q = 0; q < 3; ++q) {
        const int next = (q + 1) % 3;
        moment[q] += f[q] * a[q];
        moment[3 + q] += 0.5 * (f[q] * a[next] + f[next] * a[q]);
    }
}

void face_jumps(const RestState& rest, const Poses& poses, const std::vector<Eigen::Matrix3d>& turn,
                std::vector<Quad>& jump) {
    jump.resize(rest.faces.size());
    for_lanes(
        static_cast<int>(rest.faces.size()), [&](int begin, int end) __attribute__((always_inline)) {
            for (int f = begin; f < end; ++f) {
                const SharedFace& face = rest.faces[f];
                FourVectors a = turned_only(turn[face.i].data(), load(face.arm_i));
                const FourVectors b = turned_only(turn[face.j].data(), load(face.arm_j));
                const auto apart = [&](int c) __attribute__((always_inline)) {
                    return poses.displacement(face.i, c) - poses.displacement(face.j, c);
                };
                store_difference(a, b, jump[f]);
                four(jump[f].x).lanes += apart(0);
                four(jump[f].y).lanes += apart(1);
                four(jump[f].z).lanes += apart(2);
            }
        });
}

void face_jump_rates(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const Eigen::VectorXd& twist,
                     std::vector<Quad>& rate) {
    rate.resize(rest.faces.size());
    static constexpr double still[6] = {};
    const auto of = [&](int i) __attribute__((always_inline)) {
        return rest.free_index[i] < 0 ? still : twist.data() + 6L * rest.free_index[i];
    };
    for_lanes(
        static_cast<int>(rest.faces.size()), [&](int begin, int end) __attribute__((always_inline)) {
            for (int f = begin; f < end; ++f) {
                const SharedFace& face = rest.faces[f];
                store_difference(velocities(of(face.i), arms(turn[face.i].data(), face.arm_i)),
                                 velocities(of(face.j), arms(turn[face.j].data(), face.arm_j)), rate[f]);
            }
        });
}

namespace {

struct Wrench {
    double entry[6] = {};
    Wrench& operator+=(const Wrench& other) {
        for (int q = 0; q < 6; ++q) entry[q] += other.entry[q];
        return *this;
    }
};

/// Sums over all faces: work(face, for_i, for_j) adds to two Sums, entries of `sums` for prisms that have one, else
/// nullptr. @param sum_of prism -> position in `sums`, or -1
template <class Sum, class SumOf, class Work>
void add_up(const RestState& rest, Sum* sums, const SumOf& sum_of, int threads, const Work& work) {
    const FaceGroups& groups = rest.face_groups;
    std::vector<Sum> apart(groups.prism.size());
    const auto place = [&](int prism, int place_apart) {
        const int at = sum_of(prism);
        return at < 0 ? nullptr : place_apart < 0 ? sums + at : apart.data() + place_apart;
    };
    const auto do_faces = [&](int begin, int end) {
        run_lanes([&]() __attribute__((always_inline)) {
            for (int f = begin; f < end; ++f)
                work(f, place(rest.faces[f].i, groups.apart[f][0]), place(rest.faces[f].j, groups.apart[f][1]));
        });
    };
    for_blocks(static_cast<int>(rest.faces.size()), FaceGroups::faces, do_faces, threads);
    for_blocks(rest.num_prisms(), FaceGroups::prisms, [&](int begin, int) {
        const int group = begin / FaceGroups::prisms;
        for (int k = groups.begin[group]; k < groups.begin[group + 1]; ++k)
            if (const int at = sum_of(groups.prism[k]); at >= 0) sums[at] += apart[k];
    });
}

}  // namespace

void face_wrenches(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const std::vector<Quad>& jump,
                   Wrenches& wrench) {
    wrench.resize(rest.num_prisms(), 6);
    auto* sums = reinterpret_cast<Wrench*>(wrench.data());  // its rows
    for_blocks(rest.num_prisms(), FaceGroups::prisms,
               [&](int begin, int end) { std::fill(sums + begin, sums + end, Wrench()); });
    add_up(
        rest, sums, [](int i) { return i; }, 0,
        [&](int f, Wrench* of_i, Wrench* of_j) __attribute__((always_inline)) {
            const SharedFace& face = rest.faces[f];
            const double w = face.weight / 2;
            const FourVectors r = load(jump[f]), force = {w * r.x, w * r.y, w * r.z};
            add_wrench(arms(turn[face.i].data(), face.arm_i), force, 1, of_i->entry);
            add_wrench(arms(turn[face.j].data(), face.arm_j), force, -1, of_j->entry);
        });
}

void add_face_blocks(const RestState& rest, const std::vector<Eigen::Matrix3d>& turn, const std::vector<Quad>& stress,
                     bool is_sum, std::vector<OwnBlock>& own, std::vector<Matrix6>& below, const BlockMatrix& pattern) {
    const int threads = is_sum ? 1 : 0;  // faces of several groups may have a block in common
    add_up(
        rest, own.data(), [&](int i) { return rest.free_index[i]; }, threads,
        [&](int f, OwnBlock* of_i, OwnBlock* of_j) __attribute__((always_inline)) {
            if (!of_i && !of_j) return;
            const SharedFace& face = rest.faces[f];
            const FourVectors a = arms(turn[face.i].data(), face.arm_i), b = arms(turn[face.j].data(), face.arm_j);
            const double w = face.weight / 2;
            const FourVectors r = load(stress[f]), force = {w * r.x, w * r.y, w * r.z};
            if (of_i) add_own(a, force, w, 1, *of_i);
            if (of_j) add_own(b, force, w, -1, *of_j);
            if (!of_i || !of_j) return;
            const int i = rest.free_index[face.i], j = rest.free_index[face.j];
            Matrix6& to = below[pattern.find(i, j)];
            Matrix6 block;
            double* written = is_sum ? block.data() : to.data();
            if (i > j)
                coupling(a, b, w, written);
            else
                coupling(b, a, w, written);
            if (is_sum) to += block;
        });
}

void vertex_sums(const RestState& rest, const Poses& poses, const std::vector<Eigen::Matrix3d>& turn, Points& total) {
    for_lanes(
        rest.mesh.num_vertices(), [&](int begin, int end) __attribute__((always_inline)) {
            for (int k = begin; k < end; ++k) {
                Four sum = {};
                for (const int i : rest.vertex_prisms[k]) {
                    const double* T = turn[i].data();
                    double arm[3];
                    for (int c = 0; c < 3; ++c) arm[c] = rest.mesh.vertices(k, c) - rest.centroid(i, c);
                    const Four last = four(T + 5).lanes;  // its own first lane is of the column before
                    const Four third = {last[1], last[2], last[3], 0};
                    sum += ((four(T).lanes * arm[0] + four(T + 3).lanes * arm[1]) + third * arm[2]) +
                           Four{poses.displacement(i, 0), poses.displacement(i, 1), poses.displacement(i, 2), 0};
                }
                for (int c = 0; c < 3; ++c) total(k, c) = sum[c];
            }
        });
}

}  // namespace strake
