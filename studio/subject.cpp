#include "studio/subject.hpp"

#include "casefile/load_case.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/automatic.hpp"
#include "core/text/base64.hpp"
#include "studio/surface_payload.hpp"

namespace strake {

void show(Subject& subject, const Case* the_case) {
    subject.payload = payload_of(subject, the_case, subject.wing);
    if (subject.wing)
        subject.wing_places = std::make_shared<const Wing>(subject.ground.start.mesh, subject.wing->declaration);
}

std::shared_ptr<const Subject> surface_subject(const std::filesystem::path& file) {
    auto subject = std::make_shared<Subject>();
    subject->surface = file;
    SurfaceFile read = read_surface(file);
    StartSurface& start = subject->ground.start;
    start.mesh = std::move(read.mesh);
    start.file_triangles = start.mesh.num_triangles();
    if (start.file_triangles == 0) throw InputError(text(file.string(), ": holds no triangles"));
    start.adjacent = adjacency(start.mesh);
    start.area = triangle_areas(start.mesh);
    start.diagonal = box_diagonal(start.mesh);
    try {
        subject->ground.tree = segment_automatically(start.mesh, start.adjacent);
    } catch (const InvalidInput& refused) {
        subject->ground.warnings.push_back(text("no patches: ", refused.what()));
    }
    show(*subject, nullptr);
    return subject;
}

std::shared_ptr<const Subject> case_subject(const std::filesystem::path& case_file, const std::string& yaml) {
    auto subject = std::make_shared<Subject>();
    subject->case_file = case_file;
    subject->blocks = ground_blocks(yaml);
    const Case the_case = load_case_text(yaml, case_file);
    subject->surface = the_case.surface;
    subject->ground = region_ground(the_case);
    show(*subject, &the_case);
    return subject;
}

std::string ground_blocks(const std::string& yaml) {
    std::string blocks;
    for (const char* key : {"surface", "repair", "remesh", "symmetry", "shell", "parameters"})
        blocks += block_of(yaml, key);
    return blocks;
}

nlohmann::ordered_json regions_json(const Subject& subject, const Case& the_case) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    const StartSurface& start = subject.ground.start;
    const WingSetup wings{the_case.planform, the_case.aero.axes.value_or(BodyAxes{}), the_case.symmetry};
    RegionSets sets(the_case.regions, start, subject.ground.tree, &wings);
    for (std::size_t k = 0; k < the_case.regions.size(); ++k) {
        const Region& region = the_case.regions[k];
        nlohmann::ordered_json one{{"name", region.name}, {"line", region.place.line}, {"fixed", false}};
        for (const Reference& fixed : the_case.fixed)
            if (fixed.name == region.name) one["fixed"] = true;
        try {
            const std::vector<int>& triangles = sets.triangles(static_cast<int>(k));
            std::vector<char> marks(static_cast<std::size_t>(start.mesh.num_triangles()), 0);
            double area = 0;
            for (const int t : triangles) {
                marks[static_cast<std::size_t>(t)] = 1;
                area += start.area[t];
            }
            one["triangles"] = triangles.size();
            one["area"] = area;
            one["marks"] = packed_marks(marks);
        } catch (const InvalidInput& refused) {
            one["error"] = refused.what();
            one["error_line"] = region.shape_place.line;
        }
        list.push_back(std::move(one));
    }
    return list;
}

std::string packed_marks(const std::vector<char>& marks) {
    std::string bits((marks.size() + 7) / 8, '\0');
    for (std::size_t t = 0; t < marks.size(); ++t)
        if (marks[t]) bits[t / 8] = static_cast<char>(static_cast<unsigned char>(bits[t / 8]) | (1u << (t % 8)));
    return base64(bits);
}

}  // namespace strake
