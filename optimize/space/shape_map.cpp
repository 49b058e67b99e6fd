#include "optimize/space/shape_map.hpp"

#include "core/fields/displacement_fields.hpp"
#include "core/fields/invariance.hpp"
#include "core/planform/kept_sections.hpp"
#include "core/planform/planform_motion.hpp"
#include "core/wrap/wrap_map.hpp"

namespace strake {
namespace {

bool has_fields(const ShellDemand& demand) { return demand.fields.size() > 0 && !demand.fields.isZero(0); }

bool has_planform(const ShellDemand& demand) { return demand.planform.size() > 0 && !demand.planform.isZero(0); }

/// Parts that go with hosts which fields move as well; without fields the shell places them.
const Attachments* attached_beside_fields(const RestFacts& rest) {
    return rest.parameters.fields ? rest.setup.options.attached.get() : nullptr;
}

const Points& surface_or_rest(const RestFacts& rest, const Points* surface) {
    return surface ? *surface : rest.surface.vertices;
}

}  // namespace

Points carried(const RestFacts& rest, const Points& of_shell) {
    return rest.wrap ? rest.wrap->displacement(of_shell) : of_shell;
}

Points pulled_to_shell(const RestFacts& rest, const Points& force) {
    return rest.wrap ? rest.wrap->transpose(force) : force;
}

Points kept_motion(const RestFacts& rest, const Points& motion) {
    if (rest.parameters.kept_sections) return rest.parameters.kept_sections->kept(motion);
    return rest.parameters.invariance ? rest.parameters.invariance->projected(motion) : motion;
}

Points kept_rates(const RestFacts& rest, const Points& motion, const Points* surface) {
    if (rest.parameters.kept_sections) return rest.parameters.kept_sections->rate(surface, motion);
    return kept_motion(rest, motion);
}

Points kept_forces(const RestFacts& rest, const Points& force) {
    if (rest.wrap) return force;  // they act on the wrap, whose sections are none of a wing
    if (rest.parameters.kept_sections) return rest.parameters.kept_sections->pulled_back(nullptr, force);
    return rest.parameters.invariance ? rest.parameters.invariance->pulled_back(force) : force;
}

Points surface_rates(const RestFacts& rest, const Points& motion, const Points* surface) {
    Points rates = kept_rates(rest, motion, surface);
    if (const Attachments* attached = attached_beside_fields(rest))
        attached->place_rates(surface_or_rest(rest, surface), rates);
    return rates;
}

Points surface_pull(const RestFacts& rest, const Points& force, const Points* surface) {
    Points pulled = force;
    if (const Attachments* attached = attached_beside_fields(rest))
        attached->pull_back(surface_or_rest(rest, surface), pulled);
    if (rest.parameters.kept_sections) return rest.parameters.kept_sections->pulled_back(surface, pulled);
    return kept_forces(rest, pulled);
}

Points with_fields(const RestFacts& rest, const ShellDemand& demand, const Points& of_shell) {
    const bool keeps_sections = rest.parameters.kept_sections != nullptr;
    Points moved = of_shell;
    if (rest.wrap && of_shell.rows() > 0) {
        // Zero displacements leave the bits of the surface.
        moved = rest.wrap->displacement(of_shell - rest.wrap->mesh().vertices) + rest.surface.vertices;
    }
    if (!rest.parameters.invariance && !keeps_sections && !has_fields(demand) && !has_planform(demand)) return moved;
    if (has_planform(demand) && !keeps_sections) moved += rest.parameters.planform->displacement(demand.planform);
    if (has_fields(demand)) moved += rest.parameters.fields->displacement(demand.fields);
    if (keeps_sections) {  // as the start has them; the planform moves beside it
        moved = rest.surface.vertices + kept_motion(rest, moved - rest.surface.vertices);
        if (has_planform(demand)) moved += rest.parameters.planform->displacement(demand.planform);
        return moved;
    }
    if (rest.parameters.invariance) return rest.surface.vertices + kept_motion(rest, moved - rest.surface.vertices);
    if (const Attachments* attached = attached_beside_fields(rest)) attached->place(moved);
    return moved;
}

Poses with_fields(const RestFacts& rest, const ShellDemand& demand, const Poses& of_shell, const Points& surface) {
    if (!has_fields(demand) && !has_planform(demand)) return of_shell;
    Poses turned = of_shell;
    std::vector<Eigen::Matrix3d> turn =
        has_planform(demand) ? local_maps(rest, demand) : rest.parameters.fields->rotations(demand.fields);
    if (has_planform(demand))
        for (Eigen::Matrix3d& map : turn)
            map = map.determinant() > 0 ? polar_rotation(map) : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
    for (std::size_t t = 0; t < turn.size(); ++t) turned.rotation[t] = turned.rotation[t] * Eigen::Quaterniond(turn[t]);
    if (const Attachments* attached = attached_beside_fields(rest)) {
        const std::vector<Eigen::Quaterniond> of_part = attached->rotations(surface);
        for (std::size_t t = 0; t < turn.size(); ++t)
            if (const int part = attached->part_of()[t]; part >= 0)
                turned.rotation[t] = of_part[static_cast<std::size_t>(part)];
    }
    return turned;
}

Points beside_planform(const RestFacts& rest, const ShellDemand& demand, const Points& surface) {
    if (!has_planform(demand)) return surface;
    return surface - rest.parameters.planform->displacement(demand.planform);
}

std::vector<Eigen::Matrix3d> local_maps(const RestFacts& rest, const ShellDemand& demand) {
    const auto count = static_cast<std::size_t>(rest.surface.num_triangles());
    std::vector<Eigen::Matrix3d> maps(count, Eigen::Matrix3d::Identity());
    if (demand.fields.size() > 0) {
        maps = rest.parameters.fields->local_maps(demand.fields);
        if (const auto& kept = rest.parameters.kept_sections; kept && has_fields(demand))
            kept->change_maps(rest.parameters.fields->displacement(demand.fields), maps);
    }
    if (!has_planform(demand)) return maps;
    const std::vector<Eigen::Matrix3d> of_wings = rest.parameters.planform->local_maps(demand.planform);
    for (std::size_t t = 0; t < count; ++t) maps[t] += of_wings[t] - Eigen::Matrix3d::Identity();
    return maps;
}

std::vector<Eigen::Matrix3d> local_maps(const RestFacts& rest, const ShellDemand& demand, const Points& of_wrap) {
    std::vector<Eigen::Matrix3d> maps = local_maps(rest, demand);
    rest.wrap->add_to_maps(of_wrap - rest.wrap->mesh().vertices, maps);
    return maps;
}

std::vector<Points> surface_response(const RestFacts& rest, PrimoShell* shell, const std::vector<Points>& forces,
                                     double tolerance, const Points* surface) {
    std::vector<Points> moved(forces.size(), Points::Zero(rest.surface.num_vertices(), 3));
    if (!shell) return moved;
    moved = shell->response(forces, tolerance);
    if (rest.wrap)
        for (Points& one : moved) one = carried(rest, one);
    if (rest.parameters.invariance || rest.parameters.kept_sections || attached_beside_fields(rest))
        for (Points& one : moved) one = surface_rates(rest, one, surface);
    return moved;
}

std::vector<ShellSensitivities> surface_adjoint(const RestFacts& rest, PrimoShell* shell,
                                                const std::vector<Points>& dJ_dv, const AdjointOptions& options,
                                                const Points* surface) {
    const bool is_plain =
        !rest.wrap && !rest.parameters.invariance && !rest.parameters.kept_sections && !attached_beside_fields(rest);
    if (shell && is_plain) return shell->adjoint(dJ_dv, options);
    const auto as_given = [&](std::vector<ShellSensitivities> all) {  // the planform moves beside what is kept
        for (std::size_t i = 0; rest.parameters.kept_sections && i < all.size(); ++i) all[i].surface = dJ_dv[i];
        return all;
    };
    std::vector<Points> kept;
    for (const Points& one : dJ_dv) kept.push_back(surface_pull(rest, one, surface));
    if (!shell) {
        std::vector<ShellSensitivities> all;
        for (Points& by_vertex : kept) all.push_back({std::move(by_vertex), {}, {}, {}, {}, {}, {}});
        return as_given(std::move(all));
    }
    std::vector<ShellSensitivities> all = shell->adjoint(rest.wrap ? rest.wrap->transpose(kept) : kept, options);
    if (rest.wrap)  // of the surface, as fields and planform see it
        for (std::size_t i = 0; i < all.size(); ++i) all[i].vertex = std::move(kept[i]);
    if (!rest.wrap && (rest.parameters.invariance || rest.parameters.kept_sections))
        for (ShellSensitivities& one : all) one.force = kept_rates(rest, one.force, nullptr);
    return as_given(std::move(all));
}

bool acts_as_given(const RestFacts& rest) {
    return (rest.wrap || !rest.has_shell) && !rest.parameters.invariance && !rest.parameters.kept_sections &&
           !rest.parameters.planform && !attached_beside_fields(rest);
}

std::vector<ShellSensitivities> adjoint_of_vertices(const RestFacts& rest, PrimoShell* shell,
                                                    const std::vector<int>& vertices, const Points& dJ_dv,
                                                    const AdjointOptions& options) {
    if (!shell) return std::vector<ShellSensitivities>(vertices.size());
    std::vector<ShellSensitivities> all = shell->adjoint(rest.wrap->transpose_at(vertices, dJ_dv), options);
    for (ShellSensitivities& one : all) one.vertex.resize(0, 3);
    return all;
}

}  // namespace strake
