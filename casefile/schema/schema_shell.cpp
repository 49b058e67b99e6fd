#include "casefile/schema/schema_parts.hpp"

namespace strake {
namespace {

std::vector<Key> stiffness_keys() {
    return {
        {.path = "shell", .doc = "The elastic shell on the surface.", .fallback = "{}"},
        {.path = "shell",
         .type = Type::word,
         .doc = "none: no shell is built, and parameters.fields (by default all of them, none beside "
                "parameters.planform) and changes of wings move the surface. It "
                "may then be any that can be read: piercing itself, of slivers, of many parts, not manifold.",
         .words = {"none"}},
        {.path = "shell.thickness",
         .type = Type::length,
         .doc = "Full thickness of the shell; a thicker shell bends less.",
         .fallback = "2%",
         .limits = positive},
        {.path = "shell.thickness",
         .doc = "Thickness by region: `default` and names of regions. Where regions overlap, the later entry holds."},
        {.path = "shell.thickness.default",
         .type = Type::length,
         .doc = "Thickness outside the named regions.",
         .required = true,
         .limits = positive},
        {.path = "shell.thickness.*", .type = Type::length, .doc = "Thickness of this region.", .limits = positive},
        {.path = "shell.spring",
         .type = Type::number,
         .doc = "Stiffness per area of a ground spring under the loaded regions, 1/length^2.",
         .fallback = "0",
         .limits = not_negative},
        {.path = "shell.nonmanifold",
         .type = Type::word,
         .doc = "Edges with more than two triangles: refuse the surface, or couple every pair of their triangles.",
         .fallback = "refuse",
         .words = {"refuse", "couple"}},
        {.path = "shell.solver",
         .type = Type::word,
         .doc =
             "Linear solver of the shell. direct: sparse Cholesky factorization; multigrid: a quarter of the memory, "
             "faster for a few solves on many triangles; auto: chosen by size and number of solves.",
         .fallback = "auto",
         .words = {"auto", "direct", "multigrid"}},
        {.path = "wrap",
         .type = Type::word,
         .doc = "auto: the shell stands on a closed, even surface that is laid around the body, which may then be any "
                "that can be read, and the body is carried along: patches, loads and strains act on the wrap, all else "
                "is about the body. alpha is a fiftieth of the diagonal, and doubled where that gives no sound wrap or "
                "takes longer than 20 s. none: the shell stands on the body.",
         .fallback = "none",
         .words = {"none", "auto"}},
        {.path = "wrap", .doc = "A wrap of this fineness, and no other."},
        {.path = "wrap.alpha",
         .type = Type::length,
         .doc = "Slots and thicknesses below about this are bridged or moved as one.",
         .required = true,
         .limits = positive},
        {.path = "wrap.offset",
         .type = Type::length,
         .doc = "Distance of the wrap from the body; by default alpha / 2.5. Below alpha / 10 the wrap gets slow and "
                "full of needles.",
         .limits = positive},
        {.path = "wrap.edge_length",
         .type = Type::length,
         .doc = "Of the wrap's triangles; by default 0.6 alpha.",
         .limits = positive},
    };
}

std::vector<Key> load_keys() {
    return {
        {.path = "loads",
         .type = Type::list,
         .doc = "Prescribed loads; `run` and `fit` apply them in addition to the design variables.",
         .element = Type::map,
         .may_be_empty = true},
        {.path = "loads[]", .doc = "At most one of traction, force, displacement; or only a spring."},
        {.path = "loads[].region", .type = Type::name, .doc = "Loaded region.", .required = true},
        {.path = "loads[].traction",
         .type = Type::list,
         .doc = "Force per area, 1/length.",
         .element = Type::number,
         .count = 3},
        {.path = "loads[].force",
         .type = Type::list,
         .doc = "Total force, spread evenly over the area of the region, length.",
         .element = Type::number,
         .count = 3},
        {.path = "loads[].displacement",
         .type = Type::length,
         .doc = "Uniform traction along `direction`, scaled to this maximum displacement of its linear response.",
         .limits = positive},
        {.path = "loads[].direction",
         .type = Type::list,
         .doc = "Direction of the traction; its length has no effect.",
         .required = true,
         .element = Type::number,
         .count = 3,
         .when = "displacement"},
        {.path = "loads[].spring",
         .type = Type::number,
         .doc = "Ground spring under this region in place of shell.spring, 1/length^2.",
         .limits = not_negative},
    };
}

std::vector<Key> strain_keys() {
    return {
        {.path = "strains",
         .type = Type::list,
         .doc = "Regions that follow a prescribed rigid motion.",
         .element = Type::map,
         .may_be_empty = true},
        {.path = "strains[]", .doc = "A rotation, a translation, or both (the rotation first)."},
        {.path = "strains[].region", .type = Type::name, .doc = "Region that moves.", .required = true},
        {.path = "strains[].translate", .type = Type::list, .doc = "Translation.", .element = Type::length, .count = 3},
        {.path = "strains[].rotate",
         .type = Type::list,
         .doc = "Rotation vector: axis times angle.",
         .element = Type::angle,
         .count = 3},
        {.path = "strains[].about",
         .type = Type::list,
         .doc = "Center of the rotation. Default: the area centroid of the region.",
         .element = Type::coordinate,
         .count = 3},
    };
}

std::vector<Key> attach_keys() {
    return {
        {.path = "attach",
         .type = Type::list,
         .doc = "Disconnected parts that move with another part, for example a nacelle under a wing. They do not "
                "belong to the shell, need no support, and carry no loads or variables. Gradients account for them.",
         .element = Type::map,
         .may_be_empty = true},
        {.path = "attach[]", .doc = "A part and its host; the host may itself be attached."},
        {.path = "attach[].part",
         .type = Type::text,
         .doc =
             "The attached part: a region, a part named in the surface file, or the number of a connected component. "
             "It must consist of whole components.",
         .required = true},
        {.path = "attach[].to",
         .type = Type::text,
         .doc = "The host: a region, a part named in the surface file, or the number of a connected component.",
         .required = true},
        {.path = "attach[].how",
         .type = Type::word,
         .doc = "rigid: the part moves as a rigid body, by the best fit to the nearby motion of its host; follow: in "
                "addition each vertex takes over the deformation of the closest points of the host.",
         .fallback = "rigid",
         .words = {"rigid", "follow"}},
    };
}

}  // namespace

std::vector<Key> shell_keys() { return in_order({stiffness_keys(), load_keys(), strain_keys(), attach_keys()}); }

}  // namespace strake
