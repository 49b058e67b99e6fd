#include "cases/geometry/business_jet.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

/// The business jet with all of its bad triangles, as `make_surface` makes the other examples.
int main(int argc, char** argv) {
    CLI::App app{"Makes a business jet as it comes out of a converter: slivers, needles and caps", "make_jet"};
    std::string file;
    int triangles = 93'000;
    app.add_option("--triangles", triangles, "wanted number; default 93000")->check(CLI::Range(5'000, 1'000'000));
    app.add_option("-o,--out", file, "surface file: .stl .obj .ply .off .tri")->required();
    CLI11_PARSE(app, argc, argv);
    try {
        const strake::TriMesh mesh = strake::example::business_jet(triangles);
        strake::write_surface(file, mesh, strake::format_of(file));
        std::fprintf(stderr, "%s: %d vertices, %d triangles\n", file.c_str(), mesh.num_vertices(),
                     mesh.num_triangles());
        return 0;
    } catch (const strake::OutputError& e) {
        std::fprintf(stderr, "make_jet: %s\n", e.what());
        return 4;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "make_jet: %s\n", e.what());
        return 1;
    }
}
