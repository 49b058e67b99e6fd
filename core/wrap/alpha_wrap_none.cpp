// Of a build without the GPL part.
#include "core/error.hpp"
#include "core/wrap/alpha_wrap.hpp"

namespace strake {

bool has_alpha_wrap() { return false; }

TriMesh alpha_wrap(const TriMesh&, double, double, double) {
    throw InvalidInput(
        "wrap: this build has no alpha wrap, whose licence is the GPL (it was made with -DSTRAKE_GPL=OFF); "
        "displacement fields need no wrap: shell: none");
}

}  // namespace strake
