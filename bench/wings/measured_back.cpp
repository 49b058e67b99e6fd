#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/planform/find_wings.hpp"
#include "core/planform/planform_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

/// strake_measured_back FILE...: every variable of the wing that is found, by itself at both limits of its range,
/// measured by sections of the moved surface, for which the wing is laid out anew. Stations 0, 35, 70 and 100 %.
namespace {

using namespace strake;

constexpr double degree = std::numbers::pi / 180;

/// Largest of what is off: the change that was asked for, and what should have stayed.
struct Off {
    double asked = 0, chord = 0, thickness = 0;  ///< percent, of angles degrees; percent; percent
    double twist = 0, panel = 0, camber = 0;     ///< degrees, degrees, percent of the chord
};

double changed(const PlanformMotion::Variable& v, const Wing& before, const TriMesh& start, const Wing& after,
               const TriMesh& now) {
    const auto difference = [&](const auto& value) { return value(after, now) - value(before, start); };
    const auto share = [&](const auto& value) { return difference(value) / value(before, start); };
    if (v.change == PlanformChange::span)
        return share([](const Wing& wing, const TriMesh& mesh) { return wing.facts(mesh).span.value; });
    if (v.change == PlanformChange::sweep)
        return difference(
            [&](const Wing& wing, const TriMesh& mesh) { return wing.panel(mesh, v.station).sweep.value; });
    if (v.change == PlanformChange::dihedral)
        return difference(
            [&](const Wing& wing, const TriMesh& mesh) { return wing.panel(mesh, v.station).dihedral.value; });
    if (v.change == PlanformChange::chord)
        return share([&](const Wing& wing, const TriMesh& mesh) { return wing.station(mesh, v.station).chord.value; });
    if (v.change == PlanformChange::twist)
        return difference(
            [&](const Wing& wing, const TriMesh& mesh) { return wing.station(mesh, v.station).twist.value; });
    if (v.change == PlanformChange::thickness)
        return share([&](const Wing& wing, const TriMesh& mesh) {
            return wing.station(mesh, v.station).thickness_to_chord.value;
        });
    return difference(
        [&](const Wing& wing, const TriMesh& mesh) { return wing.station(mesh, v.station).camber.value; });
}

void stayed(const PlanformMotion::Variable& v, const Wing& before, const TriMesh& start, const Wing& after,
            const TriMesh& now, Off& off) {
    for (const double s : before.stations()) {
        const StationFacts a = before.station(start, s), b = after.station(now, s);
        if (v.change != PlanformChange::chord)
            off.chord = std::max(off.chord, 100 * std::abs(b.chord.value / a.chord.value - 1));
        if (v.change != PlanformChange::thickness)
            off.thickness =
                std::max(off.thickness, 100 * std::abs(b.thickness_to_chord.value / a.thickness_to_chord.value - 1));
        if (v.change != PlanformChange::twist)
            off.twist = std::max(off.twist, std::abs(b.twist.value - a.twist.value) / degree);
        if (v.change != PlanformChange::camber)
            off.camber = std::max(off.camber, 100 * std::abs(b.camber.value - a.camber.value));
    }
    for (const double s : before.panel_ends()) {
        const PanelFacts a = before.panel(start, s), b = after.panel(now, s);
        if (v.change != PlanformChange::sweep || a.from != before.panel(start, v.station).from)
            off.panel = std::max(off.panel, std::abs(b.sweep.value - a.sweep.value) / degree);
        if (v.change != PlanformChange::dihedral || a.from != before.panel(start, v.station).from)
            off.panel = std::max(off.panel, std::abs(b.dihedral.value - a.dihedral.value) / degree);
    }
}

void measure(const std::string& file) {
    const TriMesh mesh = read_surface(file).mesh;
    auto found = find_wing(mesh);
    if (!found) throw InvalidInput("no wing is found");
    found->declaration.stations = {0, 0.35, 0.7, 1};
    const auto wing = std::make_shared<const Wing>(mesh, found->declaration);
    const bool is_joined = wing->is_joined(0);
    PlanformMotion motion(mesh, {wing});
    for (const auto& [change, range] :
         std::vector<std::pair<PlanformChange, double>>{{PlanformChange::span, 0.1},
                                                        {PlanformChange::sweep, 8 * degree},
                                                        {PlanformChange::dihedral, 5 * degree},
                                                        {PlanformChange::chord, 0.1},
                                                        {PlanformChange::twist, 5 * degree},
                                                        {PlanformChange::thickness, 0.15},
                                                        {PlanformChange::camber, 0.01}}) {
        const bool is_of_sections = !has_panels(change) && has_stations(change);
        motion.add(mesh, {.change = change,
                          .by_station = has_stations(change),
                          .root_held = is_of_sections && is_joined,
                          .lower = -range,
                          .upper = range});
    }
    std::vector<Off> by_change(planform_changes().size());
    for (int j = 0; j < motion.size(); ++j)
        for (const double sign : {-1.0, 1.0}) {
            const PlanformMotion::Variable& v = motion.variables()[static_cast<std::size_t>(j)];
            const Eigen::VectorXd z = sign * v.upper * Eigen::VectorXd::Unit(motion.size(), j);
            const TriMesh now = with_vertices(mesh, mesh.vertices + motion.displacement(z));
            const Wing after(now, found->declaration);
            Off& off = by_change[static_cast<std::size_t>(v.change)];
            const double unit = is_angle(v.change) ? degree : 0.01;
            off.asked = std::max(off.asked, std::abs(changed(v, *wing, mesh, after, now) - z[j]) / unit);
            stayed(v, *wing, mesh, after, now, off);
        }
    for (std::size_t c = 0; c < by_change.size(); ++c) {
        const Off& off = by_change[c];
        std::printf("| %s | %d | %s | %.3f | %.2f | %.2f | %.3f | %.2f | %.3f |\n",
                    file.substr(file.rfind('/') + 1).c_str(), mesh.num_triangles(), planform_changes()[c].c_str(),
                    off.asked, off.chord, off.thickness, off.twist, off.camber, off.panel);
    }
    std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
    std::puts(
        "| surface | triangles | changed | asked for, off by (deg or %) | chord, % | t/c, % | twist, deg | camber, % "
        "of the "
        "chord | other panels, deg |\n|---|---|---|---|---|---|---|---|---|");
    int status = argc > 1 ? 0 : 2;
    for (int i = 1; i < argc; ++i) try {
            measure(argv[i]);
        } catch (const std::exception& e) {
            std::fprintf(stderr, "%s: %s\n", argv[i], e.what());
            status = 1;
        }
    return status;
}
