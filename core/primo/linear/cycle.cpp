#include "core/parallel.hpp"
#include "core/primo/linear/multigrid_levels.hpp"
#include "core/primo/linear/vectors.hpp"

namespace strake {
namespace {

template <class Work>
void for_entries(std::size_t size, const Work& work) {
    for_blocks(static_cast<int>(size), entries_at_once, work);
}

}  // namespace

/// x <- x + p(A) r with the Chebyshev polynomial of the interval [share, 1] times the bound of the spectrum; before
/// the coarse correction from x = 0, and r <- r - A p(A) r.
template <class Real>
void Hierarchy<Real>::smooth(Level& level, int at, std::vector<Real>& x, std::vector<Real>& r, bool before) const {
    const double high = level.largest, low = (at == 0 ? options_.smoothed_share : options_.coarse_share) * high;
    const double middle = (high + low) / 2, half = (high - low) / 2, sigma = middle / half;
    const int n = level.A.size(), steps = at == 0 ? options_.smoothing_steps : options_.coarse_smoothing_steps;
    std::vector<Real>&d = level.direction, &next = level.next;
    d.resize(r.size()), next.resize(r.size()), x.resize(r.size());
    for_entries(r.size(), [&](int begin, int end) {
        for (int i = begin; i < end; ++i) d[i] = static_cast<Real>(r[i] / middle);
        if (before) std::fill(x.data() + begin, x.data() + end, Real(0));
    });
    double rho = 1 / sigma;
    for (int step = 1; step <= steps; ++step) {
        if (!before && step == steps) {  // the last residual is not needed
            for_entries(r.size(), [&](int begin, int end) {
                for (int i = begin; i < end; ++i) x[i] += d[i];
            });
            return;
        }
        const double rho_next = 1 / (2 * sigma - rho);
        const Real keep = static_cast<Real>(rho_next * rho), take = static_cast<Real>(2 * rho_next / half);
        for_blocks(n, rows_at_once, [&](int begin, int end) {
            for (int i = begin; i < end; ++i) {
                Real product[6];
                row_product(level.A, i, d.data(), product);
                for (int q = 6 * i; q < 6 * i + 6; ++q) {
                    x[q] += d[q];
                    r[q] -= product[q - 6 * i];
                    next[q] = keep * d[q] + take * r[q];
                }
            }
        });
        std::swap(d, next);
        rho = rho_next;
    }
}

template <class Real>
void Hierarchy<Real>::cycle(int at, const std::vector<Real>& b, std::vector<Real>& x) {
    using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
    Level& level = levels_[at];
    if (at + 1 == static_cast<int>(levels_.size())) {
        const Eigen::VectorXd rhs = Eigen::Map<const Vector>(b.data(), b.size()).template cast<double>();
        x.resize(b.size());
        Eigen::Map<Vector>(x.data(), x.size()) = coarsest_.solve(rhs).col(0).template cast<Real>();
        return;
    }
    std::vector<Real>& residual = level.residual;
    residual.resize(b.size());
    for_entries(b.size(),
                [&](int begin, int end) { std::copy(b.data() + begin, b.data() + end, residual.data() + begin); });
    smooth(level, at, x, residual, true);
    Level& coarse = levels_[at + 1];
    transposed_product(level.P, level.groups, residual, coarse.A.size(), coarse.r);
    coarse_solve(at + 1, coarse.r, coarse.x);
    add_product(level.P, coarse.x, x);
    for_blocks(level.A.size(), rows_at_once, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
            Real product[6];
            row_product(level.A, i, x.data(), product);
            for (int q = 6 * i; q < 6 * i + 6; ++q) residual[q] = b[q] - product[q - 6 * i];
        }
    });
    smooth(level, at, x, residual, false);
}

/// The K-cycle (Notay, Vassilevski 2008): two steps of flexible conjugate gradients, one if that suffices. The linear
/// version, a W-cycle, adds both.
template <class Real>
void Hierarchy<Real>::coarse_solve(int at, const std::vector<Real>& b, std::vector<Real>& x) {
    Level& level = levels_[at];
    if (at + 1 == static_cast<int>(levels_.size())) return cycle(at, b, x);
    std::vector<Real>&c = level.c1, &v = level.v1, &d = level.c2, &w = level.v2, &left = level.left;
    cycle(at, b, c);
    multiply(level.A, c, v);
    if (kind_ == Cycle::linear) {
        left.resize(b.size()), x.resize(b.size());
        for_entries(b.size(), [&](int begin, int end) {
            for (int i = begin; i < end; ++i) left[i] = b[i] - v[i];
        });
        cycle(at, left, d);
        for_entries(b.size(), [&](int begin, int end) {
            for (int i = begin; i < end; ++i) x[i] = c[i] + d[i];
        });
        return;
    }
    const double rho = dot(c, v), size = dot(b, b);
    if (!(rho > 0)) {  // b is zero or round-off: the outer iteration will notice
        x = c;
        return;
    }
    const double first = dot(c, b) / rho;
    left.resize(b.size()), x.resize(b.size());
    for_entries(b.size(), [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
            left[i] = b[i] - static_cast<Real>(first) * v[i];
            x[i] = static_cast<Real>(first) * c[i];
        }
    });
    if (dot(left, left) <= options_.inner_tolerance * options_.inner_tolerance * size) return;
    cycle(at, left, d);
    multiply(level.A, d, w);
    const double gamma = dot(d, v), last = dot(d, w) - gamma * gamma / rho;
    if (!(last > 0)) return;
    const double second = dot(d, left) / last;
    const Real of_c = static_cast<Real>(first - gamma * second / rho), of_d = static_cast<Real>(second);
    for_entries(b.size(), [&](int begin, int end) {
        for (int i = begin; i < end; ++i) x[i] = of_c * c[i] + of_d * d[i];
    });
}

template <class Real>
Eigen::VectorXd Hierarchy<Real>::apply(const Eigen::Ref<const Eigen::VectorXd>& r, Cycle kind) {
    using Block = Eigen::Matrix<Real, 6, 6>;
    using Six = Eigen::Matrix<Real, 6, 1>;
    const double size = largest_entry(r);  // scaled out against underflow in single precision
    if (!(size > 0)) return Eigen::VectorXd::Zero(r.size());
    const auto scale = [&](int i) { return Eigen::Map<const Block>(scale_.data() + std::size_t{block_entries} * i); };
    const int n = levels_[0].A.size();
    std::vector<Real> b(r.size()), x;
    for_blocks(n, rows_at_once, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
            const Six part = (r.segment<6>(6 * i) / size).template cast<Real>();
            Eigen::Map<Six>(b.data() + 6 * i) = scale(i) * part;
        }
    });
    kind_ = kind;
    cycle(0, b, x);
    Eigen::VectorXd z(r.size());
    for_blocks(n, rows_at_once, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
            const Six part = scale(i).transpose() * Eigen::Map<const Six>(x.data() + 6 * i);
            z.segment<6>(6 * i) = size * part.template cast<double>();
        }
    });
    return z;
}

template <class Real>
std::size_t Hierarchy<Real>::bytes() const {
    std::size_t sum = sizeof(Real) * scale_.size();
    for (const Level& level : levels_)
        sum += level.A.bytes() + level.P.bytes() + sizeof(Real) * level.groups.sums.size() +
               sizeof(Real) * std::size_t{60} * level.A.size();
    return sum;
}

/// Products of blocks: those of the finest level once, of each one below twice as often as of the one above it.
template <class Real>
double Hierarchy<Real>::cycle_work() const {
    double sum = 0, visits = 1;
    for (std::size_t at = 0; at + 1 < levels_.size(); ++at, visits *= 2) {
        const Level& level = levels_[at];
        const int products = 2 * (at == 0 ? options_.smoothing_steps : options_.coarse_smoothing_steps) + (at > 0);
        // Vector operations count like the missing diagonal blocks.
        const double blocks = static_cast<double>(level.A.column.size()) + level.A.size();
        sum += visits * (products * blocks + 2 * static_cast<double>(level.P.column.size()));
    }
    const double last = 2 * static_cast<double>(coarsest_.num_factor_entries()) / block_entries;
    return (sum + visits / 2 * last) * static_cast<double>(sizeof(Real) / sizeof(float));
}

template Eigen::VectorXd Hierarchy<float>::apply(const Eigen::Ref<const Eigen::VectorXd>&, Cycle);
template Eigen::VectorXd Hierarchy<double>::apply(const Eigen::Ref<const Eigen::VectorXd>&, Cycle);
template std::size_t Hierarchy<float>::bytes() const;
template double Hierarchy<float>::cycle_work() const;
template double Hierarchy<double>::cycle_work() const;
template std::size_t Hierarchy<double>::bytes() const;

}  // namespace strake
