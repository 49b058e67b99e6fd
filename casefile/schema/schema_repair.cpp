#include "casefile/schema/schema_parts.hpp"

namespace strake {
namespace {

Key flag(const char* path, const char* doc) { return {.path = path, .type = Type::flag, .doc = doc}; }

std::vector<Key> repair_keys() {
    return {
        {.path = "repair",
         .doc = "Repairs of the surface before anything else, as `strake repair` makes them. The run folder gets a "
                "list of every repair (start-repairs.csv) and the repaired surface."},
        flag("repair.all",
             "All repairs except joints and the removal of components: weld 1e-7%, cracks 1e-3%, holes up to 10% that "
             "do not lie "
             "in a symmetry plane."),
        {.path = "repair.weld",
         .type = Type::length,
         .doc = "Merge vertices that are at most this far apart.",
         .limits = not_negative},
        flag("repair.duplicates", "Remove triangles that have the same vertices as another one."),
        flag("repair.degenerate", "Remove triangles of zero area without opening the surface."),
        {.path = "repair.cracks",
         .type = Type::length,
         .doc = "Join open edges that are at most this far apart.",
         .limits = positive},
        flag("repair.orient", "Flip triangles until neighbors agree and closed parts face outward."),
        flag("repair.split", "Separate parts that share only a vertex or an edge."),
        {.path = "repair.holes",
         .type = Type::length,
         .doc = "Fill holes up to this size; all: of any size.",
         .limits = positive,
         .words = {"all"}},
        {.path = "repair.fill",
         .type = Type::word,
         .doc = "planar: fill without new vertices; smooth: refine the fill and continue the curvature around it.",
         .words = {"planar", "smooth"},
         .when = "holes|all"},
        {.path = "repair.joints",
         .type = Type::length,
         .doc = "Where parts pass through each other, halve edges until they are at most this long: joints then stay "
                "closed under motion to edge^2 / 8 times its curvature. The surface stays where it is; it has more "
                "vertices.",
         .limits = positive},
        {.path = "repair.components", .doc = "Connected components to keep."},
        {.path = "repair.components.largest",
         .type = Type::integer,
         .doc = "Number of components to keep, by area.",
         .limits = {.min = 1}},
        {.path = "repair.components.min_area",
         .type = Type::fraction,
         .doc = "Minimum share of the total area.",
         .limits = {.min = 0, .max = 1, .max_open = true}},
        {.path = "repair.components.min_triangles",
         .type = Type::integer,
         .doc = "Minimum number of triangles.",
         .limits = {.min = 1}},
        flag("repair.isolated", "Remove vertices that belong to no triangle."),
    };
}

std::vector<Key> remesh_keys() {
    return {
        {.path = "remesh",
         .doc = "Isotropic remeshing after the repair, with features kept, as `strake remesh` does it. The run folder "
                "gets the remeshed surface."},
        {.path = "remesh.edge_length",
         .type = Type::length,
         .doc = "Target edge length; auto: the mean edge length of the surface.",
         .fallback = "auto",
         .limits = positive,
         .words = {"auto"}},
        {.path = "remesh.angle",
         .type = Type::angle,
         .doc = "Dihedral angle above which an edge is a crease.",
         .fallback = "40deg",
         .limits = {.min = 0, .max = 90, .min_open = true}},
        {.path = "remesh.iterations",
         .type = Type::integer,
         .doc = "Number of iterations.",
         .fallback = "10",
         .limits = {.min = 1}},
        {.path = "remesh.curvature",
         .type = Type::length,
         .doc = "Maximum distance between an edge and the surface: shortens edges where the surface is curved.",
         .limits = positive},
        {.path = "remesh.shortest_edge",
         .type = Type::length,
         .doc = "Minimum edge length in curved places. Default: a tenth of edge_length.",
         .limits = positive},
        {.path = "remesh.gradation",
         .type = Type::number,
         .doc = "Maximum change of the edge length per unit distance.",
         .fallback = "0.3",
         .limits = {.min = 0, .max = 1, .min_open = true}},
    };
}

}  // namespace

std::vector<Key> repair_and_remesh_keys() { return in_order({repair_keys(), remesh_keys()}); }

}  // namespace strake
