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
         .doc = "all: a triangle belongs to the region if all three vertices are inside; any: one is enough.",
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

std::vector<Key> held_keys() {
    return {
        {.path = "fixed",
         .type = Type::list,
         .doc = "Regions that do not move.",
         .element = Type::name,
         .may_be_empty = true},
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
    return in_order({file_keys(), region_keys(), made_region_keys(), wing_region_keys(), held_keys(), axes_keys()});
}

}  // namespace strake
