#include "casefile/build/make_wing.hpp"

namespace strake {

namespace {
constexpr double edge_share = 0.01;  ///< of the chord
}

std::shared_ptr<const Wing> make_wing(const WingEntry& entry, const WingSetup& setup, const TriMesh& start,
                                      std::vector<int> triangles) {
    WingDeclaration declared;
    declared.name = entry.name;
    declared.triangles = std::move(triangles);
    declared.span = entry.span;
    declared.downstream = setup.axes.downstream;
    declared.up = setup.axes.up;
    declared.symmetry = setup.symmetry;
    declared.stations = entry.stations;
    declared.axis = entry.axis;
    declared.rules = entry.rules;
    return std::make_shared<const Wing>(start, declared);
}

std::vector<int> wing_region(const Wing& wing, const WingRegion& part, const TriMesh& start) {
    using Edge = WingRegion::Edge;
    std::vector<char> marks;
    if (part.edge == Edge::none) {
        marks = wing.region(start, {part.chord[0], part.chord[1]}, {part.span[0], part.span[1]}, part.side);
    } else {
        // All but what lies wholly away from the edge.
        marks = wing.region(start, {0, 1}, {part.span[0], part.span[1]}, part.side);
        const bool leads = part.edge == Edge::leading;
        const std::pair<double, double> away{leads ? edge_share : 0, leads ? 1 : 1 - edge_share};
        const std::vector<char> rest = wing.region(start, away, {0, 1}, 0);
        for (std::size_t t = 0; t < marks.size(); ++t) marks[t] = marks[t] && !rest[t];
    }
    std::vector<int> found;
    for (std::size_t t = 0; t < marks.size(); ++t)
        if (marks[t]) found.push_back(static_cast<int>(t));
    return found;
}

}  // namespace strake
