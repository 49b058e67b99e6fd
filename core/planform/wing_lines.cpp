#include "core/planform/wing_lines.hpp"

#include "core/error.hpp"

namespace strake {
namespace {

constexpr int num_panels = 16;  ///< edges are straight or bend smoothly between
constexpr std::size_t min_sections = 4;

}  // namespace

WingLines wing_lines(const TriMesh& start, const Wing& wing) {
    const WingDeclaration& declared = wing.declaration();
    if (wing.has_winglet())
        throw InvalidInput(text("wing '", declared.name, "' has a winglet, whose sections are not all streamwise"));
    WingLines lines;
    lines.name = declared.name;
    lines.span = wing.span(0);
    lines.downstream = declared.downstream;
    lines.up = declared.up;
    lines.is_both = wing.num_sides() > 1;
    lines.centre = lines.is_both ? 0.5 * (wing.root(0) - wing.root(1)) : wing.root(0);
    lines.root = wing.root(0) - lines.centre;
    lines.reach = wing.reach(start, 0);
    for (int i = 0; i <= num_panels; ++i) {
        const double station = static_cast<double>(i) / num_panels;
        try {
            const auto of = wing.placed_sections(start, station).front();
            const auto at = [&](const Eigen::Vector3d& axis, const Eigen::Vector3d& x) { return axis.dot(x); };
            const Eigen::Vector3d chord = of.trailing_edge - of.leading_edge;
            lines.sections.push_back({wing.place(0, station), at(lines.downstream, of.leading_edge),
                                      at(lines.up, of.leading_edge), at(lines.downstream, chord), at(lines.up, chord),
                                      of.airfoil.max_thickness().value});
        } catch (const InvalidInput&) {
            continue;  // beside a body, or where the tip ends
        }
    }
    if (lines.sections.size() < min_sections)
        throw InvalidInput(text("wing '", declared.name, "' has ", lines.sections.size(), " sections of ",
                                num_panels + 1, " along its span; fields of a wing need ", min_sections));
    return lines;
}

}  // namespace strake
