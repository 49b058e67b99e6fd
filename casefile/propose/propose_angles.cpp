#include "casefile/propose/propose_parts.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/segmentation.hpp"

#include <cctype>
#include <cmath>
#include <fstream>
#include <numbers>

namespace strake::proposing {

CreaseAngles crease_angles(const TriMesh& mesh, const Adjacency& adjacent) {
    const Points normal = triangle_normals(mesh);
    CreaseAngles found;
    found.limits_deg = {0, 5, 10, 20, 30, 40, 60, 90, 180};
    found.shares.assign(found.limits_deg.size() - 1, 0.0);
    std::vector<double> by_degree(181, 0.0);
    double total = 0;
    for (int e = 0; e < adjacent.num_edges(); ++e) {
        if (!adjacent.is_regular(e)) continue;
        const auto [a, b] = adjacent.edges[e];
        const double length = (mesh.vertices.row(a) - mesh.vertices.row(b)).norm();
        const double angle =
            dihedral(normal.row(adjacent.edge_triangles[e][0]), normal.row(adjacent.edge_triangles[e][1])) * 180 /
            std::numbers::pi;
        total += length;
        by_degree[static_cast<int>(angle)] += length;
        std::size_t bin = 0;
        while (bin + 2 < found.limits_deg.size() && angle >= found.limits_deg[bin + 1]) ++bin;
        found.shares[bin] += length;
    }
    for (double& share : found.shares) share = total > 0 ? share / total : 0;
    // The emptiest interval; among equally empty ones the nearest to 40 degrees.
    double smallest = std::numeric_limits<double>::infinity();
    for (const int at :
         {40, 39, 41, 38, 42, 37, 43, 36, 44, 35, 45, 34, 46, 33, 47, 32, 48, 31, 49, 30, 50, 29, 28, 27, 26, 25}) {
        double sum = 0;
        for (int k = at - 3; k < at + 3; ++k) sum += by_degree[k];
        if (sum < smallest - 1e-3 * total) smallest = sum, found.sharp_deg = at;
    }
    for (const double angle : {60.0, 40.0, 20.0, 10.0})
        found.patches.emplace_back(
            angle,
            static_cast<int>(segment(mesh, adjacent, {angle}, {.min_patch_percent = 0.1}).levels[1].patches.size()));
    return found;
}

std::string stated_units(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::string head(4096, '\0');
    in.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(in.gcount()));
    for (char& c : head) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    for (std::size_t at = 0; (at = head.find("unit", at)) != std::string::npos; ++at) {
        std::size_t k = at + 4;
        if (k < head.size() && head[k] == 's') ++k;
        const std::size_t gap = k;
        while (k < head.size() && k - gap < 4 && (head[k] == ' ' || head[k] == ':' || head[k] == '=' || head[k] == '"'))
            ++k;
        if (k == gap) continue;
        std::string word;
        while (k < head.size() && std::isalpha(static_cast<unsigned char>(head[k])) && word.size() < 12)
            word += head[k++];
        for (const auto& [names, unit] : std::vector<std::pair<std::vector<std::string>, std::string>>{
                 {{"m", "meter", "meters", "metre", "metres"}, "m"},
                 {{"mm", "millimeter", "millimeters", "millimetre"}, "mm"},
                 {{"cm", "centimeter", "centimeters", "centimetre"}, "cm"},
                 {{"um", "micrometer", "micron"}, "um"},
                 {{"in", "inch", "inches"}, "in"},
                 {{"ft", "foot", "feet"}, "ft"}})
            for (const std::string& name : names)
                if (word == name) return unit;
    }
    return "";
}

}  // namespace strake::proposing
