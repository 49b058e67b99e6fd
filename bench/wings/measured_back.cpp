#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/planform/find_wings.hpp"
#include "core/planform/planform_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>

/// strake_measured_back [--out DIR] FILE...: every variable of the wing that is found, by itself at both
/// limits of its range, measured by sections of the moved surface, for which the wing is laid out anew; with a winglet,
/// whose line would be another one, by those of the start, gone with it. Stations 0, 35, 70 and 100 %. --out: writes
/// every surface and their list, for measured_back.py.
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

/// What measured_back.py needs to know of the wing: where the stations are, nothing that is measured there.
void write_wing(const std::string& folder, const TriMesh& mesh, const Wing& wing) {
    std::ofstream out(folder + "/wing.txt");
    out.precision(17);
    const WingDeclaration& declared = wing.declaration();
    for (const auto& [name, d] :
         {std::pair("span", wing.span(0)), {"downstream", declared.downstream}, {"up", declared.up}})
        out << name << " " << d.transpose() << "\n";
    out << "root " << wing.root(0) << "\njoined " << wing.is_joined(0) << "\n";
    for (const double s : wing.stations()) {
        const StationFacts at = wing.station(mesh, s);
        out << "station " << s << " " << wing.place(0, s) << " " << wing.up_at(0, wing.place(0, s)).transpose() << " "
            << (0.5 * (at.leading_edge + at.trailing_edge)).transpose() << "\n";
    }
    out << "triangles";
    for (const int t : wing.triangles(0)) out << " " << t;
    out << "\n";
    write_surface(folder + "/start.obj", mesh, SurfaceFormat::obj);
}

void measure(const std::string& file, const std::string& folder) {
    const TriMesh mesh = read_surface(file).mesh;
    const auto found = find_wing(mesh);
    if (!found) throw InvalidInput("no wing is found");
    WingDeclaration declared = found->declaration;
    declared.stations = {0, 0.35, 0.7, 1};
    const auto wing = std::make_shared<const Wing>(mesh, declared);
    const bool is_joined = wing->is_joined(0);
    PlanformMotion motion(mesh, {wing});
    std::ofstream list;
    if (!folder.empty()) {
        write_wing(folder, mesh, *wing);
        list.open(folder + "/moved.txt");
        list.precision(17);
    }
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
            if (list.is_open()) {
                const std::string name = text(v.name.substr(v.name.find("delta_") + 6), sign < 0 ? "-" : "+", ".obj");
                write_surface(folder + "/" + name, now, SurfaceFormat::obj);
                list << planform_changes()[static_cast<std::size_t>(v.change)] << " " << v.station << " " << z[j] << " "
                     << name << "\n";
            }
            const Wing after = wing->has_winglet() ? *wing : Wing(now, declared);
            Off& off = by_change[static_cast<std::size_t>(v.change)];
            const double unit = is_angle(v.change) ? degree : 0.01;
            off.asked = std::max(off.asked, std::abs(changed(v, *wing, mesh, after, now) - z[j]) / unit);
            stayed(v, *wing, mesh, after, now, off);
        }
    for (std::size_t c = 0; c <= static_cast<std::size_t>(PlanformChange::camber); ++c) {
        if (is_shift(static_cast<PlanformChange>(c))) continue;
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
    std::string out;
    for (int i = 1; i < argc; ++i) try {
            const std::string word = argv[i];
            if (word == "--out")
                out = i + 1 < argc ? argv[++i] : "";
            else
                measure(word, out);
        } catch (const std::exception& e) {
            std::fprintf(stderr, "%s: %s\n", argv[i], e.what());
            status = 1;
        }
    return status;
}
