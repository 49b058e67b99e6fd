#include "core/error.hpp"
#include "core/patches/automatic.hpp"
#include "core/patches/segmentation.hpp"
#include "python/bindings.hpp"

namespace strake::python {

using namespace py::literals;

void bind_patches(py::module_& m) {
    py::class_<Patch>(m, "Patch", "Triangles that share design variables.")
        .def_readonly("name", &Patch::name, "String: its path in the tree; p2.1 is the first part of p2.")
        .def_readonly("id", &Patch::id, "Int: its number within the level, from 0.")
        .def_readonly("parent", &Patch::parent, "Int: id of its parent in the level above; -1: none.")
        .def_readonly("triangles", &Patch::triangles, "List of ints: numbers of its triangles, ascending.")
        .def_readonly("area", &Patch::area, "Float: its area, in unit squared.")
        .def_property_readonly(
            "is_smooth", [](const Patch& p) { return p.patch_class == PatchClass::smooth; },
            "True if there is no sharp edge inside the patch; False for the strips between smooth patches.")
        .def(
            "__repr__",
            [](const Patch& p) { return text("<strake.Patch '", p.name, "': ", p.triangles.size(), " triangles>"); },
            repr_doc);
    py::class_<PatchLevel>(m, "PatchLevel", "The patches of one level, which together cover the surface.")
        .def_readonly("patches", &PatchLevel::patches, "List of Patch, by id.")
        .def_property_readonly(
            "labels",
            [](const PatchLevel& l) {
                return py::array_t<int>(static_cast<py::ssize_t>(l.label.size()), l.label.data());
            },
            "m int32: the patch id of each triangle. `labels == 3` is a mask of the triangles of patch 3.")
        .def_readonly("angle_deg", &PatchLevel::angle_deg,
                      "Float: the threshold angle in degrees: neighbours below it share a patch; 0 on level 0.");
    py::class_<PatchHierarchy>(m, "PatchTree", "Nested patches, returned by `patches`; level 0 is the whole surface.")
        .def_readonly("levels", &PatchHierarchy::levels, "List of PatchLevel, from coarse to fine.")
        .def(
            "__repr__",
            [](const PatchHierarchy& tree) {
                std::string counts;
                for (const PatchLevel& level : tree.levels)
                    counts += (counts.empty() ? "" : ", ") + std::to_string(level.patches.size());
                return "<strake.PatchTree: " + counts + " patches>";
            },
            repr_doc);
    m.def(
        "patches",
        [](const TriMesh& surface, const std::vector<double>& angles, const py::object& patches_per_level,
           double min_patch) {
            AutomaticLevels automatic;
            if (const std::vector<int> wanted = counts_of(patches_per_level, "patches: patches_per_level");
                !wanted.empty())
                automatic.patches_per_level = wanted;
            const py::gil_scoped_release release;
            if (!angles.empty()) return segment(surface, adjacency(surface), angles, {40, min_patch, SplitAll{}});
            return segment_automatically(surface, adjacency(surface), automatic);
        },
        "surface"_a, py::kw_only(), "angles"_a = std::vector<double>{}, "patches_per_level"_a = py::tuple(),
        "min_patch"_a = 0.0);
}

}  // namespace strake::python
