#pragma once
#include <Eigen/Core>

/// Four numbers beside each other: the same sums, whether the machine has registers for four doubles or for two.
namespace strake {

#define STRAKE_INLINE inline __attribute__((always_inline))

using Four = double __attribute__((vector_size(32)));
using LooseFour = double __attribute__((vector_size(32), aligned(8), may_alias));

STRAKE_INLINE const LooseFour& four(const double* at) { return *reinterpret_cast<const LooseFour*>(at); }
STRAKE_INLINE LooseFour& four(double* at) { return *reinterpret_cast<LooseFour*>(at); }
STRAKE_INLINE double sum(Four v) { return (v[0] + v[1]) + (v[2] + v[3]); }

/// Runs `work`, an always-inlined function, with the widest registers that the machine has.
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
