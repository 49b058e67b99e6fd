#pragma once
#include "core/error.hpp"
#include "objectives/quantity.hpp"
#include "optimize/journal.hpp"

namespace strake {

/// What `measure` gives; an exception that a quantity may throw is its failure.
template <class Measure>
QuantityResult or_failure(const Measure& measure) {
    try {
        return measure();
    } catch (const OutputError&) {
        throw;
    } catch (const ReplayMismatch&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        QuantityResult failed;
        failed.failure = Failure{"exception", e.what()};
        return failed;
    }
}

}  // namespace strake
