#include "cases/geometry/closed_body.hpp"
#include "cases/geometry/dirty_body.hpp"
#include "cases/geometry/lifting_body.hpp"
#include "cases/geometry/slender_body.hpp"
#include "cases/geometry/waverider.hpp"
#include "cases/geometry/wing.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>

namespace {

using strake::TriMesh;

/// NACA 0012 of aspect ratio 2 with cells about as wide as the mean panel.
TriMesh naca_wing_of(int triangles) {
    const int panels = std::max(4, static_cast<int>(std::lround(std::sqrt(triangles / 8.0))));
    return strake::example::naca_wing(0.12, panels, 2 * panels, 2.0);
}

struct Kind {
    int triangles;
    TriMesh (*make)(int triangles);
};
/// What has to stay inside of the nacelle: a drum of round edges.
TriMesh engine(int triangles) {
    TriMesh mesh = strake::example::superellipsoid(triangles, {{1.1, 0.45, 0.45}, 4});
    mesh.vertices.col(0).array() += 2.1;
    return mesh;
}

const std::map<std::string, Kind> kinds{
    {"wing", {22'000, [](int n) { return strake::example::wing(n); }}},
    {"lifting_body", {30'000, [](int n) { return strake::example::lifting_body(n); }}},
    {"bluff_body", {5'000, [](int n) { return strake::example::superellipsoid(n); }}},
    {"ellipsoid",
     {5'000,
      [](int n) {
          return strake::example::superellipsoid(n, {{0.5, 0.1, 0.1}, 2});
      }}},
    {"naca0012", {10'000, naca_wing_of}},
    {"nacelle",
     {5'000,
      [](int n) {
          return strake::example::tube(n, {4, 0.7, 0.7});
      }}},
    {"engine", {2'000, engine}},
    {"winged_vehicle",
     {100'000, [](int n) { return strake::example::lifting_body(n, strake::example::winged_vehicle()); }}},
    {"waverider", {100'000, [](int n) { return strake::example::waverider(n); }}},
    {"wavy_body", {6'000, [](int n) { return strake::example::wavy_body(n); }}},
};

std::string dirty_kinds() {
    std::string words;
    for (const std::string& kind : strake::example::dirty_body_kinds()) words += (words.empty() ? "" : ", ") + kind;
    return words;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Makes an example surface from its definition", "make_surface"};
    std::string name, file;
    int triangles = 0;
    unsigned seed = 1;
    std::vector<std::string> names = strake::example::dirty_body_kinds();
    for (const auto& [kind, made] : kinds) names.push_back(kind);
    app.add_option("surface", name,
                   "wing (half model, open at y = 0), lifting_body, bluff_body, ellipsoid, wavy_body, nacelle, engine, "
                   "winged_vehicle, waverider (closed; cells of the last one crowd towards its edges), naca0012 (open "
                   "ends); and of a fixed size: " +
                       dirty_kinds())
        ->required()
        ->check(CLI::IsMember(names));
    app.add_option("--triangles", triangles,
                   "wanted number; defaults: wing 22000, lifting_body 30000, naca0012 10000, wavy_body 6000, engine "
                   "2000, winged_vehicle and waverider 100000, others 5000")
        ->check(CLI::Range(1, 5'000'000));
    app.add_option("--seed", seed, "of the bodies of a fixed size (default: 1)");
    app.add_option("-o,--out", file, "surface file: .stl .obj .ply .off .tri")->required();
    CLI11_PARSE(app, argc, argv);
    try {
        const auto kind = kinds.find(name);
        const TriMesh mesh = kind == kinds.end()
                                 ? strake::example::dirty_body(name, seed)
                                 : kind->second.make(triangles > 0 ? triangles : kind->second.triangles);
        strake::write_surface(file, mesh, strake::format_of(file));
        std::fprintf(stderr, "%s: %d vertices, %d triangles\n", file.c_str(), mesh.num_vertices(),
                     mesh.num_triangles());
        return 0;
    } catch (const strake::OutputError& e) {
        std::fprintf(stderr, "make_surface: %s\n", e.what());
        return 4;
    } catch (const std::invalid_argument& e) {
        std::fprintf(stderr, "make_surface: %s\n", e.what());
        return 2;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "make_surface: %s\n", e.what());
        return 1;
    }
}
