#include "optimize/nlp/sqp/iterate.hpp"

#include "optimize/nlp/sqp/trust_region.hpp"

namespace strake {

bool SqpIterate::has_expensive_gradient() const {
    return program.differences && program.differences->objective && x.size() >= trust_region.expensive_gradient;
}

}  // namespace strake
