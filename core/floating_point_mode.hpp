#pragma once
#if defined(__x86_64__)
#include <xmmintrin.h>
#else
#include <cfenv>
#endif

namespace strake {

/// Rounding and the treatment of subnormal numbers, as they were: libraries of others may change them while this lives.
class KeepFloatingPointMode {
public:
    KeepFloatingPointMode() = default;
    KeepFloatingPointMode(const KeepFloatingPointMode&) = delete;
    KeepFloatingPointMode& operator=(const KeepFloatingPointMode&) = delete;
#if defined(__x86_64__)
    ~KeepFloatingPointMode() { _mm_setcsr(mode_); }

private:
    unsigned mode_ = _mm_getcsr();
#else
    ~KeepFloatingPointMode() { std::fesetenv(&mode_); }

private:
    std::fenv_t mode_ = now();
    static std::fenv_t now() {
        std::fenv_t mode;
        std::fegetenv(&mode);
        return mode;
    }
#endif
};

}  // namespace strake
