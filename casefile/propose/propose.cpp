#include "casefile/propose/propose.hpp"

#include "casefile/build/prepare_surface.hpp"
#include "casefile/propose/propose_parts.hpp"
#include "casefile/yaml/diagnostics.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/geometry.hpp"
#include "core/planform/find_wings.hpp"
#include "core/text/shell_word.hpp"
#include "objectives/geometry/measures.hpp"
#include "optimize/space/mirror.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <utility>

namespace strake {
namespace {

constexpr int max_searched = 400000;  ///< triangles: on larger surfaces no wing is looked for

using namespace proposing;

/// A path or name as a YAML scalar. @throws InputError: bytes that cannot stand in one line of UTF-8 text.
std::string yaml_text(const std::string& words) {
    if (printable(words, words.size() + 1) != words)
        throw InputError(
            text(printable(words, 400), ": this name cannot be written in a case file; rename or link the file"));
    const bool is_plain = !words.empty() && std::all_of(words.begin(), words.end(), [](unsigned char c) {
        return std::isalnum(c) || c == '_' || c == '-' || c == '.' || c == '/';
    }) && (std::isalpha(static_cast<unsigned char>(words[0])) || words[0] == '.' || words[0] == '/');
    if (is_plain) return words;
    std::string out = "'";
    for (const char c : words) out += c == '\'' ? "''" : std::string(1, c);
    return out + "'";
}

std::string name_of_case(const std::filesystem::path& file) {
    std::string name = file.filename().string();
    name = name.substr(0, name.find('.', 1));
    for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-') c = '_';
    return name.empty() ? "surface" : name.substr(0, 100);
}

std::string path_from(const std::filesystem::path& file, const std::filesystem::path& case_file) {
    const auto whole = [](const std::filesystem::path& p) {
        return std::filesystem::weakly_canonical(std::filesystem::absolute(p));
    };
    const std::filesystem::path folder = whole(case_file).parent_path();
    // The name as it was given, links and all, where it is near; far away an absolute one reads better.
    const std::filesystem::path given = std::filesystem::absolute(file).lexically_normal();
    const std::filesystem::path relative = given.lexically_relative(folder);
    const auto ups = std::count(relative.begin(), relative.end(), "..");
    return relative.empty() || ups > 3 ? given.string() : relative.string();
}

/// A row with its comment, the comments aligned.
std::string padded(const std::string& row, const std::string& why) {
    return row + std::string(row.size() < 62 ? 62 - row.size() : 1, ' ') + "# " + why + "\n";
}

std::string surface_text(const std::string& path, const std::string& units, const Checkup& c) {
    std::string out = "surface:\n  file: " + yaml_text(path) + "\n";
    if (!units.empty()) return out + padded("  units: " + units, "as the file says");
    return out +
           "  # units: m     the file does not say; needed only if a length in this case has a unit\n"
           "  #              (the body is " +
           text(c.box.max.x() - c.box.min.x()) + " x " + text(c.box.max.y() - c.box.min.y()) + " x " +
           text(c.box.max.z() - c.box.min.z()) + " in the file's unit)\n";
}

/// New vertices are the user's decision.
std::string joints_text(const RepairedSurface& surface) {
    if (!surface.joints || surface.has_new_vertices) return "";
    const std::string key = text("joints: ", surface.joints->percent, "%");
    const std::string line = surface.keys.empty() ? "# repair: {" + key + "}" : "  # " + key;
    return std::string(surface.keys.empty() ? "\n" : "") +
           padded(line, "new vertices: " + joint_words(*surface.joints));
}

std::string repair_text(const RepairedSurface& surface) {
    if (surface.keys.empty()) return joints_text(surface);
    std::string out =
        "\n# Repairs that the surface needs before it can be deformed; the run folder gets a list of them."
        "\nrepair:\n";
    for (std::size_t i = 0; i < surface.keys.size(); ++i) out += padded("  " + surface.keys[i], surface.why[i]);
    return out + joints_text(surface);
}

std::string attach_text(const std::vector<PartRole>& parts) {
    std::string out;
    for (const PartRole& part : parts)
        if (part.role == PartRole::Kind::attached)
            out += padded(
                text("  - {part: ", part.component, ", to: ", part.host, ", how: rigid}"),
                text(part.name, " floats ", part.gap, " from ", parts[static_cast<std::size_t>(part.host)].name));
    if (out.empty()) return out;
    return "\n# Parts that keep their shape and move with the one they are near; numbers are those of the connected "
           "pieces.\nattach:\n" +
           out;
}

std::string regions_text(const std::vector<ProposedRegion>& regions) {
    std::string out =
                    "\n# Regions that do not move. Look at the picture, and move their borders to where your part "
                    "is held.\nregions:\n",
                names;
    for (const ProposedRegion& region : regions) {
        out += padded("  " + region.name + ": {" + region.shape + "}", region.why);
        names += (names.empty() ? "" : ", ") + region.name;
    }
    return out + "fixed: [" + names + "]\n";
}

std::string hold_text(ProposedHold hold, const ProposedHolds& holds) {
    if (hold == ProposedHold::band) return regions_text(holds.regions) + attach_text(holds.parts);
    if (hold == ProposedHold::point)
        return "\n# One triangle of each part keeps its place; everything else may change. Or hold regions: fixed: "
               "[NAME].\nhold: point      # or {point: [x, y, z]}: the triangle nearest to it\n";
    return "\n# Nothing is held: the fields neither move nor turn the body as a whole, and there are no loads.\nhold: "
           "none\n";
}

std::string symmetry_text(const SymmetryPlane& plane, const std::optional<NearCut>& cut) {
    const char axis = axis_letter(plane.normal);
    const std::string snap = cut ? text(", snap: ", cut->percent, "%") : "";
    return "\n# Half model: the open edges lie on this plane, and the mirror image is accounted for. If this "
           "opening\n"
           "# is not a symmetry plane, delete this line.\nsymmetry: {plane: " +
           std::string(1, axis) + ", at: " + text(plane.offset + 0.0) + snap + "}\n";
}

/// The longest of the axes that are neither of these two.
int longest_axis(const Eigen::Vector3d& size, int across, int up) {
    int longest = -1;
    for (int k = 0; k < 3; ++k)
        if (k != across && k != up && (longest < 0 || size[k] > size[longest])) longest = k;
    return longest;
}

std::string way_word(const Eigen::Vector3d& way) {
    Eigen::Index k = 0;
    way.cwiseAbs().maxCoeff(&k);
    return std::string(way[k] < 0 ? "-" : "+") + axis_letter(Eigen::Vector3d::Unit(k));
}

/// Where a wing shows the axes, they are its own. It is not declared at once: loads and fields would keep its edges.
std::string wing_text(const FoundWing& wing) {
    const WingDeclaration& declared = wing.declaration;
    const char letter = way_word(declared.span)[1];
    const std::string on = declared.triangles.empty() ? "" : "on: NAME, ";
    return "\n# Where the air goes and where up is, as a wing shows: strake check says where it puts nose, right wing "
           "and "
           "top.\naxes: {downstream: " +
           way_word(declared.downstream) + ", up: " + way_word(declared.up) + "}\n\n# A wing: " + wing.why +
           ". Without the # of the next line its span, sweep, chord and twist have names,\n# and loads and fields keep "
           "its edges; strake info --planform prints its sheet.\n# planform: {wing: {" +
           on + "span: " + letter + "}}\n" +
           (on.empty() ? "" : "# NAME: a region of its triangles, beside a body; strake studio chooses them.\n");
}

/// A guess: the air goes along the longest axis, and the right wing lies along the plane's normal. A flat end that the
/// longest axis leaves through is a base, where the air comes off; any other is what the body stands on, or its deck or
/// roof: up is positive either way.
std::string axes_text(const Checkup& c, const std::optional<SymmetryPlane>& plane, const Eigen::Vector3d& down) {
    const Eigen::Vector3d size = c.box.max - c.box.min;
    int across = -1, up = -1, along = -1;
    for (int k = 0; k < 3; ++k) {
        if (plane && std::abs(plane->normal[k]) > 1 - 1e-6) across = k;
        if (std::abs(down[k]) > 1 - 1e-6) up = k;
    }
    if (up == across) up = -1;
    bool leaves_backwards = false;
    if (up >= 0 && size[up] > 1.2 * std::max(size[(up + 1) % 3], size[(up + 2) % 3])) {
        along = std::exchange(up, -1);
        leaves_backwards = down[along] < 0;
    }
    if (along < 0) along = longest_axis(size, across, up);
    if (up < 0) up = across >= 0 ? 3 - across - along : along == 2 ? 1 : 2;
    const auto way = [](int k, bool is_negative) { return std::string(is_negative ? "-" : "+") + "xyz"[k]; };
    return "\n# Where the air goes and where up is, for quantities with a stream. A guess: strake check says where it "
           "puts\n# nose, right wing and top.\naxes: {downstream: " +
           way(along, leaves_backwards) + ", up: " + way(up, false) + "}\n";
}

std::string angles_text(const CreaseAngles& angles) {
    std::string out = "  # Edges by dihedral angle:";
    for (std::size_t k = 0; k < angles.shares.size(); ++k)
        if (angles.shares[k] >= 0.0005)
            out += text(" ", angles.limits_deg[k], "-", angles.limits_deg[k + 1], "deg ",
                        std::round(1000 * angles.shares[k]) / 10, "%,");
    out.back() = '\n';
    out += "  # Number of patches from creases alone:";
    for (const auto& [angle, count] : angles.patches) out += text(" ", count, " patches at ", angle, "deg,");
    out.back() = '.';
    return out + "\n";
}

/// Fields hold a number for each vertex and function: the 192 that `auto` may come to need 9 GB of ten million
/// triangles.
constexpr int many_for_fields = 2000000;

std::string number_of_fields(int triangles, const std::string& comment) {
    if (triangles <= many_for_fields) return padded("  fields: auto", comment);
    return padded("  fields: 27", "smooth motions of the whole body; more (auto: up to 192) take more memory");
}

/// @param farthest the limit on the motion beside fields, for a surface that had to be mended; empty: that of other
/// runs
std::string parameters_text(const RepairedSurface& surface, const std::optional<SymmetryPlane>& mirror,
                            ProposedHold hold, const std::string& farthest) {
    const CreaseAngles angles = crease_angles(surface.mesh, surface.checkup.adjacent);
    const int triangles = surface.mesh.num_triangles();
    const char* counts = triangles < 2000 ? "[2, 6]" : triangles < 10000 ? "[4, 12]" : "[4, 12, 32]";
    std::string out =
        "\n# The design variables: smooth motions of the whole body first, then patches, each of which moves along its "
        "normals and gets\n# finer from level to level. No point of the surface moves farther than "
        "max_displacement.\nparameters:\n";
    out += angles_text(angles);
    out += padded("  levels: auto", "or crease angles, for example [40deg, 20deg]");
    out += padded(text("  patches_per_level: ", counts), "approximate number, level by level");
    out += padded(text("  sharp_angle: ", angles.sharp_deg, "deg"),
                  "edges with larger angles are creases; few are near it");
    if (hold == ProposedHold::none) {
        out += number_of_fields(triangles, "smooth motions of the whole body");
        out += padded("  variables: []", "loads on patches would need hold: point");
    } else {
        out += number_of_fields(triangles, "smooth motions of the whole body, then patches");
        out += padded("  variables: [normal]", "or load, strain, stiffness: strake explain variables");
    }
    out += !farthest.empty()
               ? farthest
               : padded("  max_displacement: 5%", "of the diagonal: the farthest that any point may move");
    if (mirror) out += padded("  mirror: true", "keeps the body symmetric");
    return out;
}

/// A limit on the root-mean-square motion for thin and stout bodies alike, with which any objective ends in a
/// shape that is still that body.
struct MeanMotion {
    double rms = 0;
    const char* of = "";
};
MeanMotion mean_motion(double thickness, double diagonal, bool has_volume) {
    if (!has_volume) return {0.005 * diagonal, "0.5 % of the diagonal"};
    if (0.05 * thickness < 0.01 * diagonal) return {0.05 * thickness, "5 % of the mean thickness"};
    return {0.01 * diagonal, "1 % of the diagonal"};
}

/// Of fields: the mean motion has no slope at the start, so that the first steps do not see its limit: this one stops
/// them. A point moves by some four times the mean where a motion is local.
std::string farthest_motion_text(const MeanMotion& mean, double diagonal) {
    constexpr double min_percent = 1e-3;  // a power line is 17 km long and a metre thick
    std::ostringstream percent;
    percent.imbue(std::locale::classic());
    percent << std::setprecision(1) << std::clamp(400 * mean.rms / diagonal, min_percent, 5.0);
    return padded("  max_displacement: " + percent.str() + "%",
                  "of the diagonal: the farthest that any point may move");
}

/// Twice the enclosed volume by the area: the mean thickness of a thin body.
double mean_thickness(const RepairedSurface& surface, const std::optional<SymmetryPlane>& half) {
    const Eigen::RowVector3d origin =
        half ? Eigen::RowVector3d(half->offset * half->normal.transpose()) : surface.mesh.vertices.row(0);
    const auto corner = [&](int t, int k) {
        return Eigen::RowVector3d(surface.mesh.vertices.row(surface.mesh.triangles(t, k)) - origin);
    };
    double volume = 0;
    for (int t = 0; t < surface.mesh.num_triangles(); ++t)
        volume += corner(t, 0).dot(corner(t, 1).cross(corner(t, 2))) / 6;
    return 2 * std::abs(volume) / surface.checkup.area;
}

std::string change_text(const MeanMotion& mean) {
    std::ostringstream value, shown;
    value.imbue(std::locale::classic()), shown.imbue(std::locale::classic());
    shown.precision(2), value.precision(4);
    shown << mean.rms;
    const double rounded = std::strtod(shown.str().c_str(), nullptr);
    value << rounded * rounded;
    return padded(text("  change: {max: ", value.str(), "}"),
                  text("(", shown.str(), ")^2: mean square displacement, ", mean.of));
}

std::string goal_text(const MeanMotion& mean, bool has_volume) {
    std::string out =
        "\n# REPLACE THIS by your objective: a built-in quantity (docs/objectives.md) or your own program "
        "(docs/external.md).\n"
        "# This one only makes the case run as it is.\n";
    const std::string stays =
        "quantities:\n" + padded("  change: {type: displacement}", "distance from the start shape; optional");
    if (!has_volume)
        return out + padded("objective: {minimize: area}", "the surface encloses no volume") + stays +
               "constraints:\n" + change_text(mean);
    return out + "objective: {maximize: volume}\n" + stays + "constraints:\n" +
           padded("  area: {max: 1.01, relative: true}", "at most 1 % more than at the start") + change_text(mean);
}

/// Slivers invert at the smallest motion.
bool has_slivers(const Checkup& c) { return c.quality.fifth_percentile < 1e-4; }

/// New triangles are worth a try: slivers, or needles throughout a body that is sound otherwise (a motion that bends
/// one by its height inverts it, whatever moves it); and triangles of the mean edge length can follow the body.
bool may_remesh(const RepairedSurface& surface, bool has_volume, double thickness) {
    const Checkup& c = surface.checkup;
    const bool is_of_needles = c.quality.fifth_percentile < 0.01 && c.quality.mean < 0.15;
    const bool is_sound = has_volume && c.pairs && c.pairs->apart.empty();
    return (has_slivers(c) || (is_of_needles && is_sound)) && (!has_volume || c.quality.edge_mean < 2 * thickness);
}

bool is_dirty(const RepairedSurface& surface) {
    const bool was_split = std::ranges::count(surface.keys, "split: true") > 0;
    const auto& pairs = surface.checkup.pairs;
    return has_slivers(surface.checkup) || surface.couple || was_split || !pairs || !pairs->apart.empty();
}

/// What debris leaves is as it was.
bool was_mended(const RepairedSurface& surface) {
    return std::ranges::any_of(surface.keys, [](const std::string& key) { return !key.starts_with("components"); });
}

double thickness_percent(const Checkup& c) { return std::max(2.0, std::ceil(60 * c.quality.edge_mean / c.diagonal)); }

/// Volume is defined for fields wherever the surface, closed by cones, encloses some.
std::optional<double> volume_in_cones(const TriMesh& mesh, const std::optional<SymmetryPlane>& half) {
    try {
        return closed_volume(mesh, half).evaluate({mesh, false, 1, 0, {}}).values.at(0);
    } catch (const InvalidInput&) {
        return {};
    }
}

/// The mean edge of needles is that of their length, which new triangles would cut the body's curves to.
std::string remesh_text(const Checkup& c, const std::string& reason) {
    constexpr double follows = 0.02;  // of the diagonal
    const bool is_of_needles = !has_slivers(c) && c.quality.edge_mean > follows * c.diagonal;
    return (reason.empty() ? "" : "\n# " + reason) + "\n" +
           padded(is_of_needles ? "remesh: {edge_length: 2%}" : "remesh: {edge_length: auto}",
                  "new triangles for the same shape; regions refer to them");
}

/// Fields alone: nothing has to be held.
std::string fields_text(int triangles, const std::optional<SymmetryPlane>& mirror, const std::string& reason,
                        const std::string& farthest) {
    std::string out =
        "\n# No elastic shell: displacement fields, smooth motions of space, move the body as it is, whatever its "
        "triangles are.\n";
    if (!reason.empty()) out += "# " + reason + "\n";
    out +=
        "# Nothing is held; motions of the whole body are left out. To hold something, declare a region and name it "
        "under fixed.\nshell: none\nparameters:\n";
    out += number_of_fields(triangles, "27 at first, then those that the gradient asks for; strake check lists them");
    out += farthest;
    if (mirror) out += padded("  mirror: true", "keeps the body symmetric");
    return out;
}

/// Patches of a wrap, and fields on the body.
std::string wrap_text(int triangles, const std::optional<SymmetryPlane>& mirror, const std::string& reason,
                      const std::string& farthest) {
    std::string out =
        "\n# The elastic shell stands on an even, closed surface around the body, and carries the body as it is along."
        "\n# See it with strake check --wrap FILE.vtp.\n";
    if (!reason.empty()) out += "# " + reason + "\n";
    out += padded("wrap: auto", "or {alpha: 2%}: slots and thicknesses below alpha move as one") + "parameters:\n";
    out += number_of_fields(triangles, "smooth motions of the whole body, and its thickness");
    out += padded("  variables: [normal]", "then patches of the wrap, finer from level to level");
    out += padded("  patches_per_level: [4, 12]", "approximate number, level by level");
    out += farthest;
    if (mirror) out += padded("  mirror: true", "keeps the body symmetric");
    return out;
}

void add_roles(const std::vector<PartRole>& parts, std::vector<std::string>& found) {
    for (const PartRole& part : parts) {
        if (parts.size() < 2 || part.role == PartRole::Kind::held) continue;
        const auto name = [&](int p) { return parts[static_cast<std::size_t>(p)].name; };
        const std::string what = part.role == PartRole::Kind::main    ? "the main part"
                                 : part.role == PartRole::Kind::moves ? "moves: it carries area"
                                                                      : "attached to " + name(part.host);
        found.push_back(text("part ", part.component, ", ", part.name, ": ", what,
                             part.image >= 0 ? ", mirror image of " + name(part.image) : ""));
    }
}

std::vector<std::string> sentences(const RepairedSurface& surface, const ProposedHolds& holds,
                                   const std::optional<SymmetryPlane>& half, const std::optional<SymmetryPlane>& mirror,
                                   bool has_volume, ProposedHold hold) {
    std::vector<std::string> found;
    for (std::size_t i = 0; i < surface.keys.size(); ++i)
        found.push_back(text("repair: {", surface.keys[i], "}: ", surface.why[i]));
    if (half) found.push_back(text("half model, open at ", axis_letter(half->normal), " = ", half->offset));
    if (mirror) found.push_back("the body is symmetric; so are the variables");
    if (hold == ProposedHold::band) add_roles(holds.parts, found);
    if (hold == ProposedHold::point) found.emplace_back("held: one triangle of each part, near its middle");
    if (hold == ProposedHold::none) found.emplace_back("held: nothing; fields alone change the shape");
    for (const ProposedRegion& region : hold == ProposedHold::band ? holds.regions : std::vector<ProposedRegion>{})
        found.push_back(text("held: ", region.name, ", ", region.why));
    if (has_slivers(surface.checkup))
        found.push_back(
            "note: 5 % of the triangles or more are slivers, which invert at small motions: a better "
            "triangulation (strake remesh, or your mesher) allows larger ones");
    const auto& pairs = surface.checkup.pairs;
    if (const std::size_t crossing = pairs ? pairs->apart.size() + pairs->adjacent.size() : 0; crossing > 0)
        found.push_back(text("note: ", crossing,
                             " pairs of triangles intersect; steps that add more are refused, so few may be "
                             "possible: unite the parts in a CAD system first"));
    if (surface.couple) found.push_back("edges with more than two triangles are left; their sheets are coupled");
    found.push_back(has_volume ? "objective: the volume; replace it"
                               : "objective: the area (the surface encloses no volume); replace it");
    return found;
}

std::vector<std::string> sentences_of_fields(const RepairedSurface& surface, const std::optional<SymmetryPlane>& half,
                                             const std::optional<SymmetryPlane>& mirror, bool has_volume,
                                             bool by_wrap) {
    const char* mover = by_wrap ? "wrap and fields" : "fields";
    std::vector<std::string> found;
    for (std::size_t i = 0; i < surface.keys.size(); ++i)
        found.push_back(text("repair: {", surface.keys[i], "}: ", surface.why[i]));
    if (half) found.push_back(text("half model, open at ", axis_letter(half->normal), " = ", half->offset));
    if (mirror) found.push_back(text("the body is symmetric; so are ", mover));
    found.emplace_back(by_wrap ? "held: one triangle of the wrap, near the middle" : "nothing is held");
    if (has_slivers(surface.checkup))
        found.push_back(text("note: 5 % of the triangles or more are slivers, which the ", mover, " carry along"));
    const auto& pairs = surface.checkup.pairs;
    if (const std::size_t crossing = pairs ? pairs->apart.size() + pairs->adjacent.size() : 0; crossing > 0)
        found.push_back(
            text("note: ", crossing, " pairs of triangles intersect; the ", mover, " move both of each alike"));
    if (surface.joints && !surface.has_new_vertices)
        found.push_back(text("note: long edges where parts pass through each other: with strake init --joints, ",
                             joint_words(*surface.joints)));
    found.push_back(has_volume ? "objective: the volume; replace it"
                               : "objective: the area (the surface encloses no volume); replace it");
    return found;
}

std::optional<FoundWing> searched(const TriMesh& mesh, const std::optional<SymmetryPlane>& half) {
    if (mesh.num_triangles() > max_searched) return {};
    return find_wing(mesh, {.symmetry = half});
}

void tell(const std::optional<FoundWing>& wing, std::vector<std::string>& found) {
    if (wing)
        found.push_back(text("a wing along ", way_word(wing->declaration.span), wing->has_body ? " beside a body" : "",
                             ": ", wing->why, "; the case holds its declaration as a comment (planform)"));
}

std::string directions_text(const std::optional<FoundWing>& wing, const Checkup& checkup,
                            const ProposedCase& proposal) {
    return wing ? wing_text(*wing) : axes_text(checkup, proposal.plane, proposal.down);
}

void check_size(const TriMesh& mesh, const ProposalOptions& options) {
    const bool is_for_shell = options.way == ProposedWay::shell || options.way == ProposedWay::remeshed_shell;
    if (is_for_shell && mesh.num_triangles() > options.max_triangles)
        throw InvalidInput(text(mesh.num_triangles(), " triangles, the limit of an examination for a shell is ",
                                options.max_triangles));
}

/// A wrap is one part, whatever the body is.
std::string hold_of(const ProposalOptions& options, const ProposedHolds& holds) {
    if (options.way == ProposedWay::fields) return "";
    return hold_text(options.way == ProposedWay::wrap ? ProposedHold::point : options.hold, holds);
}

}  // namespace

ProposedCase propose_case(const std::filesystem::path& file, const std::filesystem::path& case_file,
                          const ProposalOptions& options) {
    if (options.evaluations < 1) throw InvalidInput(text("evaluations = ", options.evaluations, " must be >= 1"));
    SurfaceFile read = read_surface(file);
    check_coordinates(file, read.mesh);
    check_size(read.mesh, options);
    const std::optional<NearCut> cut = near_cut(read.mesh);
    if (cut) snap_open_edges(cut->plane, cut->percent / 100 * box_diagonal(read.mesh), read.mesh);
    const bool by_wrap = options.way == ProposedWay::wrap;
    const bool by_fields = options.way == ProposedWay::fields || by_wrap;  // the surface as it is
    const RepairedSurface surface =
        by_fields ? as_it_is(std::move(read.mesh), options.joints) : repaired(file, std::move(read.mesh));
    const auto half = half_plane(surface.checkup, surface.mesh);
    const auto mirror = half ? std::nullopt : plane_of_symmetry(surface.mesh);
    ProposedCase proposal;
    ProposedHolds holds;
    if (!by_fields) holds = held_regions(surface, half, mirror);
    proposal.num_triangles = surface.mesh.num_triangles();
    proposal.down = holds.down;
    proposal.ties_parts = holds.ties_parts;
    const std::optional<double> volume = by_fields ? volume_in_cones(surface.mesh, half) : std::nullopt;
    proposal.has_volume = by_fields ? volume.has_value() : encloses_volume(surface, half);
    const double thickness = by_fields ? 2 * volume.value_or(0) / surface.checkup.area : mean_thickness(surface, half);
    proposal.may_remesh = may_remesh(surface, proposal.has_volume, std::abs(thickness));
    proposal.is_dirty = is_dirty(surface);
    proposal.has_new_vertices = surface.has_new_vertices;
    proposal.plane = half ? half : mirror;
    const std::optional<FoundWing> wing = searched(surface.mesh, half);
    proposal.found = by_fields ? sentences_of_fields(surface, half, mirror, proposal.has_volume, by_wrap)
                               : sentences(surface, holds, half, mirror, proposal.has_volume, options.hold);
    if (cut)
        proposal.found.push_back(text("the cut of the half misses the plane by up to ", cut->deviation,
                                      " and is moved onto it (symmetry.snap)"));
    tell(wing, proposal.found);
    if (!options.reason.empty()) proposal.found.insert(proposal.found.begin(), options.reason);
    const MeanMotion mean = mean_motion(thickness, surface.checkup.diagonal, proposal.has_volume);
    const std::string farthest = farthest_motion_text(mean, surface.checkup.diagonal);
    const bool is_remeshed = options.way == ProposedWay::remeshed_shell;
    const bool is_mended = cut || proposal.is_dirty || is_remeshed || was_mended(surface);
    const std::string shown = case_file.filename().string();
    const std::string shell =
        "\n# The elastic shell: a thicker one bends less.\nshell:\n" +
        padded(text("  thickness: ", thickness_percent(surface.checkup), "%"), "of the diagonal") +
        (surface.couple ? padded("  nonmanifold: couple", "edges with more than two triangles") : "");
    proposal.yaml =
        "# Proposed by strake init from the surface alone. Next: strake check " + typed_path(shown) + ", strake run " +
        typed_path(shown) + ".\n# What a key means: strake explain KEY.\ncase: " + name_of_case(file) + "\n" +
        surface_text(path_from(file, case_file), stated_units(file), surface.checkup) + repair_text(surface) +
        (is_remeshed ? remesh_text(surface.checkup, options.reason) : "") + hold_of(options, holds) +
        (half ? symmetry_text(*half, cut) : "") + directions_text(wing, surface.checkup, proposal) +
        (by_wrap     ? wrap_text(proposal.num_triangles, mirror, options.reason, farthest)
         : by_fields ? fields_text(proposal.num_triangles, mirror, options.reason, farthest)
                     : shell + parameters_text(surface, mirror, options.hold, is_mended ? farthest : "")) +
        goal_text(mean, proposal.has_volume) + "\noptimize:\n" +
        padded(text("  budget: {evaluations: ", options.evaluations, "}"), "more: strake resume --evaluations +50");
    return proposal;
}

}  // namespace strake
