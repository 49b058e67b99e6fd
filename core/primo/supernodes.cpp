#include "core/primo/supernodes.hpp"

#include <algorithm>
#include <cstring>

namespace strake {
namespace {

#define STRAKE_INLINE inline __attribute__((always_inline))

// Four entries of the factor, and as many numbers to work with. Vectors are lanes beside each other: the same sums,
// whether the machine has registers for four doubles or for two.
using Four = double __attribute__((vector_size(32)));
using FourSingles = float __attribute__((vector_size(16)));

STRAKE_INLINE void load(Four& to, const float* from) {
    FourSingles singles;
    std::memcpy(&singles, from, sizeof singles);
    to = __builtin_convertvector(singles, Four);
}

/// y_i -= sum of four columns L_ij x_j, one right-hand side.
STRAKE_INLINE void subtract_columns(const float* L, long height, int rows, const double* x, double* y) {
    const float *a = L, *b = L + height, *c = L + 2 * height, *d = L + 3 * height;
    int i = 0;
    for (; i + 4 <= rows; i += 4) {
        Four la, lb, lc, ld, sum;
        load(la, a + i), load(lb, b + i), load(lc, c + i), load(ld, d + i);
        std::memcpy(&sum, y + i, sizeof sum);
        sum -= (la * x[0] + lb * x[1]) + (lc * x[2] + ld * x[3]);
        std::memcpy(y + i, &sum, sizeof sum);
    }
    for (; i < rows; ++i)
        y[i] -= (static_cast<double>(a[i]) * x[0] + static_cast<double>(b[i]) * x[1]) +
                (static_cast<double>(c[i]) * x[2] + static_cast<double>(d[i]) * x[3]);
}

/// x_j -= sum over i of L_ij y_i for four columns j.
STRAKE_INLINE void subtract_rows(const float* L, long height, int rows, const double* y, double* x) {
    Four sum[4] = {};
    int i = 0;
    for (; i + 4 <= rows; i += 4) {
        Four factor, other;
        std::memcpy(&other, y + i, sizeof other);
        for (int j = 0; j < 4; ++j) {
            load(factor, L + j * height + i);
            sum[j] += factor * other;
        }
    }
    for (int j = 0; j < 4; ++j) {
        double rest = 0;
        for (int k = i; k < rows; ++k) rest += static_cast<double>(L[j * height + k]) * y[k];
        x[j] -= ((sum[j][0] + sum[j][1]) + (sum[j][2] + sum[j][3])) + rest;
    }
}

template <int width>
struct RowOf;  // spelled out: the attribute does not take a parameter of a template
template <>
struct RowOf<4> {
    using Type = double __attribute__((vector_size(32)));
};
template <>
struct RowOf<8> {
    using Type = double __attribute__((vector_size(64)));
};

/// The same for `width` right-hand sides that lie beside each other.
template <int width>
struct Beside {
    using Row = typename RowOf<width>::Type;
    static_assert(sizeof(Row) == 8 * width);

    static STRAKE_INLINE void subtract_columns(const float* L, long height, int rows, const double* x, double* y) {
        Row from[4];
        std::memcpy(from, x, sizeof from);
        for (int i = 0; i < rows; ++i) {
            Row sum;
            std::memcpy(&sum, y + static_cast<long>(i) * width, sizeof sum);
            sum -=
                (from[0] * static_cast<double>(L[i]) + from[1] * static_cast<double>(L[height + i])) +
                (from[2] * static_cast<double>(L[2 * height + i]) + from[3] * static_cast<double>(L[3 * height + i]));
            std::memcpy(y + static_cast<long>(i) * width, &sum, sizeof sum);
        }
    }

    static STRAKE_INLINE void subtract_rows(const float* L, long height, int rows, const double* y, double* x) {
        Row to[4];
        std::memcpy(to, x, sizeof to);
        for (int i = 0; i < rows; ++i) {
            Row other;
            std::memcpy(&other, y + static_cast<long>(i) * width, sizeof other);
            for (int j = 0; j < 4; ++j) to[j] -= other * static_cast<double>(L[j * height + i]);
        }
        std::memcpy(x, to, sizeof to);
    }
};
template <>
struct Beside<1> {
    static STRAKE_INLINE void subtract_columns(const float* L, long height, int rows, const double* x, double* y) {
        strake::subtract_columns(L, height, rows, x, y);
    }
    static STRAKE_INLINE void subtract_rows(const float* L, long height, int rows, const double* y, double* x) {
        strake::subtract_rows(L, height, rows, y, x);
    }
};

/// `local` holds the rows of the supernode: its own, known so far, then zeros that collect what goes to rows below.
template <int width>
STRAKE_INLINE void forward(const float* L, int columns, int rows, double* local) {
    for (int j = 0; j < columns;) {
        const int panel = columns - j >= 4 ? 4 : 1;
        for (int p = j; p < j + panel; ++p) {
            const double inverse = 1 / static_cast<double>(L[static_cast<long>(p) * rows + p]);
            for (int k = 0; k < width; ++k) local[static_cast<long>(p) * width + k] *= inverse;
            for (int i = p + 1; i < (panel == 1 ? rows : j + panel); ++i)
                for (int k = 0; k < width; ++k)
                    local[static_cast<long>(i) * width + k] -= static_cast<double>(L[static_cast<long>(p) * rows + i]) *
                                                               local[static_cast<long>(p) * width + k];
        }
        if (panel == 4)
            Beside<width>::subtract_columns(L + static_cast<long>(j) * rows + j + 4, rows, rows - j - 4,
                                            local + static_cast<long>(j) * width,
                                            local + static_cast<long>(j + 4) * width);
        j += panel;
    }
}

/// `local` holds the solution in the rows below and the right-hand side in the supernode's own.
template <int width>
STRAKE_INLINE void backward(const float* L, int columns, int rows, double* local) {
    for (int end = columns; end > 0;) {
        const int panel = end % 4 == 0 ? 4 : 1, j = end - panel;  // the panels of `forward`, from behind
        if (panel == 4)
            Beside<width>::subtract_rows(L + static_cast<long>(j) * rows + j + 4, rows, rows - j - 4,
                                         local + static_cast<long>(j + 4) * width,
                                         local + static_cast<long>(j) * width);
        for (int p = end - 1; p >= j; --p) {
            for (int i = p + 1; i < (panel == 1 ? rows : end); ++i)
                for (int k = 0; k < width; ++k)
                    local[static_cast<long>(p) * width + k] -= static_cast<double>(L[static_cast<long>(p) * rows + i]) *
                                                               local[static_cast<long>(i) * width + k];
            const double inverse = 1 / static_cast<double>(L[static_cast<long>(p) * rows + p]);
            for (int k = 0; k < width; ++k) local[static_cast<long>(p) * width + k] *= inverse;
        }
        end = j;
    }
}

template <int width>
STRAKE_INLINE void substitute(const Supernodes& f, double* x, double* local) {
    const int last = f.num_supernodes();
    for (int s = 0; s < last; ++s) {
        const int column = f.first_column[s], columns = f.first_column[s + 1] - column;
        const int* row = f.row.data() + f.first_row[s];
        const int rows = static_cast<int>(f.first_row[s + 1] - f.first_row[s]);
        std::memcpy(local, x + static_cast<long>(column) * width, sizeof(double) * columns * width);
        std::memset(local + static_cast<long>(columns) * width, 0, sizeof(double) * (rows - columns) * width);
        forward<width>(f.entry.data() + f.first_entry[s], columns, rows, local);
        std::memcpy(x + static_cast<long>(column) * width, local, sizeof(double) * columns * width);
        for (int i = columns; i < rows; ++i)
            for (int k = 0; k < width; ++k)
                x[static_cast<long>(row[i]) * width + k] += local[static_cast<long>(i) * width + k];
    }
    for (int s = last - 1; s >= 0; --s) {
        const int column = f.first_column[s], columns = f.first_column[s + 1] - column;
        const int* row = f.row.data() + f.first_row[s];
        const int rows = static_cast<int>(f.first_row[s + 1] - f.first_row[s]);
        std::memcpy(local, x + static_cast<long>(column) * width, sizeof(double) * columns * width);
        for (int i = columns; i < rows; ++i)
            for (int k = 0; k < width; ++k)
                local[static_cast<long>(i) * width + k] = x[static_cast<long>(row[i]) * width + k];
        backward<width>(f.entry.data() + f.first_entry[s], columns, rows, local);
        std::memcpy(x + static_cast<long>(column) * width, local, sizeof(double) * columns * width);
    }
}

#if defined(__x86_64__)
template <int width>
__attribute__((target("avx2"))) void substitute_wide(const Supernodes& f, double* x, double* local) {
    substitute<width>(f, x, local);
}
#endif
template <int width>
void substitute_plain(const Supernodes& f, double* x, double* local) {
    substitute<width>(f, x, local);
}

/// Columns [first, first + width) of B to X; those beyond the last are zeros.
template <int width>
void solve_block(const Supernodes& f, const Eigen::MatrixXd& B, Eigen::MatrixXd& X, Eigen::Index first) {
    const int given = static_cast<int>(std::min<Eigen::Index>(width, B.cols() - first));
    std::vector<double> x(static_cast<std::size_t>(f.size) * width, 0.0),
        local(static_cast<std::size_t>(f.most_rows) * width);
    for (int k = 0; k < given; ++k)
        for (int i = 0; i < f.size; ++i) x[static_cast<std::size_t>(i) * width + k] = B(f.permutation[i], first + k);
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2"))
        substitute_wide<width>(f, x.data(), local.data());
    else
#endif
        substitute_plain<width>(f, x.data(), local.data());
    for (int k = 0; k < given; ++k)
        for (int i = 0; i < f.size; ++i) X(f.permutation[i], first + k) = x[static_cast<std::size_t>(i) * width + k];
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

void Supernodes::solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) const {
    X.resize(B.rows(), B.cols());
    for (Eigen::Index first = 0; first < B.cols();) {
        const Eigen::Index left = B.cols() - first;
        if (left == 1)
            solve_block<1>(*this, B, X, first), first += 1;
        else if (left <= 4)
            solve_block<4>(*this, B, X, first), first += 4;
        else
            solve_block<8>(*this, B, X, first), first += 8;
    }
}

}  // namespace strake
