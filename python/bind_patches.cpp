#include "core/error.hpp"
#include "core/patches/hierarchy.hpp"
#include "python/bindings.hpp"

namespace strake::python {

using namespace py::literals;

void bind_patches(py::module_& m) {
    py::class_<Patch>(m, "Patch", "Triangles that are driven together.")
        .def_readonly("name", &Patch::name, "A path down the tree: p2.1 is a part of p2.")
        .def_readonly("id", &Patch::id, "Its number within the level.")
        .def_readonly("parent", &Patch::parent, "Number of its parent in the level above; -1: none.")
        .def_readonly("triangles", &Patch::triangles, "Ascending.")
        .def_readonly("area", &Patch::area, "Length squared.")
        .def_property_readonly("is_smooth", [](const Patch& p) { return p.patch_class == PatchClass::smooth; })
        .def("__repr__",
             [](const Patch& p) { return text("<strake.Patch '", p.name, "': ", p.triangles.size(), " triangles>"); });
    py::class_<PatchLevel>(m, "PatchLevel", "The patches of one level; together they are the whole surface.")
        .def_readonly("patches", &PatchLevel::patches)
        .def_property_readonly(
            "labels",
            [](const PatchLevel& l) {
                return py::array_t<int>(static_cast<py::ssize_t>(l.label.size()), l.label.data());
            },
            "Patch number of each triangle, m.")
        .def_readonly("angle_deg", &PatchLevel::angle_deg, "The threshold; 0 on level 0.");
    py::class_<PatchHierarchy>(m, "PatchTree", "Nested patches; level 0 is the whole surface.")
        .def_readonly("levels", &PatchHierarchy::levels)
        .def("__repr__", [](const PatchHierarchy& tree) {
            std::string counts;
            for (const PatchLevel& level : tree.levels)
                counts += (counts.empty() ? "" : ", ") + std::to_string(level.patches.size());
            return "<strake.PatchTree: " + counts + " patches>";
        });
    m.def(
        "patches",
        [](const TriMesh& surface, const std::vector<double>& angles, const std::vector<int>& patches_per_level,
           double min_patch) {
            const py::gil_scoped_release release;
            if (!angles.empty()) return segment(surface, adjacency(surface), angles, {40, min_patch, SplitAll{}});
            AutomaticLevels automatic;
            if (!patches_per_level.empty()) automatic.patches_per_level = patches_per_level;
            return segment_automatically(surface, adjacency(surface), automatic);
        },
        "surface"_a, py::kw_only(), "angles"_a = std::vector<double>{}, "patches_per_level"_a = std::vector<int>{},
        "min_patch"_a = 0.0,
        "Cuts a surface into nested patches.\n\n"
        "`angles`: thresholds in degrees, falling (20, 10); without them levels are chosen automatically, about\n"
        "`patches_per_level` (4, 16, 64) patches each. `min_patch`: smallest patch in percent of the triangles, with\n"
        "angles.");
}

}  // namespace strake::python
