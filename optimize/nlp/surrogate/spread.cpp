#include "optimize/nlp/surrogate/spread.hpp"

#include "core/error.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <random>
#include <vector>

namespace strake {
namespace {

constexpr int num_bits = 32;
constexpr int max_dimensions = 1000;
constexpr int candidates = 24;  ///< of the initial numbers of a coordinate
constexpr int compared = 24;    ///< coordinates before it, with which pairs are to be even
using Directions = std::array<std::uint32_t, num_bits>;

/// Polynomials over the integers modulo 2: coefficients as bits, the constant first. The remainder by `polynomial`.
std::uint64_t remainder(std::uint64_t p, std::uint32_t polynomial, int degree) {
    for (int k = 2 * degree; k >= degree; --k)
        if (p >> k & 1) p ^= std::uint64_t(polynomial) << (k - degree);
    return p;
}

std::uint64_t product(std::uint64_t a, std::uint64_t b, std::uint32_t polynomial, int degree) {
    std::uint64_t sum = 0;
    for (int k = 0; k < degree; ++k)
        if (b >> k & 1) sum ^= a << k;
    return remainder(sum, polynomial, degree);
}

/// t^exponent modulo the polynomial.
std::uint64_t power(std::uint32_t exponent, std::uint32_t polynomial, int degree) {
    std::uint64_t result = 1, base = remainder(2, polynomial, degree);
    for (; exponent > 0; exponent >>= 1, base = product(base, base, polynomial, degree))
        if (exponent & 1) result = product(result, base, polynomial, degree);
    return result;
}

bool is_primitive(std::uint32_t polynomial, int degree) {
    const std::uint32_t order = (1U << degree) - 1;
    if (power(order, polynomial, degree) != 1) return false;
    std::uint32_t rest = order;
    for (std::uint32_t prime = 2; prime <= rest; ++prime) {
        if (rest % prime != 0) continue;
        if (power(order / prime, polynomial, degree) == 1) return false;
        while (rest % prime == 0) rest /= prime;
    }
    return true;
}

struct Polynomial {
    std::uint32_t bits = 0;
    int degree = 0;
};

std::vector<Polynomial> primitive_polynomials(int count) {
    std::vector<Polynomial> found;
    for (int degree = 1; static_cast<int>(found.size()) < count; ++degree)
        for (std::uint32_t p = (1U << degree) + 1; p < (2U << degree); p += 2)
            if (static_cast<int>(found.size()) < count && is_primitive(p, degree)) found.push_back({p, degree});
    return found;
}

/// By the recurrence of the polynomial from initial numbers (Bratley and Fox 1988).
Directions directions(const Polynomial& p, const std::vector<std::uint32_t>& initial) {
    Directions v{};
    for (int i = 0; i < num_bits; ++i) {
        if (i < p.degree) {
            v[i] = initial[static_cast<std::size_t>(i)] << (num_bits - 1 - i);
            continue;
        }
        v[i] = v[i - p.degree] ^ (v[i - p.degree] >> p.degree);
        for (int k = 1; k < p.degree; ++k)
            if (p.bits >> (p.degree - k) & 1) v[i] ^= v[i - k];
    }
    return v;
}

/// Number of leading digits, together at most `digits`, in which two coordinates are not independent: 0 is best.
int dependence(const Directions& a, const Directions& b, int digits) {
    int worst = 0;
    for (int first = 0; first <= digits; ++first) {
        std::vector<std::uint32_t> rows;  // of the generating matrices, one bit a column
        const auto add = [&](const Directions& v, int count) {
            for (int r = 0; r < count; ++r) {
                std::uint32_t row = 0;
                for (int c = 0; c < digits; ++c) row |= (v[c] >> (num_bits - 1 - r) & 1U) << c;
                rows.push_back(row);
            }
        };
        add(a, first);
        add(b, digits - first);
        int rank = 0;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const std::uint32_t pivot = rows[i];
            if (pivot == 0) continue;
            ++rank;
            const std::uint32_t low = pivot & (~pivot + 1);
            for (std::size_t k = i + 1; k < rows.size(); ++k)
                if (rows[k] & low) rows[k] ^= pivot;
        }
        worst += digits - rank;
    }
    return worst;
}

/// The first halves of two coordinates are the same among 2^columns points: their correlation is 3/4.
bool has_equal_halves(const Directions& a, const Directions& b, int columns) {
    for (int c = 0; c < columns; ++c)
        if ((a[c] ^ b[c]) >> (num_bits - 1)) return false;
    return true;
}

/// How uneven pairs of the candidate with coordinates before it are.
long unevenness(const std::vector<Directions>& before, const Directions& candidate) {
    long sum = 0;
    const int n = static_cast<int>(before.size());
    for (const Directions& other : before)
        for (const int columns : {6, 8}) sum += has_equal_halves(other, candidate, columns) ? 1000 : 0;
    for (int j = std::max(0, n - compared); j < n; ++j)
        for (const int digits : {4, 6, 8}) sum += dependence(before[j], candidate, digits);
    return sum;
}

std::vector<Directions> all_directions(int dimensions) {
    Directions first{};
    for (int i = 0; i < num_bits; ++i) first[i] = 1U << (num_bits - 1 - i);
    std::vector<Directions> all{first};
    std::mt19937 random(1);
    for (const Polynomial& p : primitive_polynomials(dimensions - 1)) {
        Directions best{};
        long lowest = -1;
        for (int k = 0; k < candidates; ++k) {
            std::vector<std::uint32_t> initial;
            for (int i = 0; i < p.degree; ++i) initial.push_back((random() & ((2U << i) - 1)) | 1U);
            const Directions candidate = directions(p, initial);
            const long sum = unevenness(all, candidate);
            if (lowest < 0 || sum < lowest) lowest = sum, best = candidate;
        }
        all.push_back(best);
    }
    return all;
}

void check(int first, int count, int dimensions) {
    if (first < 0 || count < 0 || dimensions < 1 || dimensions > max_dimensions)
        throw InvalidInput(text("spread points: ", count, " from number ", first, " on in ", dimensions,
                                " dimensions (at least 1, at most ", max_dimensions, ")"));
}

/// By hand: the standard's distributions differ from library to library.
double share(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

}  // namespace

Eigen::MatrixXd sobol_points(int first, int count, int dimensions) {
    check(first, count, dimensions);
    const std::vector<Directions> v = all_directions(dimensions);
    Eigen::MatrixXd points(count, dimensions);
    for (int i = 0; i < count; ++i) {
        const auto number = static_cast<std::uint32_t>(first + i), gray = number ^ (number >> 1);
        for (int j = 0; j < dimensions; ++j) {
            std::uint32_t bits = 0;
            for (std::uint32_t rest = gray; rest != 0; rest &= rest - 1)
                bits ^= v[static_cast<std::size_t>(j)][static_cast<std::size_t>(std::countr_zero(rest))];
            points(i, j) = (static_cast<double>(bits) + 0.5) * 0x1.0p-32;
        }
    }
    return points;
}

Eigen::MatrixXd latin_hypercube(int count, int dimensions, unsigned seed) {
    check(0, count, dimensions);
    std::seed_seq words{seed, 77U};
    std::mt19937_64 random(words);
    Eigen::MatrixXd points(count, dimensions);
    for (int j = 0; j < dimensions; ++j) {
        std::vector<int> part(static_cast<std::size_t>(count));
        for (int i = 0; i < count; ++i) part[static_cast<std::size_t>(i)] = i;
        for (int i = count - 1; i > 0; --i)
            std::swap(part[static_cast<std::size_t>(i)], part[static_cast<std::size_t>(share(random) * (i + 1))]);
        for (int i = 0; i < count; ++i) points(i, j) = (part[static_cast<std::size_t>(i)] + share(random)) / count;
    }
    return points;
}

}  // namespace strake
