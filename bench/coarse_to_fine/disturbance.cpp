#include "bench/coarse_to_fine/disturbance.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <random>

namespace strake::evidence {
namespace {

/// FNV-1a over the bits of the coordinates: every shape has its own noise.
std::uint64_t hash_of(const Points& vertices, unsigned seed) {
    std::uint64_t hash = 14695981039346656037u ^ seed;
    for (const double c : vertices.reshaped()) hash = (hash ^ std::bit_cast<std::uint64_t>(c)) * 1099511628211u;
    return hash;
}

double uniform(std::mt19937_64& random) { return (static_cast<double>(random() >> 11) + 0.5) / 9007199254740992.0; }

}  // namespace

EvidenceProblem disturbed(EvidenceProblem evidence, const Disturbance& disturbance, std::shared_ptr<Truth> truth) {
    const std::string objective = evidence.problem.objective;
    const std::uint64_t at_start = hash_of(evidence.problem.surface.vertices, disturbance.seed);
    for (Quantity& quantity : evidence.problem.quantities) {
        const auto named = std::ranges::find(quantity.names, objective);
        if (named == quantity.names.end()) continue;
        quantity.failing_shortens_step = true;
        const auto value = static_cast<std::size_t>(named - quantity.names.begin());
        quantity.evaluate = [=, evaluate = quantity.evaluate](const QuantityRequest& request) {
            const std::uint64_t hash = hash_of(request.surface.vertices, disturbance.seed);
            std::mt19937_64 random(hash);
            if (uniform(random) < disturbance.failures && hash != at_start)
                return QuantityResult{.values = {}, .dJ_dv = {}, .failure = Failure{"exit", "the solver has failed"}};
            QuantityResult result = evaluate(request);
            if (result.failure) return result;
            const double radius = std::sqrt(-2 * std::log(uniform(random)));
            const double exact = result.values[value];
            result.values[value] += disturbance.noise * radius * std::cos(2 * std::numbers::pi * uniform(random));
            (*truth)[result.values[value]] = exact;
            return result;
        };
    }
    return evidence;
}

}  // namespace strake::evidence
