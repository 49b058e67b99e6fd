#include "studio/surface_payload.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/planform/find_wings.hpp"
#include "core/repair/checkup.hpp"
#include "optimize/space/mirror.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>

namespace strake {
namespace {

using Json = nlohmann::ordered_json;

constexpr double crease_deg = 40;        ///< edges that are drawn, the angle of the automatic patches
constexpr std::size_t max_places = 300;  ///< of a defect

Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
double degrees(double radians) { return radians * 180 / std::numbers::pi; }

/// Collects arrays behind each other.
class Arrays {
public:
    static_assert(std::endian::native == std::endian::little);
    template <class Number>
    void add(const std::string& name, const std::vector<Number>& values, const char* type) {
        facts_[name] = {{"offset", bytes_.size()}, {"count", values.size()}, {"type", type}};
        const std::size_t size = values.size() * sizeof(Number), from = bytes_.size();
        bytes_.resize(from + (size + 3) / 4 * 4, '\0');
        if (size > 0) std::memcpy(bytes_.data() + from, values.data(), size);
    }
    const Json& facts() const { return facts_; }
    const std::string& bytes() const { return bytes_; }

private:
    Json facts_ = Json::object();
    std::string bytes_;
};

/// Kinds of defects with places on the surface, for the eye.
class Defects {
public:
    explicit Defects(const TriMesh& mesh) : mesh_(mesh) {}
    void at_triangles(const std::string& words, const std::vector<int>& triangles) {
        std::vector<Eigen::Vector3d> places;
        for (const int t : triangles)
            if (places.size() < max_places) places.push_back(middle(t));
        add(words, triangles.size(), places);
    }
    void at_vertices(const std::string& words, const std::vector<int>& vertices) {
        std::vector<Eigen::Vector3d> places;
        for (const int v : vertices)
            if (places.size() < max_places) places.push_back(mesh_.vertices.row(v).transpose());
        add(words, vertices.size(), places);
    }
    void at_edges(const std::string& words, const std::vector<int>& edges, const Adjacency& adjacent) {
        std::vector<Eigen::Vector3d> places;
        for (const int e : edges)
            if (places.size() < max_places) {
                const auto [a, b] = adjacent.edges[static_cast<std::size_t>(e)];
                places.push_back((mesh_.vertices.row(a) + mesh_.vertices.row(b)).transpose() / 2);
            }
        add(words, edges.size(), places);
    }
    void at_pairs(const std::string& words, const std::vector<std::array<int, 2>>& pairs) {
        std::vector<int> first;
        for (const auto& pair : pairs) first.push_back(pair[0]);
        at_triangles(words, first);
    }
    void at_loop(const BoundaryLoop& loop) {
        std::string words = text("open border of ", loop.vertices.size(), " vertices, size ", loop.size);
        if (loop.symmetry_axis >= 0)
            words += text(", in the plane ", "xyz"[loop.symmetry_axis], " = ", loop.symmetry_at, " of half a body");
        add(words, 1, {mesh_.vertices.row(loop.vertices.front()).transpose()});
    }
    Json take() { return std::move(list_); }

private:
    const TriMesh& mesh_;
    Json list_ = Json::array();
    Eigen::Vector3d middle(int t) const {
        return (mesh_.vertices.row(mesh_.triangles(t, 0)) + mesh_.vertices.row(mesh_.triangles(t, 1)) +
                mesh_.vertices.row(mesh_.triangles(t, 2)))
                   .transpose() /
               3;
    }
    void add(const std::string& words, std::size_t count, const std::vector<Eigen::Vector3d>& places) {
        if (count == 0) return;
        Json points = Json::array();
        for (const Eigen::Vector3d& place : places) points.push_back(vector_json(place));
        list_.push_back({{"what", words}, {"count", count}, {"places", std::move(points)}});
    }
};

Json defects_of(const TriMesh& mesh, const Checkup& found) {
    Defects list(mesh);
    const TopologyFacts& facts = found.facts;
    list.at_edges("edges of more than two triangles", facts.nonmanifold_edges, found.adjacent);
    list.at_edges("edges whose two triangles disagree about the outside", facts.misoriented_edges, found.adjacent);
    list.at_vertices("vertices where parts touch in a point", facts.nonmanifold_vertices);
    list.at_vertices("open vertices almost at another one (a crack)", found.crack_vertices);
    list.at_triangles("triangles without area", facts.degenerate_triangles);
    list.at_triangles("triangles that occur twice", facts.duplicate_triangles);
    list.at_triangles("triangles that are folded over", found.inverted_triangles);
    if (found.pairs) {
        list.at_pairs("pairs of triangles that pierce each other", found.pairs->apart);
        list.at_pairs("neighbouring triangles that pierce each other", found.pairs->adjacent);
    }
    constexpr std::size_t one_by_one = 6;
    std::vector<int> first;
    for (const BoundaryLoop& loop : found.loops) first.push_back(loop.vertices.front());
    if (first.size() > one_by_one)
        list.at_vertices("open borders", first);
    else
        for (const BoundaryLoop& loop : found.loops) list.at_loop(loop);
    return list.take();
}

Json wing_json(const FoundWing& found, const TriMesh& mesh, std::vector<float>& trailing,
               const Eigen::Vector3d& center) {
    const Wing wing(mesh, found.declaration);
    const WingFacts facts = wing.facts(mesh);
    Json one{{"why", found.why},
             {"is_half", wing.num_sides() == 1},
             {"has_body", found.has_body},
             {"span", facts.span.value},
             {"area", facts.area.value},
             {"aspect_ratio", facts.aspect_ratio.value},
             {"taper", facts.taper.value},
             {"sweep_deg", degrees(facts.sweep.value)},
             {"dihedral_deg", degrees(facts.dihedral.value)},
             {"mean_chord", facts.mean_chord.value},
             {"stations", Json::array()}};
    for (const double s : wing.stations()) {
        const StationFacts at = wing.station(mesh, s);
        one["stations"].push_back({{"station", at.station},
                                   {"chord", at.chord.value},
                                   {"twist_deg", degrees(at.twist.value)},
                                   {"thickness_to_chord", at.thickness_to_chord.value}});
        for (int c = 0; c < 3; ++c) trailing.push_back(static_cast<float>(at.trailing_edge[c] - center[c]));
    }
    return one;
}

std::vector<std::uint32_t> creases_of(const StartSurface& start) {
    const Points normals = triangle_normals(start.mesh);
    std::vector<std::uint32_t> pairs;
    for (int e = 0; e < start.adjacent.num_edges(); ++e) {
        const auto triangles = start.adjacent.edge_triangles[e];
        const bool is_crease =
            !start.adjacent.is_regular(e) ||
            dihedral(normals.row(triangles[0]), normals.row(triangles[1])) > crease_deg * std::numbers::pi / 180;
        if (!is_crease) continue;
        for (const int v : start.adjacent.edges[static_cast<std::size_t>(e)])
            pairs.push_back(static_cast<std::uint32_t>(v));
    }
    return pairs;
}

/// A guess: along the longer of the two other coordinates. Nothing where the plane is oblique.
std::optional<BodyAxes> axes_across(const SymmetryPlane& plane, const Eigen::Vector3d& size) {
    int across = -1, along = -1;
    for (int c = 0; c < 3; ++c)
        if (std::abs(plane.normal[c]) > 1 - 1e-6) across = c;
    if (across < 0) return {};
    for (int c = 0; c < 3; ++c)
        if (c != across && (along < 0 || size[c] > size[along])) along = c;
    BodyAxes axes;
    axes.downstream = Eigen::Vector3d::Unit(along);
    axes.up = Eigen::Vector3d::Unit(3 - across - along);
    return axes;
}

/// Axes, symmetry and wings: from the case, else what is found.
std::optional<FoundWing> add_directions(const StartSurface& start, const Case* the_case, const Checkup& found,
                                        Json& facts, Arrays& arrays, const Eigen::Vector3d& center) {
    WingSearch search;
    std::optional<BodyAxes> axes = the_case ? body_axes(*the_case) : std::nullopt;
    std::optional<SymmetryPlane> symmetry = the_case ? the_case->symmetry : std::nullopt;
    if (axes && axes->is_stated) search.downstream = axes->downstream, search.up = axes->up;
    if (!symmetry) symmetry = cut_of_half(start.mesh, start.adjacent, found.loops);
    if (symmetry) search.symmetry = symmetry;
    const bool is_half = symmetry.has_value();
    if (!symmetry) symmetry = plane_of_symmetry(start.mesh);
    facts["wings"] = Json::array();
    std::vector<float> trailing;
    std::optional<FoundWing> wing;
    try {
        wing = find_wing(start.mesh, search);
        // A fin of a symmetric body is no wing of it.
        const bool is_across = wing && (!symmetry || std::abs(wing->declaration.span.dot(symmetry->normal)) > 0.9);
        if (!is_across) wing.reset();
        if (wing) {
            facts["wings"].push_back(wing_json(*wing, start.mesh, trailing, center));
            if (!axes) axes = BodyAxes{wing->declaration.downstream, wing->declaration.up, false, {}};
        }
    } catch (const InvalidInput&) {
        trailing.clear();  // sections that do not exist: no table
        wing.reset();
    }
    arrays.add("trailing", trailing, "f32");
    facts["axes"] = nullptr;
    if (!axes && symmetry) axes = axes_across(*symmetry, found.box.max - found.box.min);
    if (axes)
        facts["axes"] = {{"downstream", vector_json(axes->downstream)},
                         {"up", vector_json(axes->up)},
                         {"is_stated", axes->is_stated}};
    facts["symmetry"] = nullptr;
    if (symmetry)
        facts["symmetry"] = {
            {"normal", vector_json(symmetry->normal)}, {"offset", symmetry->offset}, {"is_half", is_half}};
    return wing;
}

void add_labels(const RegionGround& ground, Json& facts, Arrays& arrays) {
    facts["levels"] = Json::array();
    for (std::size_t l = 1; l < ground.tree.levels.size(); ++l) {
        const PatchLevel& level = ground.tree.levels[l];
        Json names = Json::array();
        for (const Patch& patch : level.patches) names.push_back(patch.name);
        const std::string name = text("level", l);
        arrays.add(name, std::vector<std::uint32_t>(level.label.begin(), level.label.end()), "u32");
        facts["levels"].push_back({{"array", name}, {"patches", std::move(names)}});
    }
    const TriMesh& mesh = ground.start.mesh;
    facts["parts"] = Json::array();
    for (const std::string& name : mesh.group_names) facts["parts"].push_back(printable(name));
    if (!mesh.group.empty())
        arrays.add("part", std::vector<std::uint32_t>(mesh.group.begin(), mesh.group.end()), "u32");
    const std::vector<int> component = edge_components(mesh, ground.start.adjacent);
    arrays.add("component", std::vector<std::uint32_t>(component.begin(), component.end()), "u32");
}

}  // namespace

std::vector<float> relative_to(const Eigen::Vector3d& center, const Points& vertices) {
    std::vector<float> positions;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v)
        for (int c = 0; c < 3; ++c) positions.push_back(static_cast<float>(vertices(v, c) - center[c]));
    return positions;
}

std::string payload_of(const Subject& subject, const Case* the_case, std::optional<FoundWing>& wing) {
    const StartSurface& start = subject.ground.start;
    const TriMesh& mesh = start.mesh;
    const Checkup found = checkup(mesh);
    const Eigen::Vector3d center = (found.box.min + found.box.max) / 2;
    Arrays arrays;
    std::vector<std::uint32_t> triangles;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) triangles.push_back(static_cast<std::uint32_t>(mesh.triangles(t, k)));
    arrays.add("positions", relative_to(center, mesh.vertices), "f32");
    arrays.add("triangles", triangles, "u32");
    arrays.add("creases", creases_of(start), "u32");
    Json facts{{"vertices", mesh.num_vertices()},
               {"triangles", mesh.num_triangles()},
               {"components", found.facts.components},
               {"closed", found.facts.closed},
               {"low", vector_json(found.box.min)},
               {"high", vector_json(found.box.max)},
               {"center", vector_json(center)},
               {"diagonal", found.diagonal},
               {"area", found.area},
               {"volume", nullptr},
               {"units", the_case ? the_case->units : ""},
               {"is_prepared", start.is_remeshed || !start.source_triangle.empty()},
               {"notes", subject.ground.notes},
               {"warnings", subject.ground.warnings},
               {"advice", advice(mesh, found)},
               {"defects", defects_of(mesh, found)}};
    if (found.facts.closed) facts["volume"] = found.volume;
    if (!start.is_remeshed && !start.source_triangle.empty()) {
        std::vector<std::uint32_t> numbers;
        for (const int number : start.source_triangle) numbers.push_back(static_cast<std::uint32_t>(number));
        arrays.add("file_triangle", numbers, "u32");
    }
    add_labels(subject.ground, facts, arrays);
    wing = add_directions(start, the_case, found, facts, arrays, center);
    facts["arrays"] = arrays.facts();
    std::string json = facts.dump(-1, ' ', false, Json::error_handler_t::replace);
    json.append((4 - json.size() % 4) % 4, ' ');
    std::string out(4, '\0');
    const auto length = static_cast<std::uint32_t>(json.size());
    std::memcpy(out.data(), &length, 4);
    return out + json + arrays.bytes();
}

}  // namespace strake
