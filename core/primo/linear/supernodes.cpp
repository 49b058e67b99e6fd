#include "core/primo/linear/supernodes.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "core/parallel.hpp"
#include "core/primo/linear/lanes.hpp"
#include "core/primo/linear/vectors.hpp"

namespace strake {
namespace {

// Four entries of the factor.
#define STRAKE_ENTRIES(at) __builtin_convertvector(loose<FourSingles>(at).lanes, Four)

// The factor is read in order, but too slowly for the hardware prefetcher.
constexpr long ahead = 1024;          // entries
constexpr int places_at_once = 4096;  // of a right-hand side, by one of several threads

/// One or two right-hand sides are bound by memory and summed in double precision, one after the other. More are bound
/// by arithmetic, interleaved, and take half the time in single precision.
template <int width>
constexpr bool is_few = width <= 2;
template <int width>
using Number = std::conditional_t<is_few<width>, double, float>;

/// Where row i of right-hand side k lies: few have `apart` rows each.
template <int width>
STRAKE_INLINE Number<width>& entry_of(Number<width>* x, long apart, long i, int k) {
    return is_few<width> ? x[i + k * apart] : x[i * width + k];
}

/// Part of a panel below its triangle, for few right-hand sides. These are read and written up to the
/// next multiple of four rows.
template <int width, int panel>
struct FewPanel {
    /// y_i -= sum of the columns L_ij x_j.
    static STRAKE_INLINE void subtract_columns(const float* L, int rows, const double* x, double* y, long apart) {
        for (int i = 0; i < rows; i += panel_rows, L += panel * panel_rows) {
            __builtin_prefetch(L + ahead);
            Four sum[width] = {};
            for (int j = 0; j < panel; ++j) {
                const Four entries = STRAKE_ENTRIES(L + j * panel_rows);
                for (int k = 0; k < width; ++k) sum[k] += entries * x[k * apart + j];
            }
            for (int k = 0; k < width; ++k) four(y + k * apart + i).lanes -= sum[k];
        }
    }
    /// x_j -= sum over i of L_ij y_i.
    static STRAKE_INLINE void subtract_rows(const float* L, int rows, const double* y, double* x, long apart) {
        Four sums[width][panel] = {};
        for (int i = (rows - 1) / panel_rows * panel_rows; rows > 0 && i >= 0; i -= panel_rows) {
            const float* at = L + static_cast<long>(panel) * i;
            __builtin_prefetch(at - ahead);
            for (int j = 0; j < panel; ++j) {
                const Four entries = STRAKE_ENTRIES(at + j * panel_rows);
                for (int k = 0; k < width; ++k) sums[k][j] += entries * four(y + k * apart + i).lanes;
            }
        }
        for (int j = 0; j < panel; ++j)
            for (int k = 0; k < width; ++k) x[k * apart + j] -= sum(sums[k][j]);
    }
};

/// The same for a multiple of eight interleaved right-hand sides.
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
            const float* entry = L + static_cast<long>(panel) * (i & -panel_rows) + i % panel_rows;
            if (i % panel_rows == 0) __builtin_prefetch(entry + ahead);
            for (int g = 0; g < groups; ++g) {
                EightSingles sum = from[0][g] * entry[0];
                for (int j = 1; j < panel; ++j) sum += from[j][g] * entry[j * panel_rows];
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
            const float* entry = L + static_cast<long>(panel) * (i & -panel_rows) + i % panel_rows;
            if (i % panel_rows == 0) __builtin_prefetch(entry - ahead);
            for (int g = 0; g < groups; ++g) {
                const EightSingles other = at(y, g).lanes;
                for (int j = 0; j < panel; ++j) to[j][g] -= other * entry[j * panel_rows];
            }
        }
        for (int j = 0; j < panel; ++j)
            for (int g = 0; g < groups; ++g) at(x + j * width, g).lanes = to[j][g];
    }
};

/// Four right-hand sides: two rows of them fill a register.
template <int panel>
struct ManyPanel<4, panel> {
    /// The entries of two rows each, for all four right-hand sides.
    static STRAKE_INLINE void spread(const float* entries, EightSingles& first, EightSingles& last) {
        const FourSingles v = loose<FourSingles>(entries).lanes;
        first = __builtin_shufflevector(v, v, 0, 0, 0, 0, 1, 1, 1, 1);
        last = __builtin_shufflevector(v, v, 2, 2, 2, 2, 3, 3, 3, 3);
    }
    static STRAKE_INLINE Loose<EightSingles>& two_rows(float* values) { return loose<EightSingles>(values); }

    static STRAKE_INLINE void subtract_columns(const float* L, int rows, float* x, float* y, long) {
        EightSingles from[panel];
        for (int j = 0; j < panel; ++j) {
            const FourSingles one = loose<FourSingles>(x + 4 * j).lanes;
            from[j] = __builtin_shufflevector(one, one, 0, 1, 2, 3, 0, 1, 2, 3);
        }
        for (int i = 0; i < rows; i += panel_rows, L += panel * panel_rows, y += 4 * panel_rows) {
            __builtin_prefetch(L + ahead);
            EightSingles first = {}, last = {};
            for (int j = 0; j < panel; ++j) {
                EightSingles two, other_two;
                spread(L + j * panel_rows, two, other_two);
                first += from[j] * two;
                last += from[j] * other_two;
            }
            two_rows(y).lanes -= first;
            two_rows(y + 8).lanes -= last;
        }
    }
    static STRAKE_INLINE void subtract_rows(const float* L, int rows, float* y, float* x, long) {
        EightSingles sum[panel] = {};
        for (int i = (rows - 1) / panel_rows * panel_rows; rows > 0 && i >= 0; i -= panel_rows) {
            const float* at = L + static_cast<long>(panel) * i;
            __builtin_prefetch(at - ahead);
            const EightSingles first = two_rows(y + 4L * i).lanes, last = two_rows(y + 4L * i + 8).lanes;
            for (int j = 0; j < panel; ++j) {
                EightSingles two, other_two;
                spread(at + j * panel_rows, two, other_two);
                sum[j] += first * two + last * other_two;
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
        const Number<width> inverse = 1 / static_cast<Number<width>>(L[p * panel_rows + p]);
        for (int k = 0; k < width; ++k) x(p, k) *= inverse;
        for (int i = p + 1; i < panel; ++i)
            for (int k = 0; k < width; ++k) x(i, k) -= static_cast<Number<width>>(L[p * panel_rows + i]) * x(p, k);
    }
    Panel<width, panel>::subtract_columns(L + triangle_size(panel), height - panel, x.at, x.from(panel), x.apart);
}

template <int width, int panel>
STRAKE_INLINE void backward_panel(const float* L, int height, const Local<width>& x) {
    Panel<width, panel>::subtract_rows(L + triangle_size(panel), height - panel, x.from(panel), x.at, x.apart);
    for (int p = panel - 1; p >= 0; --p) {
        for (int i = p + 1; i < panel; ++i)
            for (int k = 0; k < width; ++k) x(p, k) -= static_cast<Number<width>>(L[p * panel_rows + i]) * x(i, k);
        const Number<width> inverse = 1 / static_cast<Number<width>>(L[p * panel_rows + p]);
        for (int k = 0; k < width; ++k) x(p, k) *= inverse;
    }
}

/// `local` holds the rows of the supernode: its own, final ones, then zeros that collect contributions to rows below.
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
    int j = columns;  // the panels of `forward`, in reverse
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

/// The supernodes of one task, upwards or back down; x holds the rows, then those of later rounds, task by task.
template <int width>
STRAKE_INLINE void substitute(const Supernodes& f, int task, bool upwards, const Local<width>& x,
                              Number<width>* scratch) {
    const int first = f.task_begin[task], last = f.task_begin[task + 1];
    for (int q = first; upwards && q < last; ++q) {
        const int s = f.order[q], column = f.first_column[s], columns = f.first_column[s + 1] - column;
        const int* row = f.row.data() + f.first_row[s];
        const int rows = static_cast<int>(f.first_row[s + 1] - f.first_row[s]);
        const Local<width> own{x.from(column), x.apart}, local{scratch, rows + panel_rows};
        copy_rows<width>(own, columns, local);
        for (int k = 0; k < (is_few<width> ? width : 1); ++k)
            std::memset(local.at + (is_few<width> ? columns + k * local.apart : long{columns} * width), 0,
                        sizeof(Number<width>) * (rows - columns) * (is_few<width> ? 1 : width));
        forward<width>(f.entry.get() + f.first_entry[s], columns, rows, local);
        copy_rows<width>(local, columns, own);
        for (int i = columns; i < rows; ++i)
            for (int k = 0; k < width; ++k) x(row[i], k) += local(i, k);
    }
    for (int q = last - 1; !upwards && q >= first; --q) {
        const int s = f.order[q], column = f.first_column[s], columns = f.first_column[s + 1] - column;
        const int* row = f.row.data() + f.first_row[s];
        const int rows = static_cast<int>(f.first_row[s + 1] - f.first_row[s]);
        const Local<width> own{x.from(column), x.apart}, local{scratch, rows + panel_rows};
        copy_rows<width>(own, columns, local);
        for (int i = columns; i < rows; ++i)
            for (int k = 0; k < width; ++k) local(i, k) = x(row[i], k);
        backward<width>(f.entry.get() + f.first_entry[s + 1], columns, rows, local);
        copy_rows<width>(local, columns, own);
    }
}

#if defined(__x86_64__)
template <int width>
__attribute__((target("avx2"))) void substitute_wide(const Supernodes& f, int task, bool upwards, const Local<width>& x,
                                                     Number<width>* local) {
    substitute<width>(f, task, upwards, x, local);
}
#endif
template <int width>
void substitute_plain(const Supernodes& f, int task, bool upwards, const Local<width>& x, Number<width>* local) {
    substitute<width>(f, task, upwards, x, local);
}

template <int width>
void do_task(const Supernodes& f, int task, bool upwards, const Local<width>& x) {
    std::vector<Number<width>> local(static_cast<std::size_t>(f.max_rows + panel_rows) * width);
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) return substitute_wide<width>(f, task, upwards, x, local.data());
#endif
    substitute_plain<width>(f, task, upwards, x, local.data());
}

/// Calls work(row of a later round, where the task keeps it) for all of a task.
template <int width, class Work>
void for_outside(const Supernodes& f, int task, const Local<width>& x, const Work& work) {
    for (int q = f.outside_begin[task]; q < f.outside_begin[task + 1]; ++q)
        for (int k = 0; k < width; ++k) work(x(f.outside[q], k), x(long{f.size} + q, k));
}

template <int width>
void substitute_all(const Supernodes& f, const Local<width>& x) {
    const int rounds = static_cast<int>(f.round_begin.size()) - 1;
    const auto for_tasks = [&](int round, const auto& work) {
        const int first = f.round_begin[round];
        for_blocks(f.round_begin[round + 1] - first, 1, [&](int begin, int) { work(first + begin); });
    };
    for (int r = 0; r < rounds; ++r) {
        for_tasks(r, [&](int task) { do_task<width>(f, task, true, x); });
        for (int task = f.round_begin[r]; task < f.round_begin[r + 1]; ++task)
            for_outside<width>(f, task, x, [](Number<width>& row, Number<width> kept) { row += kept; });
    }
    for (int r = rounds - 1; r >= 0; --r)
        for_tasks(r, [&](int task) {
            for_outside<width>(f, task, x, [](Number<width> row, Number<width>& kept) { kept = row; });
            do_task<width>(f, task, false, x);
        });
}

/// Columns [first, first + width) of B to X; those beyond the last are zeros. Scaled to unit size and back, against
/// over- and underflow in single precision.
template <int width>
void solve_block(const Supernodes& f, const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::MatrixXd& X,
                 Eigen::Index first) {
    const int given = static_cast<int>(std::min<Eigen::Index>(width, B.cols() - first));
    double size[width];
    for (int k = 0; k < given; ++k) {
        size[k] = !is_few<width> ? largest_entry(B.col(first + k)) : 1;
        if (!(size[k] > 0)) size[k] = 1;
    }
    const auto rows = static_cast<long>(f.size + f.outside.size());
    std::vector<Number<width>> values(static_cast<std::size_t>(rows) * width, 0);
    const Local<width> x{values.data(), rows};
    for_blocks(f.size, places_at_once, [&](int begin, int end) {
        for (int i = begin; i < end; ++i)
            for (int k = 0; k < given; ++k)
                x(i, k) = static_cast<Number<width>>(B(f.permutation[i], first + k) / size[k]);
    });
    substitute_all<width>(f, x);
    for_blocks(f.size, places_at_once, [&](int begin, int end) {
        for (int i = begin; i < end; ++i)
            for (int k = 0; k < given; ++k) X(f.permutation[i], first + k) = size[k] * x(i, k);
    });
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
