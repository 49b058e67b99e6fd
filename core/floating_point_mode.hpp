#pragma once
#include <cfenv>

namespace strake {

/// Rounding and the treatment of subnormal numbers, as they were: libraries of others may change them while this lives.
class KeepFloatingPointMode {
public:
    KeepFloatingPointMode() = default;
    KeepFloatingPointMode(const KeepFloatingPointMode&) = delete;
    KeepFloatingPointMode& operator=(const KeepFloatingPointMode&) = delete;
#if defined(__x86_64__)
    ~KeepFloatingPointMode() { __builtin_ia32_ldmxcsr(mode_); }

private:
    unsigned mode_ = __builtin_ia32_stmxcsr();
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
