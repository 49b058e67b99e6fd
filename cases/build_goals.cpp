#include "cases/problem_builder.hpp"
#include "objectives/external/external.hpp"
#include "objectives/measures.hpp"
#include "objectives/target_shape.hpp"

#include <algorithm>

namespace strake {
namespace {

const char* name_of(SurfaceFormat format) {
    switch (format) {
        case SurfaceFormat::stl_binary:
            return "stl";
        case SurfaceFormat::stl_ascii:
            return "stl-ascii";
        case SurfaceFormat::obj:
            return "obj";
        case SurfaceFormat::ply_ascii:
            return "ply-ascii";
        case SurfaceFormat::ply_binary:
            return "ply";
        case SurfaceFormat::off:
            return "off";
        case SurfaceFormat::tri:
            return "tri";
    }
    return "stl";
}

}  // namespace

void ProblemBuilder::set_goals() {
    for (const QuantityEntry& entry : case_.quantities)
        at(entry.place, text("quantities.", entry.name, ": "), [&] {
            Quantity quantity = std::visit([&](const auto& what) { return make(entry, what); }, entry.what);
            quantity.names = entry.value_names();
            out_.problem.quantities.push_back(std::move(quantity));
        });
    out_.problem.objective = case_.objective.name;
    out_.problem.maximize = case_.maximize;
    for (const Reference& target : case_.fit) out_.problem.fit.push_back(target.name);
    for (const ConstraintEntry& entry : case_.constraints) out_.problem.constraints.push_back(entry.constraint);
    out_.problem.optimize = case_.optimize;
}

Quantity ProblemBuilder::make(const QuantityEntry&, const VolumeEntry&) { return volume(start_.mesh, case_.symmetry); }
Quantity ProblemBuilder::make(const QuantityEntry&, const AreaEntry&) { return area(); }
Quantity ProblemBuilder::make(const QuantityEntry& entry, const TargetShapeEntry& target) {
    const TriMesh wanted = read_surface(target.file).mesh;
    return target.same_connectivity ? target_shape_same(entry.name, start_.mesh, wanted)
                                    : target_shape_closest(entry.name, start_.mesh, wanted);
}
Quantity ProblemBuilder::make(const QuantityEntry& entry, const ExternalEntry& program) {
    ExternalCommand command;
    command.name = entry.name;
    command.command = program.command;
    command.gives = program.gives;
    command.timeout_s = program.timeout_s;
    command.format = program.format.empty() ? name_of(out_.format) : program.format;
    command.case_dir = case_.dir();
    command.evaluations_dir = case_.output.dir / "evaluations";
    const auto is_program = [](const QuantityEntry& q) { return std::holds_alternative<ExternalEntry>(q.what); };
    command.own_folder = std::count_if(case_.quantities.begin(), case_.quantities.end(), is_program) > 1;
    command.has_gradients = program.has_gradients;
    command.diagonal = start_.diagonal;
    command.units = case_.units;
    return external(command);
}

}  // namespace strake
