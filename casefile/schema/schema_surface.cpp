#include "casefile/schema/schema_parts.hpp"

namespace strake {
namespace {

std::vector<Key> file_keys() {
    return {
        {.path = "case",
         .type = Type::name,
         .doc = "Name of the case; the default output folder is named after it. Default: the name of the file without "
                "its extension, with '_' in place of characters that a name cannot hold."},
        {.path = "surface", .doc = "The surface to deform.", .required = true},
        {.path = "surface.file",
         .type = Type::file,
         .doc = "Triangulation: STL, OBJ, PLY, OFF, Cart3D .tri, legacy VTK, VTP, SU2, Gmsh .msh "
                "or NASTRAN (.nas, .bdf, .dat), optionally compressed (.gz).",
         .required = true},
        {.path = "surface.units",
         .type = Type::word,
         .doc = "Unit of the coordinates in the file. Required if any length in the case has a unit.",
         .words = {"m", "cm", "mm", "um", "in", "ft"}},
    };
}

/// Regions made of other regions, of neighbours and of directions.
std::vector<Key> made_region_keys() {
    return {
        {.path = "regions.*.grow", .doc = "A region and what lies around it, measured along edges."},
        {.path = "regions.*.grow.of",
         .type = Type::text,
         .doc = "Names joined by signs, as in the text of a region.",
         .required = true},
        {.path = "regions.*.grow.by",
         .type = Type::length,
         .doc = "Distance. Negative: the region shrinks, by growing the rest of the surface.",
         .required = true},
        {.path = "regions.*.flood", .doc = "All triangles that can be reached from one without crossing a crease."},
        {.path = "regions.*.flood.from",
         .type = Type::integer,
         .doc = "Triangle number in the surface file, counted from 0.",
         .required = true,
         .limits = not_negative},
        {.path = "regions.*.flood.from",
         .type = Type::list,
         .doc = "A point; the triangle nearest to it is the first.",
         .required = true,
         .element = Type::coordinate,
         .count = 3},
        {.path = "regions.*.flood.angle",
         .type = Type::angle,
         .doc = "Edges of a larger dihedral angle are not crossed, nor open edges.",
         .fallback = "30deg",
         .limits = {0, 180}},
        {.path = "regions.*.near", .doc = "All triangles near a region, those of the region included."},
        {.path = "regions.*.near.of",
         .type = Type::text,
         .doc = "Names joined by signs, as in the text of a region.",
         .required = true},
        {.path = "regions.*.near.within",
         .type = Type::length,
         .doc = "Maximum straight distance from the region.",
         .required = true,
         .limits = positive},
        {.path = "regions.*.facing",
         .type = Type::word,
         .doc = "All triangles whose normal points this way.",
         .words = {"+x", "-x", "+y", "-y", "+z", "-z"}},
        {.path = "regions.*.facing",
         .type = Type::list,
         .doc = "Any direction; its length has no effect.",
         .element = Type::number,
         .count = 3},
        {.path = "regions.*.within",
         .type = Type::angle,
         .doc = "The normal's angle to the direction must be smaller.",
         .fallback = "90deg",
         .limits = {0, 180, true},
         .when = "facing"},
        {.path = "regions.*.touch",
         .type = Type::word,
         .doc =
             "all: a triangle belongs to the region if all three vertices are inside; any: one point of it is enough "
             "(near: one vertex).",
         .fallback = "all",
         .words = {"all", "any"},
         .when = "box|sphere|plane|near"},
    };
}

std::vector<Key> region_keys() {
    return {
        {.path = "regions", .doc = "Named sets of triangles that other keys refer to.", .may_be_empty = true},
        {.path = "regions.*",
         .doc = "A region: exactly one of box, sphere, plane, solid, component, patch, triangles, grow, flood, near, "
                "facing, of."},
        {.path = "regions.*",
         .type = Type::text,
         .doc =
             "A region made of others: names joined by `+` (both), `-` (without) and `&` (what both hold, before the "
             "other two), with parentheses, blanks around the signs: `wing + body - nose`. A name is that of a "
             "region, a part of the surface file or a patch, in double quotes if it holds blanks; `all` is the whole "
             "surface unless a region is called so."},
        {.path = "regions.*.box",
         .type = Type::list,
         .doc = "Two opposite corners. A triangle belongs to the region if all three vertices are inside or on the "
                "border.",
         .element = Type::list,
         .count = 2},
        {.path = "regions.*.box[]",
         .type = Type::list,
         .doc = "A corner; the first has the smaller coordinates, the second the larger ones.",
         .element = Type::coordinate,
         .count = 3},
        {.path = "regions.*.sphere",
         .doc = "A triangle belongs to the region if all three vertices are inside the sphere or on it."},
        {.path = "regions.*.sphere.center",
         .type = Type::list,
         .doc = "Center.",
         .required = true,
         .element = Type::coordinate,
         .count = 3},
        {.path = "regions.*.sphere.radius",
         .type = Type::length,
         .doc = "Radius.",
         .required = true,
         .limits = positive},
        {.path = "regions.*.plane", .doc = "Half-space on one side of a plane; `side` selects the side."},
        {.path = "regions.*.plane.normal",
         .type = Type::list,
         .doc = "Normal; its length has no effect.",
         .required = true,
         .element = Type::number,
         .count = 3},
        {.path = "regions.*.plane.at",
         .type = Type::coordinate,
         .doc = "Distance of the plane from the origin along the unit normal.",
         .required = true},
        {.path = "regions.*.side",
         .type = Type::word,
         .doc = "plane (required): above is the side to which the normal points. of: upper and lower surface of the "
                "wing, by the triangles' normals; default both.",
         .required_when = "plane",
         .words = {"above", "below", "upper", "lower", "both"},
         .when = "plane|of"},
        {.path = "regions.*.solid",
         .type = Type::text,
         .doc = "Part named in the surface file: STL solid, OBJ group, Cart3D component, SU2 marker, Gmsh physical "
                "group, NASTRAN property."},
        {.path = "regions.*.component",
         .type = Type::integer,
         .doc = "Connected component of the surface, numbered from 0 in the order of the smallest triangle number.",
         .limits = not_negative},
        {.path = "regions.*.patch",
         .type = Type::text,
         .doc = "Patch of this name, on the finest level where it exists."},
        {.path = "regions.*.triangles",
         .type = Type::file,
         .doc = "Text file with triangle numbers of the surface file, one per line, counted from 0."},
    };
}

std::vector<Key> invariance_keys() {
    return {
        {.path = "invariance",
         .doc = "The kind of shape that every design keeps, up to round-off, by fields and by patches. Exactly one of "
                "extrude, revolve, cyclic. The start must be of the kind (to 1e-6 of the diagonal), and what is held."},
        {.path = "invariance.extrude",
         .type = Type::word,
         .doc = "The same section all along this axis, for example of a two-dimensional flow; nothing moves along it.",
         .words = {"x", "y", "z"}},
        {.path = "invariance.extrude",
         .type = Type::list,
         .doc = "An axis of any direction; its length has no effect.",
         .element = Type::number,
         .count = 3},
        {.path = "invariance.revolve",
         .type = Type::word,
         .doc = "A body of revolution about this axis; its vertices lie on rings.",
         .words = {"x", "y", "z"}},
        {.path = "invariance.revolve",
         .type = Type::list,
         .doc = "An axis of any direction; its length has no effect.",
         .element = Type::number,
         .count = 3},
        {.path = "invariance.cyclic",
         .type = Type::integer,
         .doc = "The same in so many sectors of a turn about `about`; their triangles are copies of each other.",
         .limits = {2, 10000}},
        {.path = "invariance.about", .type = Type::word, .doc = "Axis of cyclic.", .words = {"x", "y", "z"}},
        {.path = "invariance.about",
         .type = Type::list,
         .doc = "An axis of any direction; its length has no effect.",
         .element = Type::number,
         .count = 3},
        {.path = "invariance.through",
         .type = Type::list,
         .doc = "A point of the axis of revolve or cyclic. Default: the origin.",
         .element = Type::coordinate,
         .count = 3},
    };
}

std::vector<Key> held_keys() {
    return {
        {.path = "fixed",
         .type = Type::list,
         .doc = "Regions that do not move.",
         .element = Type::name,
         .may_be_empty = true},
        {.path = "hold",
         .type = Type::word,
         .doc = "What keeps the body in its place. fixed: the regions of `fixed`. point: one triangle near the middle, "
                "without `fixed`: loads bend the shell about it, and displacement fields neither move nor turn the "
                "body there. none: nothing; displacement fields neither move nor turn the body in the mean, and loads "
                "have nothing to act against (`variables: []`).",
         .fallback = "fixed",
         .words = {"fixed", "point", "none"}},
        {.path = "hold", .doc = "A point that keeps its place."},
        {.path = "hold.point",
         .type = Type::list,
         .doc = "The triangle nearest to it is the one that the shell is held by.",
         .required = true,
         .element = Type::coordinate,
         .count = 3},
        {.path = "symmetry", .doc = "Declares a half model; the mirror image is accounted for."},
        {.path = "symmetry.plane",
         .type = Type::word,
         .doc = "Coordinate that is constant on the plane, or a map with its normal.",
         .required = true,
         .words = {"x", "y", "z"}},
        {.path = "symmetry.plane", .doc = "A plane of any orientation.", .required = true},
        {.path = "symmetry.plane.normal",
         .type = Type::list,
         .doc = "Normal; its length has no effect.",
         .required = true,
         .element = Type::number,
         .count = 3},
        {.path = "symmetry.at",
         .type = Type::coordinate,
         .doc = "Distance of the plane from the origin along the unit normal.",
         .fallback = "0"},
        {.path = "symmetry.snap",
         .type = Type::length,
         .doc =
             "Open edges at most so far from the plane are moved onto it, before anything else but repair and remesh; "
             "for cuts that are nearly planar. Default: none is moved, and both ends of the cut's edges must lie "
             "within 1e-6 of the diagonal.",
         .limits = positive},
        {.path = "symmetry.coefficients",
         .type = Type::word,
         .doc = "Force and moment coefficients of newtonian, friction and wave_drag are those of the half that is "
                "modelled, or of the whole body (twice as large). Areas and volumes stay those of the half.",
         .fallback = "half",
         .words = {"half", "whole"}},
    };
}

std::vector<Key> axes_keys() {
    const std::vector<std::string> ways{"+x", "-x", "+y", "-y", "+z", "-z"};
    return {
        {.path = "axes",
         .doc = "The body's axes, for newtonian, friction, wave_drag and projected_area. The right wing points along "
                "up x downstream. `strake check` says where nose, right wing and top are. Default: downstream +x, up "
                "+z."},
        {.path = "axes.downstream",
         .type = Type::word,
         .doc = "Where the air goes at zero angles, from the nose to the tail.",
         .required = true,
         .words = ways},
        {.path = "axes.downstream",
         .type = Type::list,
         .doc = "Any direction; its length has no effect.",
         .required = true,
         .element = Type::number,
         .count = 3},
        {.path = "axes.up",
         .type = Type::word,
         .doc = "From the belly to the top; perpendicular to downstream.",
         .required = true,
         .words = ways},
        {.path = "axes.up",
         .type = Type::list,
         .doc = "Any direction perpendicular to downstream; its length has no effect.",
         .required = true,
         .element = Type::number,
         .count = 3},
    };
}

}  // namespace

std::vector<Key> surface_keys() {
    return in_order({file_keys(), region_keys(), made_region_keys(), wing_region_keys(), invariance_keys(), held_keys(),
                     axes_keys()});
}

}  // namespace strake
