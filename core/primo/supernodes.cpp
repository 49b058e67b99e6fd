#include "core/primo/supernodes.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "core/parallel.hpp"
#include "core/primo/lanes.hpp"
#include "core/primo/vectors.hpp"

namespace strake {
namespace {

// Four entries of the factor.
#define STRAKE_ENTRIES(at) __builtin_convertvector(loose<FourSingles>(at).lanes, Four)

// The factor is read once, in order, but in pieces too short for the processor to see that.
constexpr long ahead = 1024;        // entries
constexpr int wide_panel = 4;       // columns
constexpr int rows_at_once = 4096;  // into the factor's order and back, by one of several threads

/// One right-hand side is a matter of reading the factor, and is summed in double precision; several are one of
/// arithmetic, and take half of the time in single.
template <int width>
using Number = std::conditional_t<width == 1, double, float>;

/// `panel` columns of the factor, from below the block on its diagonal, and `width` right-hand sides that lie beside
/// each other: one, four, or a multiple of eight.
template <int width, int panel>
struct Panel;

template <int panel>
struct Panel<1, panel> {
    /// y_i -= sum of the columns L_ij x_j.
    static STRAKE_INLINE void subtract_columns(const float* L, long height, int rows, const double* x, double* y) {
        int i = 0;
        for (; i + 4 <= rows; i += 4) {
            __builtin_prefetch(L + panel * i + ahead);
            Four sum = {};
            for (int j = 0; j < panel; ++j) sum += STRAKE_ENTRIES(L + j * height + i) * x[j];
            four(y + i).lanes -= sum;
        }
        for (; i < rows; ++i) {
            double sum = 0;
            for (int j = 0; j < panel; ++j) sum += static_cast<double>(L[j * height + i]) * x[j];
            y[i] -= sum;
        }
    }
    /// x_j -= sum over i of L_ij y_i.
    static STRAKE_INLINE void subtract_rows(const float* L, long height, int rows, const double* y, double* x) {
        Four sum[panel] = {};
        int i = 0;
        for (; i + 4 <= rows; i += 4) {
            __builtin_prefetch(L + panel * i - ahead);
            const Four other = four(y + i).lanes;
            for (int j = 0; j < panel; ++j) sum[j] += STRAKE_ENTRIES(L + j * height + i) * other;
        }
        double rest[panel] = {};
        for (; i < rows; ++i)
            for (int j = 0; j < panel; ++j) rest[j] += static_cast<double>(L[j * height + i]) * y[i];
        for (int j = 0; j < panel; ++j) x[j] -= ((sum[j][0] + sum[j][1]) + (sum[j][2] + sum[j][3])) + rest[j];
    }
};

template <int width, int panel>
struct Panel {
    static constexpr int groups = (width + 7) / 8;
    using Lanes = std::conditional_t<width / groups == 8, EightSingles, FourSingles>;
    static constexpr int lanes = width / groups;

    static STRAKE_INLINE Loose<Lanes>& at(float* values, int group) { return loose<Lanes>(values + lanes * group); }

    static STRAKE_INLINE void subtract_columns(const float* L, long height, int rows, float* x, float* y) {
        Lanes from[panel][groups];
        for (int j = 0; j < panel; ++j)
            for (int g = 0; g < groups; ++g) from[j][g] = at(x + j * width, g).lanes;
        for (int i = 0; i < rows; ++i, y += width) {
            if (i % 4 == 0) __builtin_prefetch(L + panel * i + ahead);
            for (int g = 0; g < groups; ++g) {
                Lanes sum = from[0][g] * L[i];
                for (int j = 1; j < panel; ++j) sum += from[j][g] * L[j * height + i];
                at(y, g).lanes -= sum;
            }
        }
    }
    static STRAKE_INLINE void subtract_rows(const float* L, long height, int rows, float* y, float* x) {
        Lanes to[panel][groups];
        for (int j = 0; j < panel; ++j)
            for (int g = 0; g < groups; ++g) to[j][g] = at(x + j * width, g).lanes;
        for (int i = 0; i < rows; ++i, y += width) {
            if (i % 4 == 0) __builtin_prefetch(L + panel * i - ahead);
            for (int g = 0; g < groups; ++g) {
                const Lanes other = at(y, g).lanes;
                for (int j = 0; j < panel; ++j) to[j][g] -= other * L[j * height + i];
            }
        }
        for (int j = 0; j < panel; ++j)
            for (int g = 0; g < groups; ++g) at(x + j * width, g).lanes = to[j][g];
    }
};

/// The panel's own columns of the right-hand side divided by its triangle, and taken off the rows below.
template <int width, int panel>
STRAKE_INLINE void forward_panel(const float* L, long height, int rows, Number<width>* x) {
    for (int p = 0; p < panel; ++p) {
        const Number<width> inverse = 1 / static_cast<Number<width>>(L[p * height + p]);
        for (int k = 0; k < width; ++k) x[p * width + k] *= inverse;
        for (int i = p + 1; i < panel; ++i)
            for (int k = 0; k < width; ++k)
                x[i * width + k] -= static_cast<Number<width>>(L[p * height + i]) * x[p * width + k];
    }
    Panel<width, panel>::subtract_columns(L + panel, height, rows - panel, x, x + panel * width);
}

template <int width, int panel>
STRAKE_INLINE void backward_panel(const float* L, long height, int rows, Number<width>* x) {
    Panel<width, panel>::subtract_rows(L + panel, height, rows - panel, x + panel * width, x);
    for (int p = panel - 1; p >= 0; --p) {
        for (int i = p + 1; i < panel; ++i)
            for (int k = 0; k < width; ++k)
                x[p * width + k] -= static_cast<Number<width>>(L[p * height + i]) * x[i * width + k];
        const Number<width> inverse = 1 / static_cast<Number<width>>(L[p * height + p]);
        for (int k = 0; k < width; ++k) x[p * width + k] *= inverse;
    }
}

/// `local` holds the rows of the supernode: its own, known so far, then zeros that collect what goes to rows below.
template <int width>
STRAKE_INLINE void forward(const float* L, int columns, int rows, Number<width>* local) {
    int j = 0;
    const auto at = [&] { return L + static_cast<long>(j) * rows + j; };
    for (; j + wide_panel <= columns; j += wide_panel)
        forward_panel<width, wide_panel>(at(), rows, rows - j, local + static_cast<long>(j) * width);
    for (; j + 2 <= columns; j += 2)
        forward_panel<width, 2>(at(), rows, rows - j, local + static_cast<long>(j) * width);
    for (; j < columns; ++j) forward_panel<width, 1>(at(), rows, rows - j, local + static_cast<long>(j) * width);
}

/// `local` holds the solution in the rows below and the right-hand side in the supernode's own.
template <int width>
STRAKE_INLINE void backward(const float* L, int columns, int rows, Number<width>* local) {
    int j = columns;  // the panels of `forward`, from behind
    const auto at = [&] { return L + static_cast<long>(j) * rows + j; };
    if (j % 2) --j, backward_panel<width, 1>(at(), rows, rows - j, local + static_cast<long>(j) * width);
    while (j % wide_panel) j -= 2, backward_panel<width, 2>(at(), rows, rows - j, local + static_cast<long>(j) * width);
    while (j > 0)
        j -= wide_panel, backward_panel<width, wide_panel>(at(), rows, rows - j, local + static_cast<long>(j) * width);
}

/// The supernodes of one task, upwards or back down; x holds the rows, then those of later rounds, task by task.
template <int width>
STRAKE_INLINE void substitute(const Supernodes& f, int task, bool upwards, Number<width>* x, Number<width>* local) {
    const int first = f.task_begin[task], last = f.task_begin[task + 1];
    for (int q = first; upwards && q < last; ++q) {
        const int s = f.order[q], column = f.first_column[s], columns = f.first_column[s + 1] - column;
        const int* row = f.row.data() + f.first_row[s];
        const int rows = static_cast<int>(f.first_row[s + 1] - f.first_row[s]);
        std::memcpy(local, x + static_cast<long>(column) * width, sizeof(Number<width>) * columns * width);
        std::memset(local + static_cast<long>(columns) * width, 0, sizeof(Number<width>) * (rows - columns) * width);
        forward<width>(f.entry.data() + f.first_entry[s], columns, rows, local);
        std::memcpy(x + static_cast<long>(column) * width, local, sizeof(Number<width>) * columns * width);
        for (int i = columns; i < rows; ++i)
            for (int k = 0; k < width; ++k)
                x[static_cast<long>(row[i]) * width + k] += local[static_cast<long>(i) * width + k];
    }
    for (int q = last - 1; !upwards && q >= first; --q) {
        const int s = f.order[q], column = f.first_column[s], columns = f.first_column[s + 1] - column;
        const int* row = f.row.data() + f.first_row[s];
        const int rows = static_cast<int>(f.first_row[s + 1] - f.first_row[s]);
        std::memcpy(local, x + static_cast<long>(column) * width, sizeof(Number<width>) * columns * width);
        for (int i = columns; i < rows; ++i)
            for (int k = 0; k < width; ++k)
                local[static_cast<long>(i) * width + k] = x[static_cast<long>(row[i]) * width + k];
        backward<width>(f.entry.data() + f.first_entry[s], columns, rows, local);
        std::memcpy(x + static_cast<long>(column) * width, local, sizeof(Number<width>) * columns * width);
    }
}

#if defined(__x86_64__)
template <int width>
__attribute__((target("avx2"))) void substitute_wide(const Supernodes& f, int task, bool upwards, Number<width>* x,
                                                     Number<width>* local) {
    substitute<width>(f, task, upwards, x, local);
}
#endif
template <int width>
void substitute_plain(const Supernodes& f, int task, bool upwards, Number<width>* x, Number<width>* local) {
    substitute<width>(f, task, upwards, x, local);
}

template <int width>
void do_task(const Supernodes& f, int task, bool upwards, Number<width>* x) {
    std::vector<Number<width>> local(static_cast<std::size_t>(f.most_rows) * width);
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) return substitute_wide<width>(f, task, upwards, x, local.data());
#endif
    substitute_plain<width>(f, task, upwards, x, local.data());
}

/// Calls work(row of a later round, where the task keeps it) for all of a task.
template <int width, class Work>
void for_outside(const Supernodes& f, int task, Number<width>* x, const Work& work) {
    Number<width>* apart = x + static_cast<long>(f.size) * width;
    for (int q = f.outside_begin[task]; q < f.outside_begin[task + 1]; ++q)
        for (int k = 0; k < width; ++k)
            work(x[static_cast<long>(f.outside[q]) * width + k], apart[static_cast<long>(q) * width + k]);
}

template <int width>
void substitute_all(const Supernodes& f, Number<width>* x) {
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

/// Columns [first, first + width) of B to X; those beyond the last are zeros. Their sizes are taken out before and put
/// back, so that single precision neither over- nor underflows.
template <int width>
void solve_block(const Supernodes& f, const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Ref<Eigen::MatrixXd> X,
                 Eigen::Index first) {
    const int given = static_cast<int>(std::min<Eigen::Index>(width, B.cols() - first));
    double size[width];
    for (int k = 0; k < given; ++k) {
        size[k] = width > 1 ? largest_entry(B.col(first + k)) : 1;
        if (!(size[k] > 0)) size[k] = 1;
    }
    std::vector<Number<width>> x((static_cast<std::size_t>(f.size) + f.outside.size()) * width, 0);
    for_blocks(f.size, rows_at_once, [&](int begin, int end) {
        for (int i = begin; i < end; ++i)
            for (int k = 0; k < given; ++k)
                x[static_cast<std::size_t>(i) * width + k] =
                    static_cast<Number<width>>(B(f.permutation[i], first + k) / size[k]);
    });
    substitute_all<width>(f, x.data());
    for_blocks(f.size, rows_at_once, [&](int begin, int end) {
        for (int i = begin; i < end; ++i)
            for (int k = 0; k < given; ++k)
                X(f.permutation[i], first + k) = size[k] * x[static_cast<std::size_t>(i) * width + k];
    });
}

}  // namespace

void Singles::take(void* doubles, std::size_t count) {
    auto* bytes = static_cast<unsigned char*>(doubles);
    for (std::size_t k = 0; k < count; ++k) {  // a single ends before the double that is read next
        double value;
        std::memcpy(&value, bytes + 8 * k, sizeof value);
        const auto single = static_cast<float>(value);
        std::memcpy(bytes + 4 * k, &single, sizeof single);
    }
    void* smaller = std::realloc(doubles, std::max<std::size_t>(4, 4 * count));
    values_.reset(static_cast<float*>(smaller ? smaller : doubles));
}

void Supernodes::solve(const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Ref<Eigen::MatrixXd> X) const {
    for (Eigen::Index first = 0; first < B.cols();) {
        const Eigen::Index left = B.cols() - first;
        if (left == 1)
            solve_block<1>(*this, B, X, first), first += 1;
        else if (left <= 4)
            solve_block<4>(*this, B, X, first), first += 4;
        else if (left <= 8)
            solve_block<8>(*this, B, X, first), first += 8;
        else
            solve_block<16>(*this, B, X, first), first += 16;
    }
}

}  // namespace strake
