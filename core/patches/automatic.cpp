#include "core/patches/automatic.hpp"

#include "core/error.hpp"
#include "core/patches/cutter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace strake {
namespace {

constexpr double degree = std::numbers::pi / 180;

void check(const AutomaticLevels& options) {
    if (options.patches_per_level.empty()) throw InvalidInput("automatic levels: patches_per_level is empty");
    for (std::size_t k = 0; k < options.patches_per_level.size(); ++k) {
        const int wanted = options.patches_per_level[k], above = k > 0 ? options.patches_per_level[k - 1] : 0;
        if (wanted < 1 || wanted < above)
            throw InvalidInput(
                text("automatic levels: patches_per_level[", k, "] = ", wanted, " must be >= ", std::max(1, above)));
    }
    if (options.max_share.empty()) throw InvalidInput("automatic levels: max_share is empty");
    for (std::size_t k = 0; k < options.max_share.size(); ++k)
        if (!(options.max_share[k] > 0 && options.max_share[k] <= 1))
            throw InvalidInput(
                text("automatic levels: max_share[", k, "] = ", options.max_share[k], " must be in (0, 1]"));
}

/// One level being made: which patches of the level above are cut, and into what.
struct LevelCut {
    const Body& body;
    const PatchLevel& above;
    const std::vector<double>& due;  ///< target areas of the patches above
    const std::vector<char>& chosen;
    int wanted;
    double max_share, min_area;

    /// Number of parts from creases of at least `tau_deg` alone.
    int crease_parts(double tau_deg) const {
        const Creases creases = creases_at(tau_deg);
        Cutter cutter(body, creases, min_area);
        int count = 0;
        for (const Patch& p : above.patches)
            count += chosen[p.id] ? static_cast<int>(cutter.along_creases(p.triangles, parts_of(p)).size()) : 1;
        return count;
    }

    /// Pieces by parent.
    std::vector<std::vector<Piece>> cut(double tau_deg) const {
        const Creases creases = creases_at(tau_deg);
        Cutter cutter(body, creases, min_area);
        std::vector<std::vector<Piece>> pieces(above.patches.size());
        for (const Patch& p : above.patches) {
            const Piece whole{p.triangles, due[p.id]};
            pieces[p.id] = chosen[p.id] ? cutter.cut(whole, parts_of(p)) : std::vector<Piece>{whole};
        }
        keep_shares(cutter, pieces);
        keep_count(cutter, pieces);
        return pieces;
    }

    Creases creases_at(double tau_deg) const {
        return persistent_creases(body, tau_deg * degree, 0.05 * std::sqrt(body.area / wanted));
    }
    int parts_of(const Patch& p) const {
        const int least = static_cast<int>(std::ceil(p.area / (max_share * body.area) - 1e-6));
        return std::max(worth(wanted * due[p.id] / body.area), least);
    }
    void keep_shares(Cutter& cutter, std::vector<std::vector<Piece>>& pieces) const;
    void keep_count(Cutter& cutter, std::vector<std::vector<Piece>>& pieces) const;
    void halve(Cutter& cutter, std::vector<Piece>& siblings, std::size_t i) const {
        const std::vector<Piece> halves = cutter.cut(siblings[i], 2);
        siblings[i] = halves[0];
        siblings.insert(siblings.end(), halves.begin() + 1, halves.end());
    }
};

/// Halves pieces above their share of the area (except single triangles).
void LevelCut::keep_shares(Cutter& cutter, std::vector<std::vector<Piece>>& pieces) const {
    for (std::size_t p = 0; p < pieces.size(); ++p)
        for (std::size_t i = 0; chosen[p] && i < pieces[p].size();) {
            const std::size_t before = pieces[p].size();
            if (cutter.area(pieces[p][i].triangles) > max_share * body.area) halve(cutter, pieces[p], i);
            if (pieces[p].size() == before) ++i;
        }
}

/// Keeps between half and twice the target number: halves the largest pieces, or joins the smallest with siblings.
void LevelCut::keep_count(Cutter& cutter, std::vector<std::vector<Piece>>& pieces) const {
    const auto extreme = [&](bool largest, std::size_t min_siblings) {
        std::array<int, 2> best{-1, -1};
        double best_area = 0;
        for (std::size_t p = 0; p < pieces.size(); ++p)
            for (std::size_t i = 0; chosen[p] && pieces[p].size() >= min_siblings && i < pieces[p].size(); ++i) {
                const double a = cutter.area(pieces[p][i].triangles);
                if (best[0] < 0 || (largest ? a > best_area : a < best_area))
                    best = {static_cast<int>(p), static_cast<int>(i)}, best_area = a;
            }
        return best;
    };
    const auto count = [&] {
        int sum = 0;
        for (const auto& siblings : pieces) sum += static_cast<int>(siblings.size());
        return sum;
    };
    const bool all = std::count(chosen.begin(), chosen.end(), 0) == 0;
    for (int before = 0; all && before != count() && 2 * count() < wanted;) {
        before = count();
        if (const auto [p, i] = extreme(true, 1); p >= 0) halve(cutter, pieces[p], i);
    }
    for (int before = 0; before != count() && count() > 2 * wanted;) {
        before = count();
        if (const auto [p, i] = extreme(false, 2); p >= 0)
            pieces[p] = cutter.without_smallest(above.patches[p].triangles, pieces[p]);
    }
}

/// Largest of three thresholds at which creases alone give the target number, else the smallest, which decreases with
/// the level (k = 1, 2, …). Smaller angles depend on the edge length.
double threshold(const LevelCut& level, int k, double sharp_deg, double above_deg) {
    const double lowest = std::clamp(sharp_deg, 10.0, 53.0) * (k <= 4 ? (10 - k) / 8.0 : 0.75 * std::pow(0.9, k - 4));
    if (level.crease_parts(lowest) < level.wanted) return lowest;
    for (const double higher : {lowest + 30, lowest + 15})
        if (higher < above_deg && level.crease_parts(higher) >= level.wanted) return higher;
    return lowest;
}

/// `split` with sizes measured by area.
std::vector<char> chosen_by_area(const PatchLevel& level, const Split& split) {
    const auto* largest = std::get_if<SplitLargest>(&split);
    if (!largest) return chosen_patches(level, split);
    std::vector<char> chosen = chosen_patches(level, split);  // checks the count
    std::vector<int> order(level.patches.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return level.patches[a].area > level.patches[b].area; });
    chosen.assign(chosen.size(), 0);
    for (std::size_t i = 0; i < order.size() && i < static_cast<std::size_t>(largest->count); ++i) chosen[order[i]] = 1;
    return chosen;
}

/// Smooth where a triangle has a vertex that is smooth at the threshold, as at given thresholds (step 3).
PatchClass class_of(const SurfaceFeatures& features, const TriangleSet& set, double tau) {
    for (const int t : set)
        for (int k = 0; k < 3; ++k)
            if (!is_nonsmooth(features.vertices[features.mesh.triangles(t, k)], tau)) return PatchClass::smooth;
    return PatchClass::nonsmooth;
}

}  // namespace

void refine_automatically(PatchHierarchy& tree, const Body& body, std::vector<double>& due,
                          const std::vector<char>& chosen, const AutomaticLevels& options) {
    const std::size_t k = tree.levels.size() - 1;
    const PatchLevel& above = tree.levels.back();
    const LevelCut level{body,
                         above,
                         due,
                         chosen,
                         options.patches_per_level.at(k),
                         options.max_share[std::min(k, options.max_share.size() - 1)],
                         options.min_patch_percent / 100 * body.area};
    const double tau_deg =
        threshold(level, static_cast<int>(k) + 1, options.sharp_angle_deg, k > 0 ? above.angle_deg : 91);
    std::vector<int> label(body.mesh().num_triangles());
    std::vector<PatchClass> classes;
    const auto pieces = level.cut(tau_deg);
    for (const Patch& parent : above.patches)
        for (const Piece& piece : pieces[parent.id]) {
            for (const int t : piece.triangles) label[t] = static_cast<int>(classes.size());
            classes.push_back(chosen[parent.id] ? class_of(body.features, piece.triangles, tau_deg * degree)
                                                : parent.patch_class);
        }
    append_level(tree, body.features, tau_deg, label, classes);
    due.resize(tree.levels.back().patches.size());
    for (const auto& siblings : pieces)
        for (const Piece& piece : siblings) due[tree.levels.back().label[piece.triangles.front()]] = piece.due;
}

PatchHierarchy segment_automatically(const TriMesh& mesh, const Adjacency& adjacent, const AutomaticLevels& options) {
    check(options);
    PatchHierarchy tree = whole_surface(mesh);
    const SurfaceFeatures features = surface_features(mesh, adjacent);
    const Body body = measured(features);
    std::vector<double> due{body.area};
    while (tree.levels.size() <= options.patches_per_level.size()) {
        std::vector<char> chosen = chosen_by_area(tree.levels.back(), options.split);
        if (tree.levels.size() == 1) chosen.assign(1, 1);  // level 1 always splits the whole surface
        refine_automatically(tree, body, due, chosen, options);
    }
    return tree;
}

}  // namespace strake
