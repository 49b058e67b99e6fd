#include "core/remesh/remesh.hpp"

#include "core/error.hpp"
#include "core/remesh/passes.hpp"
#include "core/remesh/sizing.hpp"

#include <chrono>
#include <numbers>
#include <thread>

namespace strake {
namespace {

double E(const char*n,double d){const char*x=getenv(n);return x?atof(x):d;}
constexpr double radians = std::numbers::pi / 180;

void check(bool good, const char* field, double value, const char* limit) {
    if (!good) throw InvalidInput(text("remesh: ", field, " = ", value, " must be ", limit));
}

}  // namespace

void validate(const RemeshOptions& o) {
    check(o.edge_length >= 0 && std::isfinite(o.edge_length), "edge_length", o.edge_length, "> 0, or 0 for automatic");
    check(o.angle_deg > 0 && o.angle_deg <= 90, "angle_deg", o.angle_deg, "in (0, 90]");
    check(o.iterations >= 1 && o.iterations <= 1000, "iterations", o.iterations, "in [1, 1000]");
    check(o.chord_error >= 0 && std::isfinite(o.chord_error), "chord_error", o.chord_error, "> 0, or 0 for uniform");
    check(o.shortest_edge >= 0 && std::isfinite(o.shortest_edge), "shortest_edge", o.shortest_edge,
          "> 0, or 0 for automatic");
    check(o.gradation > 0 && o.gradation <= 1, "gradation", o.gradation, "in (0, 1]");
    check(o.turn_deg > 0 && o.turn_deg <= 90, "turn_deg", o.turn_deg, "in (0, 90]");
    check(o.max_triangles >= 4, "max_triangles", o.max_triangles, ">= 4");
    check(o.threads >= 0, "threads", o.threads, ">= 0");
}

RemeshResult remesh(const TriMesh& given, const RemeshOptions& options, const RemeshProgress& progress) {
    validate(options);
    const auto start = std::chrono::steady_clock::now();
    const BaseSurface base = base_surface(given, options.angle_deg * radians);
    RemeshResult result;
    result.edge_length = options.edge_length > 0 ? options.edge_length : base.mean_edge;
    const double wanted = base.area / (0.4330127 * result.edge_length * result.edge_length);
    if (!(wanted <= options.max_triangles))
        throw InvalidInput(text("remesh: an edge length of ", result.edge_length, " makes about ", wanted,
                                " triangles, more than ", options.max_triangles, "; choose a longer one"));
    WorkingMesh mesh = working_mesh(base);
    const double shortest = options.shortest_edge > 0 ? options.shortest_edge : 0.1 * result.edge_length;
    const Sizing sizing = sizing_of(base, result.edge_length, std::min(shortest, result.edge_length),
                                    options.gradation, options.chord_error);
    update_sizes(mesh, sizing);
    const double natural = E("NAT",25) * radians, turn = E("TURN",options.turn_deg) * radians;
    const int threads = options.threads > 0 ? options.threads : static_cast<int>(std::thread::hardware_concurrency());
    const Guard guard{0.9e-4 * base.diagonal, std::cos(natural), std::cos(turn), std::sin(turn), E("THIN",0)*base.diagonal, std::max(1, threads)};
    for (const double factor : {0.01, 0.1, 0.4}) collapse_short(mesh, guard, factor, 4.0 / 3);
    for (int i = 1; i <= options.iterations; ++i) {
        RemeshRecord record{};
        record.iteration = i;
        record.splits = split_long(mesh, 4.0 / 3);
        record.collapses = collapse_short(mesh, guard, 0.8, 4.0 / 3);
        mesh.compact();
        record.flips = flip_edges(mesh, guard);
        for(int k=0;k<E("SM",2);++k) record.largest_move = smooth(mesh, guard);
        if ((i < options.iterations - 1 && i >= E("N0",3) && note_thin_places(mesh, sizing, i >= E("N1",5)) > 0) || !sizing.on_base.empty()) update_sizes(mesh, sizing);
        record.triangles = mesh.num_triangles();
        record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        result.records.push_back(record);
        if (progress && !progress(record)) {
            result.cancelled = true;
            break;
        }
    }
    if(getenv("DBG")){int n=0; for(int t=0;t<mesh.num_triangles()&&n<8;++t){ if(!mesh.is_alive(t))continue; Facing f=facing(mesh,mesh.corner[3*t],mesh.corner[3*t+1],mesh.corner[3*t+2]); if(f.quality>.06)continue; ++n; fprintf(stderr,"t %d q %g dot %g:",t,f.quality,f.dot); for(int h=3*t;h<3*t+3;++h){int v=mesh.corner[h],ft=mesh.feature[h],g=mesh.twin[h]; double nd=-9; if(g>=0){int u=g/3; Facing e=facing(mesh,mesh.corner[3*u],mesh.corner[3*u+1],mesh.corner[3*u+2]); nd=e.normal.dot(f.normal);} fprintf(stderr," [v%d r%d val %d sz %.3g lim %.3g len %.3g f%d c%d s%.4g-%.4g nd %.3f]",v,(int)mesh.role[v],mesh.valence[v],mesh.size[v],mesh.limit[v],std::sqrt(mesh.length2(h)),ft,ft<0?-1:mesh.features[ft].curve,ft<0?0:mesh.features[ft].s[0],ft<0?0:mesh.features[ft].s[1],nd);} fprintf(stderr,"\n");}}
    for (const FeatureEdge& edge : mesh.features) {
        if (edge.kind == FeatureKind::crease) ++result.crease_edges;
        if (edge.kind == FeatureKind::boundary) ++result.boundary_edges;
        if (edge.kind == FeatureKind::border) ++result.border_edges;
        if (edge.kind == FeatureKind::kept) ++result.kept_edges;
    }
    for (const VertexRole role : mesh.role) result.corners += role == VertexRole::fixed;
    result.mesh = as_mesh(mesh, given.group_names);
    return result;
}

}  // namespace strake
