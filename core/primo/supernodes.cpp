#include "core/primo/supernodes.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "core/primo/lanes.hpp"

namespace strake {
namespace {

// Four entries of the factor.
#define STRAKE_ENTRIES(at) __builtin_convertvector(loose<FourSingles>(at).lanes, Four)

// The factor is read once, in order, but with too much in between for the processor to see that.
constexpr long ahead = 1024;  // entries

/// One or two right-hand sides are a matter of reading the factor, and are summed in double precision, one after the
/// other; more are one of arithmetic, lie beside each other, and take half of the time in single.
template <int width>
constexpr bool is_few = width <= 2;
template <int width>
using Number = std::conditional_t<is_few<width>, double, float>;

/// Where row i of right-hand side k lies: few have `apart` rows each.
template <int width>
STRAKE_INLINE Number<width>& entry_of(Number<width>* x, long apart, long i, int k) {
    return is_few<width> ? x[i + k * apart] : x[i * width + k];
}

/// What a panel of the factor has below its triangle, and few right-hand sides. These are read and written up to the
/// next multiple of four rows.
template <int width, int panel>
struct FewPanel {
    /// y_i -= sum of the columns L_ij x_j.
    static STRAKE_INLINE void subtract_columns(const float* L, int rows, const double* x, double* y, long apart) {
        for (int i = 0; i < rows; i += rows_at_once, L += panel * rows_at_once) {
            __builtin_prefetch(L + ahead);
            Four sum[width] = {};
            for (int j = 0; j < panel; ++j) {
                const Four entries = STRAKE_ENTRIES(L + j * rows_at_once);
                for (int k = 0; k < width; ++k) sum[k] += entries * x[k * apart + j];
            }
            for (int k = 0; k < width; ++k) four(y + k * apart + i).lanes -= sum[k];
        }
    }
    /// x_j -= sum over i of L_ij y_i.
    static STRAKE_INLINE void subtract_rows(const float* L, int rows, const double* y, double* x, long apart) {
        Four sums[width][panel] = {};
        for (int i = (rows - 1) / rows_at_once * rows_at_once; rows > 0 && i >= 0; i -= rows_at_once) {
            const float* at = L + static_cast<long>(panel) * i;
            __builtin_prefetch(at - ahead);
            for (int j = 0; j < panel; ++j) {
                const Four entries = STRAKE_ENTRIES(at + j * rows_at_once);
                for (int k = 0; k < width; ++k) sums[k][j] += entries * four(y + k * apart + i).lanes;
            }
        }
        for (int j = 0; j < panel; ++j)
            for (int k = 0; k < width; ++k) x[k * apart + j] -= sum(sums[k][j]);
    }
};

/// The same for a multiple of eight right-hand sides, which lie beside each other.
template <int width, int panel>
struct ManyPanel {
    static constexpr int groups = width / 8;

    static STRAKE_INLINE Loose<EightSingles>& at(float* values, int group) {
        return loose<EightSingles>(values + 8 * group);
    }

    static STRAKE_INLINE void subtract_columns(const float* L, int rows, float* x, float* y, long) {
        EightSingles from[panel][groups];
        for (int j = 0; j < panel; ++j)
            for (int g = 0; g < groups; ++g) from[j][g] = at(x + j * width, g).lanes;
        for (int i = 0; i < rows; ++i, y += width) {
            const float* entry = L + static_cast<long>(panel) * (i & -rows_at_once) + i % rows_at_once;
            if (i % rows_at_once == 0) __builtin_prefetch(entry + ahead);
            for (int g = 0; g < groups; ++g) {
                EightSingles sum = from[0][g] * entry[0];
                for (int j = 1; j < panel; ++j) sum += from[j][g] * entry[j * rows_at_once];
                at(y, g).lanes -= sum;
            }
        }
    }
    static STRAKE_INLINE void subtract_rows(const float* L, int rows, float* y, float* x, long) {
        EightSingles to[panel][groups];
        for (int j = 0; j < panel; ++j)
            for (int g = 0; g < groups; ++g) to[j][g] = at(x + j * width, g).lanes;
        y += static_cast<long>(rows) * width;
        for (int i = rows - 1; i >= 0; --i) {
            y -= width;
            const float* entry = L + static_cast<long>(panel) * (i & -rows_at_once) + i % rows_at_once;
            if (i % rows_at_once == 0) __builtin_prefetch(entry - ahead);
            for (int g = 0; g < groups; ++g) {
                const EightSingles other = at(y, g).lanes;
                for (int j = 0; j < panel; ++j) to[j][g] -= other * entry[j * rows_at_once];
            }
        }
        for (int j = 0; j < panel; ++j)
            for (int g = 0; g < groups; ++g) at(x + j * width, g).lanes = to[j][g];
    }
};

// Two of four entries, each for four right-hand sides.
#define STRAKE_FOR_FOUR(entries, a, b) __builtin_shufflevector(entries, entries, a, a, a, a, b, b, b, b)

/// Four right-hand sides: two rows of them fill a register.
template <int panel>
struct ManyPanel<4, panel> {
    static STRAKE_INLINE Loose<EightSingles>& two_rows(float* values) { return loose<EightSingles>(values); }

    static STRAKE_INLINE void subtract_columns(const float* L, int rows, float* x, float* y, long) {
        EightSingles from[panel];
        for (int j = 0; j < panel; ++j) {
            const FourSingles one = loose<FourSingles>(x + 4 * j).lanes;
            from[j] = __builtin_shufflevector(one, one, 0, 1, 2, 3, 0, 1, 2, 3);
        }
        for (int i = 0; i < rows; i += rows_at_once, L += panel * rows_at_once, y += 4 * rows_at_once) {
            __builtin_prefetch(L + ahead);
            EightSingles first = {}, last = {};
            for (int j = 0; j < panel; ++j) {
                const FourSingles entries = loose<FourSingles>(L + j * rows_at_once).lanes;
                first += from[j] * STRAKE_FOR_FOUR(entries, 0, 1);
                last += from[j] * STRAKE_FOR_FOUR(entries, 2, 3);
            }
            two_rows(y).lanes -= first;
            two_rows(y + 8).lanes -= last;
        }
    }
    static STRAKE_INLINE void subtract_rows(const float* L, int rows, float* y, float* x, long) {
        EightSingles sum[panel] = {};
        for (int i = (rows - 1) / rows_at_once * rows_at_once; rows > 0 && i >= 0; i -= rows_at_once) {
            const float* at = L + static_cast<long>(panel) * i;
            __builtin_prefetch(at - ahead);
            const EightSingles first = two_rows(y + 4L * i).lanes, last = two_rows(y + 4L * i + 8).lanes;
            for (int j = 0; j < panel; ++j) {
                const FourSingles entries = loose<FourSingles>(at + j * rows_at_once).lanes;
                sum[j] += first * STRAKE_FOR_FOUR(entries, 0, 1) + last * STRAKE_FOR_FOUR(entries, 2, 3);
            }
        }
        for (int j = 0; j < panel; ++j)
            loose<FourSingles>(x + 4 * j).lanes -= __builtin_shufflevector(sum[j], sum[j], 0, 1, 2, 3) +
                                                   __builtin_shufflevector(sum[j], sum[j], 4, 5, 6, 7);
    }
};

template <int width, int panel>
using Panel = std::conditional_t<is_few<width>, FewPanel<width, panel>, ManyPanel<width, panel>>;

/// The rows of a supernode's right-hand sides, from some row on.
template <int width>
struct Local {
    Number<width>* at;
    long apart;
    STRAKE_INLINE Number<width>& operator()(long i, int k) const { return entry_of<width>(at, apart, i, k); }
    STRAKE_INLINE Number<width>* from(long i) const { return &(*this)(i, 0); }
};

/// The panel's own columns of the right-hand side divided by its triangle, and taken off the rows below.
template <int width, int panel>
STRAKE_INLINE void forward_panel(const float* L, int height, const Local<width>& x) {
    for (int p = 0; p < panel; ++p) {
        const Number<width> inverse = 1 / static_cast<Number<width>>(L[p * rows_at_once + p]);
        for (int k = 0; k < width; ++k) x(p, k) *= inverse;
        for (int i = p + 1; i < panel; ++i)
            for (int k = 0; k < width; ++k) x(i, k) -= static_cast<Number<width>>(L[p * rows_at_once + i]) * x(p, k);
    }
    Panel<width, panel>::subtract_columns(L + triangle_size(panel), height - panel, x.at, x.from(panel), x.apart);
}

template <int width, int panel>
STRAKE_INLINE void backward_panel(const float* L, int height, const Local<width>& x) {
    Panel<width, panel>::subtract_rows(L + triangle_size(panel), height - panel, x.from(panel), x.at, x.apart);
    for (int p = panel - 1; p >= 0; --p) {
        for (int i = p + 1; i < panel; ++i)
            for (int k = 0; k < width; ++k) x(p, k) -= static_cast<Number<width>>(L[p * rows_at_once + i]) * x(i, k);
        const Number<width> inverse = 1 / static_cast<Number<width>>(L[p * rows_at_once + p]);
        for (int k = 0; k < width; ++k) x(p, k) *= inverse;
    }
}

/// `local` holds the rows of the supernode: its own, known so far, then zeros that collect what goes to rows below.
template <int width>
STRAKE_INLINE void forward(const float* L, int columns, int rows, const Local<width>& local) {
    int j = 0;
    const auto from = [&] { return Local<width>{local.from(j), local.apart}; };
    for (; j + 4 <= columns; L += panel_size(4, rows - j), j += 4) forward_panel<width, 4>(L, rows - j, from());
    for (; j + 2 <= columns; L += panel_size(2, rows - j), j += 2) forward_panel<width, 2>(L, rows - j, from());
    for (; j < columns; L += panel_size(1, rows - j), ++j) forward_panel<width, 1>(L, rows - j, from());
}

/// `local` holds the solution in the rows below and the right-hand side in the supernode's own. `L`: behind its
/// entries.
template <int width>
STRAKE_INLINE void backward(const float* L, int columns, int rows, const Local<width>& local) {
    int j = columns;  // the panels of `forward`, from behind
    const auto from = [&] { return Local<width>{local.from(j), local.apart}; };
    if (j % 2) j -= 1, L -= panel_size(1, rows - j), backward_panel<width, 1>(L, rows - j, from());
    if (j % 4) j -= 2, L -= panel_size(2, rows - j), backward_panel<width, 2>(L, rows - j, from());
    while (j > 0) j -= 4, L -= panel_size(4, rows - j), backward_panel<width, 4>(L, rows - j, from());
}

/// Rows [0, count) of the right-hand sides from one place to another: their own columns of a supernode.
template <int width>
STRAKE_INLINE void copy_rows(const Local<width>& from, int count, const Local<width>& to) {
    if (!is_few<width>) {
        std::memcpy(to.at, from.at, sizeof(Number<width>) * count * width);
        return;
    }
    for (int k = 0; k < width; ++k)
        std::memcpy(to.at + k * to.apart, from.at + k * from.apart, sizeof(Number<width>) * count);
}

template <int width>
STRAKE_INLINE void substitute(const Supernodes& f, Number<width>* all, Number<width>* scratch) {
    const int last = f.num_supernodes();
    const Local<width> x{all, f.size};
    for (int s = 0; s < last; ++s) {
        const int column = f.first_column[s], columns = f.first_column[s + 1] - column;
        const int* row = f.row.data() + f.first_row[s];
        const int rows = static_cast<int>(f.first_row[s + 1] - f.first_row[s]);
        const Local<width> own{x.from(column), x.apart}, local{scratch, rows + rows_at_once};
        copy_rows<width>(own, columns, local);
        for (int k = 0; k < (is_few<width> ? width : 1); ++k)
            std::memset(local.at + (is_few<width> ? columns + k * local.apart : long{columns} * width), 0,
                        sizeof(Number<width>) * (rows - columns) * (is_few<width> ? 1 : width));
        forward<width>(f.entry.get() + f.first_entry[s], columns, rows, local);
        copy_rows<width>(local, columns, own);
        for (int i = columns; i < rows; ++i)
            for (int k = 0; k < width; ++k) x(row[i], k) += local(i, k);
    }
    for (int s = last - 1; s >= 0; --s) {
        const int column = f.first_column[s], columns = f.first_column[s + 1] - column;
        const int* row = f.row.data() + f.first_row[s];
        const int rows = static_cast<int>(f.first_row[s + 1] - f.first_row[s]);
        const Local<width> own{x.from(column), x.apart}, local{scratch, rows + rows_at_once};
        copy_rows<width>(own, columns, local);
        for (int i = columns; i < rows; ++i)
            for (int k = 0; k < width; ++k) local(i, k) = x(row[i], k);
        backward<width>(f.entry.get() + f.first_entry[s + 1], columns, rows, local);
        copy_rows<width>(local, columns, own);
    }
}

#if defined(__x86_64__)
template <int width>
__attribute__((target("avx2"))) void substitute_wide(const Supernodes& f, Number<width>* x, Number<width>* local) {
    substitute<width>(f, x, local);
}
#endif
template <int width>
void substitute_plain(const Supernodes& f, Number<width>* x, Number<width>* local) {
    substitute<width>(f, x, local);
}

/// Columns [first, first + width) of B to X; those beyond the last are zeros. Their sizes are taken out before and put
/// back, so that single precision neither over- nor underflows.
template <int width>
void solve_block(const Supernodes& f, const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::MatrixXd& X,
                 Eigen::Index first) {
    const int given = static_cast<int>(std::min<Eigen::Index>(width, B.cols() - first));
    double size[width];
    for (int k = 0; k < given; ++k) {
        size[k] = !is_few<width> ? B.col(first + k).lpNorm<Eigen::Infinity>() : 1;
        if (!(size[k] > 0)) size[k] = 1;
    }
    std::vector<Number<width>> x(static_cast<std::size_t>(f.size) * width, 0),
        local(static_cast<std::size_t>(f.most_rows + rows_at_once) * width);
    for (int i = 0; i < f.size; ++i)
        for (int k = 0; k < given; ++k)
            entry_of<width>(x.data(), f.size, i, k) =
                static_cast<Number<width>>(B(f.permutation[i], first + k) / size[k]);
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2"))
        substitute_wide<width>(f, x.data(), local.data());
    else
#endif
        substitute_plain<width>(f, x.data(), local.data());
    for (int i = 0; i < f.size; ++i)
        for (int k = 0; k < given; ++k)
            X(f.permutation[i], first + k) = size[k] * entry_of<width>(x.data(), f.size, i, k);
}

}  // namespace

void Supernodes::solve(const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::MatrixXd& X) const {
    X.resize(B.rows(), B.cols());
    for (Eigen::Index first = 0; first < B.cols();) {
        const Eigen::Index left = B.cols() - first;
        if (left == 1)
            solve_block<1>(*this, B, X, first), first += 1;
        else if (left == 2)
            solve_block<2>(*this, B, X, first), first += 2;
        else if (left <= 4)
            solve_block<4>(*this, B, X, first), first += 4;
        else if (left <= 8)
            solve_block<8>(*this, B, X, first), first += 8;
        else
            solve_block<16>(*this, B, X, first), first += 16;
    }
}

}  // namespace strake
