#include "core/error.hpp"
#include "core/formats/vtp_reader.hpp"
#include "core/mesh/geometry.hpp"
#include "core/patches/carried.hpp"
#include "core/text/file.hpp"
#include "optimize/run/stored_design.hpp"
#include "report/json_number.hpp"
#include "report/packed_array.hpp"
#include "report/patch_shares.hpp"
#include "report/report_parts.hpp"

#include <cmath>
#include <cstdio>

/// The shapes of the report: the start surface, the displacement of selected designs, and each patch's contribution.
namespace strake::page {
namespace {

namespace fs = std::filesystem;

constexpr double max_frame_bytes = 10e6;  ///< of all frames before compression
constexpr int max_frames = 40;
constexpr std::size_t max_patches = 5000;  ///< of a level on the page
constexpr double full_scale = 65535;

/// A data set of the ParaView series.
struct Frame {
    int evaluation = 0, level = 0;
    double objective = 0;
    TriMesh mesh;
    Points displacement, dJ_dv;
    std::vector<VtpField> others;  ///< one number for each vertex
};

fs::path frame_file(const fs::path& folder, int evaluation) {
    char name[40];
    std::snprintf(name, sizeof name, "series/design_%06d.vtp", evaluation);
    return folder / name;
}

std::vector<const JournalEvaluation*> designs_in_series(const RunFiles& run) {
    std::vector<const JournalEvaluation*> designs;
    std::error_code ignored;
    for (const JournalEvaluation& e : run.journal->evaluations())
        if (e.accepted && fs::is_regular_file(frame_file(run.folder, e.number), ignored)) designs.push_back(&e);
    return designs;
}

/// The first, the last, the last of each level, and others evenly spaced between them.
std::vector<const JournalEvaluation*> selected(const std::vector<const JournalEvaluation*>& all,
                                               std::size_t max_count) {
    if (all.size() <= max_count) return all;
    std::vector<char> is_chosen(all.size(), 0);
    std::size_t count = 0;
    const auto choose = [&](std::size_t i) {
        if (count < max_count && !is_chosen[i]) is_chosen[i] = 1, ++count;
    };
    choose(0);
    choose(all.size() - 1);
    for (std::size_t i = all.size() - 1; i-- > 0;)
        if (all[i]->level != all[i + 1]->level) choose(i);
    for (std::size_t k = 0; k < max_count; ++k) choose(k * (all.size() - 1) / std::max<std::size_t>(1, max_count - 1));
    std::vector<const JournalEvaluation*> out;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (is_chosen[i]) out.push_back(all[i]);
    return out;
}

Points rows_of(const VtpField& field) { return field.values.cols() == 3 ? Points(field.values) : Points(); }

Frame read_frame(const RunFiles& run, const JournalEvaluation& e) {
    const fs::path file = frame_file(run.folder, e.number);
    VtpFile data = parse_vtp(read_bytes(file), file.string());
    Frame frame{e.number, e.level, e.objective, std::move(data.surface.mesh), {}, {}, {}};
    for (VtpField& field : data.point_fields) {
        if (!field.values.allFinite())
            throw InputError(text(file.string(), ": a field contains a value that is not a number"));
        if (field.name == "displacement")
            frame.displacement = rows_of(field);
        else if (field.name == "objective_sensitivity")
            frame.dJ_dv = rows_of(field);
        else if (field.values.cols() == 1)
            frame.others.push_back(std::move(field));
    }
    if (frame.displacement.rows() != frame.mesh.vertices.rows())
        throw InputError(text(file.string(), ": has no displacement for each vertex"));
    return frame;
}

std::uint16_t quantum(double value, double low, double range) {
    const double q = range > 0 ? std::round((value - low) / range * full_scale) : 0;
    return static_cast<std::uint16_t>(std::clamp(q, 0.0, full_scale));
}

std::string packed_points(const Points& points, const Eigen::Vector3d& low, const Eigen::Vector3d& range) {
    std::vector<std::uint16_t> q;
    q.reserve(static_cast<std::size_t>(points.size()));
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        for (int c = 0; c < 3; ++c) q.push_back(quantum(points(i, c), low[c], range[c]));
    return packed_array(q, 3);
}

/// Vectors or numbers between -scale and scale; returns the scale.
double add_signed(Blobs& blobs, const std::string& name, const Points& vectors) {
    const double scale = vectors.size() ? vectors.cwiseAbs().maxCoeff() : 0;
    const Eigen::Vector3d low = Eigen::Vector3d::Constant(-scale), range = Eigen::Vector3d::Constant(2 * scale);
    blobs.emplace_back(name, packed_points(vectors, low, range));
    return scale;
}

Json add_numbers(Blobs& blobs, const std::string& name, const Eigen::VectorXd& values) {
    const double low = values.minCoeff(), high = values.maxCoeff();
    std::vector<std::uint16_t> q;
    q.reserve(static_cast<std::size_t>(values.size()));
    for (const double value : values) q.push_back(quantum(value, low, high - low));
    blobs.emplace_back(name, packed_array(q, 1));
    return {{"low", json_number(low)}, {"high", json_number(high)}, {"blob", name}};
}

/// dJ along the outward normal, per area: the effect of a small bump there. Independent of the mesh.
Eigen::VectorXd normal_sensitivity(const TriMesh& mesh, const Points& dJ_dv) {
    Points normal = Points::Zero(mesh.num_vertices(), 3);
    Eigen::VectorXd area = Eigen::VectorXd::Zero(mesh.num_vertices());
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Eigen::Vector3d a = mesh.vertices.row(mesh.triangles(t, 0)), b = mesh.vertices.row(mesh.triangles(t, 1)),
                              c = mesh.vertices.row(mesh.triangles(t, 2));
        const Eigen::Vector3d n = (b - a).cross(c - a) / 2;
        for (int k = 0; k < 3; ++k) {
            normal.row(mesh.triangles(t, k)) += n.transpose();
            area[mesh.triangles(t, k)] += n.norm() / 3;
        }
    }
    Eigen::VectorXd out(mesh.num_vertices());
    for (int v = 0; v < mesh.num_vertices(); ++v) {
        const double length = normal.row(v).norm();
        out[v] = length > 0 && area[v] > 0 ? dJ_dv.row(v).dot(normal.row(v)) / (length * area[v]) : 0;
    }
    return out;
}

Json add_surface(Blobs& blobs, const TriMesh& mesh) {
    const Eigen::Vector3d low = mesh.vertices.colwise().minCoeff(), high = mesh.vertices.colwise().maxCoeff();
    blobs.emplace_back("positions", packed_points(mesh.vertices, low, high - low));
    std::vector<std::uint32_t> corners(mesh.triangles.data(), mesh.triangles.data() + mesh.triangles.size());
    blobs.emplace_back("triangles", packed_array(corners, 3));
    return {{"vertices", mesh.num_vertices()},
            {"triangles", mesh.num_triangles()},
            {"low", {low.x(), low.y(), low.z()}},
            {"high", {high.x(), high.y(), high.z()}},
            {"diagonal", json_number((high - low).norm())}};
}

Json add_frame(Blobs& blobs, const Frame& frame) {
    const std::string number = std::to_string(frame.evaluation);
    Json out = {{"evaluation", frame.evaluation}, {"level", frame.level}, {"objective", json_number(frame.objective)}};
    out["blob"] = "moved_" + number;
    out["scale"] = json_number(add_signed(blobs, "moved_" + number, frame.displacement));
    out["fields"] = Json::object();
    if (frame.dJ_dv.rows() > 0)
        out["fields"]["sensitivity"] =
            add_numbers(blobs, "sensitivity_" + number, normal_sensitivity(frame.mesh, frame.dJ_dv));
    for (std::size_t k = 0; k < frame.others.size(); ++k)
        out["fields"][clean_lines(frame.others[k].name)] =
            add_numbers(blobs, "field_" + std::to_string(k) + "_" + number, frame.others[k].values.col(0));
    return out;
}

/// The tree of the run, and the patches that have variables in its best design.
struct Tree {
    PatchHierarchy patches;
    std::vector<std::pair<int, int>> front;
};

Tree tree_of(const RunFiles& run, const ReportSubject& subject, const TriMesh& start) {
    const int triangles = start.num_triangles();
    std::error_code ignored;
    Tree tree;
    const fs::path file = run.folder / "levels/best.design";
    if (fs::is_regular_file(file, ignored)) {
        StoredDesign design = read_design(file);
        tree = {std::move(design.tree), std::move(design.front)};
        const int last = subject.wrap_triangle.empty() ? -1 : *std::ranges::max_element(subject.wrap_triangle);
        if (last >= 0 && static_cast<int>(subject.wrap_triangle.size()) == triangles &&
            last < static_cast<int>(tree.patches.levels.at(0).label.size()))
            tree.patches = carried(tree.patches, subject.wrap_triangle, start);
    } else {
        tree.patches = subject.tree;
    }
    for (const PatchLevel& level : tree.patches.levels)
        if (static_cast<int>(level.label.size()) != triangles) return {};
    // Finer levels are unreadable for people.
    auto& levels = tree.patches.levels;
    while (!levels.empty() && levels.back().patches.size() > max_patches) levels.pop_back();
    return tree;
}

Json tree_json(const Tree& tree, const PatchShares& shares, Blobs& blobs) {
    Json levels = Json::array();
    const double total = tree.patches.levels.empty() ? 0 : shares.of(tree.patches.levels[0])[0].area;
    for (std::size_t k = 0; k < tree.patches.levels.size(); ++k) {
        const PatchLevel& level = tree.patches.levels[k];
        std::vector<std::uint16_t> label(level.label.begin(), level.label.end());
        blobs.emplace_back("label_" + std::to_string(k), packed_array(label, 1));
        const std::vector<PatchShare> of = shares.of(level);
        Json patches = Json::array();
        for (const Patch& patch : level.patches) {
            const PatchShare& share = of[static_cast<std::size_t>(patch.id)];
            const bool in_use = std::find(tree.front.begin(), tree.front.end(),
                                          std::pair(static_cast<int>(k), patch.id)) != tree.front.end();
            patches.push_back({{"name", patch.name},
                               {"parent", patch.parent},
                               {"triangles", share.triangles},
                               {"area", json_number(total > 0 ? share.area / total : 0)},
                               {"in_use", in_use},
                               {"contribution", json_number(share.contribution)},
                               {"mean", json_number(share.mean_outward)},
                               {"most", json_number(share.max_displacement)}});
        }
        levels.push_back({{"patches", patches}, {"blob", "label_" + std::to_string(k)}});
    }
    return levels;
}

}  // namespace

Json shapes_json(const RunFiles& run, const ReportSubject& subject, Blobs& blobs) {
    const std::vector<const JournalEvaluation*> designs = designs_in_series(run);
    TriMesh start = subject.surface;
    std::optional<PatchShares> shares;
    Json frames = Json::array();
    if (!designs.empty()) {
        const Frame first = read_frame(run, *designs.front());
        if (start.num_vertices() == 0) start = with_vertices(first.mesh, first.mesh.vertices - first.displacement);
        const double bytes = 8.0 * static_cast<double>(std::max(1, start.num_vertices()));
        const int max_count = std::clamp(static_cast<int>(max_frame_bytes / bytes), 2, max_frames);
        shares.emplace(start);
        for (const JournalEvaluation* e : selected(designs, static_cast<std::size_t>(max_count))) {
            const Frame frame = read_frame(run, *e);
            if (frame.mesh.triangles.rows() != start.triangles.rows() ||
                frame.mesh.vertices.rows() != start.vertices.rows())
                throw InputError(
                    text(frame_file(run.folder, e->number).string(), ": does not have the surface of this run"));
            shares->add(frame.displacement, frame.dJ_dv, frame.objective);
            frames.push_back(add_frame(blobs, frame));
        }
    }
    if (start.num_triangles() == 0) return nullptr;
    if (!shares) shares.emplace(start);
    Json out;
    out["surface"] = add_surface(blobs, start);
    out["pictures"] = pictures_json(start, best_vertices(run.folder), subject);
    out["frames"] = frames;
    out["accepted"] = designs.size();
    const Tree tree = tree_of(run, subject, start);
    out["tree"] = tree_json(tree, *shares, blobs);
    out["explained"] = json_number(shares->explained());
    out["change"] = json_number(shares->change());
    return out;
}

}  // namespace strake::page

namespace strake {

bool has_shapes(const std::filesystem::path& folder) {
    std::error_code ignored;
    std::filesystem::directory_iterator at(folder / "series", ignored);
    return !ignored && at != std::filesystem::directory_iterator() &&
           std::filesystem::is_regular_file(folder / "levels/best.design", ignored);
}

}  // namespace strake
