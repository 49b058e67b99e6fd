#pragma once
#include <Eigen/Core>

/// Four numbers in one vector type: the same sums on machines with registers for four or two doubles.
namespace strake {

#define STRAKE_INLINE inline __attribute__((always_inline))

using Two = double __attribute__((vector_size(16)));
using Four = double __attribute__((vector_size(32)));
using FourSingles = float __attribute__((vector_size(16)));
using EightSingles = float __attribute__((vector_size(32)));

/// Consecutive numbers in an array: packed, because their address may be unaligned.
template <class Vector>
struct __attribute__((packed, may_alias)) Loose {
    Vector lanes;
};

template <class Vector, class Number>
STRAKE_INLINE const Loose<Vector>& loose(const Number* at) {
    return *reinterpret_cast<const Loose<Vector>*>(at);
}
template <class Vector, class Number>
STRAKE_INLINE Loose<Vector>& loose(Number* at) {
    return *reinterpret_cast<Loose<Vector>*>(at);
}
STRAKE_INLINE const Loose<Four>& four(const double* at) { return loose<Four>(at); }
STRAKE_INLINE Loose<Four>& four(double* at) { return loose<Four>(at); }
STRAKE_INLINE double sum(const Four& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

/// Runs `work`, an always-inlined function, with the widest registers of the machine.
#if defined(__x86_64__)
template <class Work>
__attribute__((target("avx2"), noinline)) void run_wide(const Work& work) {
    work();
}
#endif
template <class Work>
void run_lanes(const Work& work) {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) return run_wide(work);
#endif
    work();
}

}  // namespace strake
