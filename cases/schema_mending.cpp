#include "cases/schema_parts.hpp"

namespace strake {
namespace {

Key flag(const char* path, const char* doc) { return {.path = path, .type = Type::flag, .doc = doc}; }

std::vector<Key> repair_keys() {
    return {
        {.path = "repair",
         .doc = "What is mended of the surface before anything else, as by `strake repair`; every single repair is "
                "written into the run's folder (start-repairs.csv), with the surface that it gives."},
        flag("repair.all",
             "Everything but dropping components: weld 1e-7%, cracks 1e-3%, holes up to 10% that are no "
             "symmetry plane."),
        {.path = "repair.weld",
         .type = Type::length,
         .doc = "Merge vertices at most this far apart.",
         .limits = not_negative},
        flag("repair.duplicates", "Remove triangles with the vertices of another one."),
        flag("repair.degenerate", "Remove triangles of no area without opening the surface."),
        {.path = "repair.cracks",
         .type = Type::length,
         .doc = "Join open edges at most this far apart.",
         .limits = positive},
        flag("repair.orient", "Turn triangles until neighbours agree; closed parts outward."),
        flag("repair.split", "Separate what meets in a vertex or an edge only."),
        {.path = "repair.holes",
         .type = Type::length,
         .doc = "Close open loops at most this far across; all: whatever their size.",
         .limits = positive,
         .words = {"all"}},
        {.path = "repair.fill",
         .type = Type::word,
         .doc = "Fills without new vertices, or refined and curved like what is around.",
         .words = {"planar", "smooth"},
         .when = "holes|all"},
        {.path = "repair.components", .doc = "Which connected pieces stay."},
        {.path = "repair.components.largest",
         .type = Type::integer,
         .doc = "So many of the largest area.",
         .limits = {.min = 1}},
        {.path = "repair.components.min_area",
         .type = Type::fraction,
         .doc = "Those with at least this share of the area.",
         .limits = {.min = 0, .max = 1, .max_open = true}},
        {.path = "repair.components.min_triangles",
         .type = Type::integer,
         .doc = "Those with at least so many triangles.",
         .limits = {.min = 1}},
        flag("repair.isolated", "Remove vertices that no triangle uses."),
    };
}

std::vector<Key> remesh_keys() {
    return {
        {.path = "remesh",
         .doc = "Triangles of even size on the same shape, features kept, after the repair, as by `strake remesh`; the "
                "surface that it gives is written into the run's folder."},
        {.path = "remesh.edge_length",
         .type = Type::length,
         .doc = "Wanted length of the edges; without it the mean of the surface.",
         .limits = positive},
        {.path = "remesh.angle",
         .type = Type::angle,
         .doc = "Angle between faces that makes an edge a crease.",
         .fallback = "40deg",
         .limits = {.min = 0, .max = 90, .min_open = true}},
        {.path = "remesh.iterations", .type = Type::integer, .doc = "Rounds.", .fallback = "10", .limits = {.min = 1}},
        {.path = "remesh.curvature",
         .type = Type::length,
         .doc = "Shorter edges where the surface bends: how far an edge may be from it.",
         .limits = positive},
        {.path = "remesh.shortest_edge",
         .type = Type::length,
         .doc = "Limit for shorter edges; without it a tenth of edge_length.",
         .limits = positive},
        {.path = "remesh.gradation",
         .type = Type::number,
         .doc = "How fast lengths may change with the distance.",
         .fallback = "0.3",
         .limits = {.min = 0, .max = 1, .min_open = true}},
    };
}

}  // namespace

std::vector<Key> mending_keys() {
    std::vector<Key> keys = repair_keys();
    for (Key& key : remesh_keys()) keys.push_back(std::move(key));
    return keys;
}

}  // namespace strake
