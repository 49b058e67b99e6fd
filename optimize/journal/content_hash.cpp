#include "optimize/journal/content_hash.hpp"

#include "core/text/hash.hpp"

namespace strake {

std::string content_hash(std::string_view bytes) { return hash_digits(fnv1a(bytes)); }

std::string content_hash(const TriMesh& surface) {
    const auto bytes = [](const auto& matrix) {
        return std::string_view(reinterpret_cast<const char*>(matrix.data()),
                                sizeof(*matrix.data()) * static_cast<std::size_t>(matrix.size()));
    };
    return hash_digits(fnv1a(bytes(surface.triangles), fnv1a(bytes(surface.vertices))));
}

}  // namespace strake
