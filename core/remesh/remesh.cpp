#include "core/remesh/remesh.hpp"

#include "core/error.hpp"
#include "core/remesh/crossings.hpp"
#include "core/remesh/passes.hpp"
#include "core/remesh/prepare_base.hpp"
#include "core/remesh/sizing.hpp"

#include <chrono>
#include <limits>
#include <numbers>
#include <numeric>

namespace strake {
namespace {

constexpr double radians = std::numbers::pi / 180;
constexpr double worth_polishing = 0.8;     ///< quality below which a triangle's corners are moved one by one
constexpr double worth_approaching = 0.03;  ///< allowed deviation of an edge from the input, relative to its length
constexpr double evenly_shaped = 0.977;     ///< mean quality above which lengths no longer change
constexpr double min_finished = 0.97;       ///< mean quality above which only the finish is needed
constexpr double min_graded = 0.93;         ///< the same, with much shorter edges where the shape needs them
constexpr double doubled = 2;               ///< times the least number of intersections
constexpr double few_gaps = 0.02;           ///< share of removed triangles tolerated without compaction
constexpr int finishing = 3;                ///< iterations
constexpr double too_long = 4.0 / 3, too_short = 4.0 / 5;

void check(bool good, const char* field, double value, const char* limit) {
    if (!good) throw InvalidInput(text("remesh: ", field, " = ", value, " must be ", limit));
}

/// Edge lengths of a surface, relative to the target.
struct Lengths {
    double longer = 0, shorter = 0;  ///< shares of the edges that are so by too much
    double unlimited = 0;            ///< share where the shape asks for nothing shorter
    double mean = 0;                 ///< of these
    double shortest = std::numeric_limits<double>::infinity();
};

/// One call of remesh().
class Remesher {
public:
    /// @param frozen triangles of the input, as BaseSurface numbers them, that stay unchanged; empty: none
    Remesher(const TriMesh& given, const RemeshOptions& options, const RemeshProgress& progress,
             const std::vector<char>& frozen)
        : given_(given),
          options_(options),
          progress_(progress),
          base_(base_surface(given, options.angle_deg * radians, options.edge_length, frozen)) {
        result_.edge_length = base_.edge_length;
        const double triangles = base_.area / (0.4330127 * result_.edge_length * result_.edge_length);
        if (!(triangles <= options.max_triangles))
            throw InvalidInput(text("remesh: an edge length of ", result_.edge_length, " makes about ", triangles,
                                    " triangles, more than ", options.max_triangles, "; choose a longer one"));
        result_.expected_triangles = triangles;
        max_expected_ = std::max(triangles, static_cast<double>(base_.tri.size()));
        // The mean edge comes out 1.5 % longer than what splits and collapses aim at.
        const double wished = 0.985 * result_.edge_length, admitted = longest_beside_features(base_);
        if (options.shortest_edge > wished)
            throw InvalidInput(
                text("remesh: shortest edge = ", options.shortest_edge, " must be at most the edge length, ", wished));
        result_.features_are_dense = wished > admitted;
        const double longest = std::min(wished, admitted);
        const double shortest = options.shortest_edge > 0 ? options.shortest_edge : 0.1 * longest;
        sizing_ = sizing_of(base_, longest, std::min(shortest, longest), options.gradation, options.chord_error);
        const double turn = options.turn_deg * radians;
        const int threads = options.threads > 0 ? options.threads : num_threads(max_threads);
        firm_ = {0.9e-4 * base_.diagonal, std::cos(22 * radians), std::cos(turn), std::sin(turn), threads};
        loose_ = firm_;
        loose_.cos_natural = std::cos(42 * radians);
        mesh_ = working_mesh(base_);
        update_sizes(mesh_, sizing_);
    }

    RemeshResult run() {
        const Lengths given = lengths();
        if (is_graded_as_wanted(given)) {
            input_ = Input::graded;
        } else {
            for (const double factor : {0.01, 0.1, 0.4})
                if (given.shortest < factor) collapse_short(mesh_, firm_, factor, too_long);
            shorten_needles();
            if (has_wanted_lengths() && mean_quality_inside() > min_finished) input_ = Input::even;
        }
        if (is_finished()) accept_lengths();
        for (int i = first_iteration(); i <= options_.iterations && !result_.cancelled; ++i) {
            iterate();
            note_limits(i);
            const int finish = options_.iterations - finishing;
            if (is_finished() || i < 2 || i >= finish || !has_converged()) continue;
            if (i + 1 < finish) note_limits(finish);
            skipped_ = finish - i;
            i = finish;
        }
        if (!result_.cancelled) disentangle();
        count();
        result_.mesh = as_mesh(mesh_, given_.group_names);
        return std::move(result_);
    }

    /// Whether the input is an earlier result at this length, with much shorter edges where the shape needs them. The
    /// iterations would remove these edges and not restore all of them.
    bool is_graded_as_wanted(const Lengths& given) {
        if (options_.chord_error > 0) return false;
        if (given.longer >= 0.015 || given.shorter < 0.15 || find_mean_quality_inside() < min_graded) return false;
        // Bent rims count too, unless so few edges are left then that none tell what length was wanted.
        for (const double slack : {std::numeric_limits<double>::infinity(), firm_.chord_slack}) {
            const std::vector<char> is_tight = tight_places(base_, sizing_.longest, slack);
            for (int v = 0; v < mesh_.num_vertices(); ++v)
                if (is_tight[v]) mesh_.limit[v] = std::max(sizing_.shortest, 1.05 * mean_edge_at(v));
            update_sizes(mesh_, sizing_);
            const Lengths found = lengths();
            if (found.shorter < 0.2 && found.unlimited > 0.1 && std::abs(found.mean - 1) < 0.07) return true;
            mesh_.limit.assign(mesh_.limit.size(), std::numeric_limits<double>::infinity());
            update_sizes(mesh_, sizing_);
        }
        return false;
    }

    bool is_input_as_wanted() {
        return is_graded_as_wanted(lengths()) || (has_wanted_lengths() && mean_quality_inside() > min_finished);
    }

    /// Intersections left by run() have a cause in the shape: other lengths would leave some, too.
    bool are_of_shape() const { return are_of_shape_; }
    /// Restores the input around intersections left by run(). @return number of restored triangles
    int freeze(std::vector<char>& frozen) {
        frozen.resize(base_.tri.size(), 0);
        for (const auto& pair : crossings_.fresh(mesh_))
            crossings_.mark_beside(mesh_, pair, 0.25 * base_.edge_length, frozen);
        return static_cast<int>(std::count(frozen.begin(), frozen.end(), 1));
    }

private:
    /// What is given: to be remeshed; as wanted, so that only the finish is done; or that with edges much shorter where
    /// the shape asks for it.
    enum class Input { raw, even, graded };
    bool is_finished() const { return input_ != Input::raw; }

    int first_iteration() const {
        if (input_ == Input::graded) return options_.iterations;
        return is_finished() ? std::max(1, options_.iterations - finishing + 1) : 1;
    }

    /// Splitting adjacent long needles to the target length at once would make far too many triangles.
    void shorten_needles() {
        double cuts = 0;
        for (int h = 0; h < static_cast<int>(mesh_.corner.size()); ++h)
            if (mesh_.corner[h] >= 0 && mesh_.twin[h] < h) cuts += std::sqrt(mesh_.length2(h)) / sizing_.longest;
        double scale = 1;
        while (cuts > 3 * scale * max_expected_) scale *= 2;
        for (; scale > 1; scale /= 2) {
            split_long(mesh_, scale * too_long);
            for (int k = 0; k < 2; ++k) collapse_short(mesh_, firm_, too_short, scale * too_long);
            mesh_.compact();
            flip_edges(mesh_, loose_);
        }
    }

    void iterate() {
        RemeshRecord record{};
        record.iteration = static_cast<int>(result_.records.size()) + 1;
        const int step = record.iteration + skipped_;
        const double tight = tightness(step);
        const double longest = 1 + tight * (too_long - 1), shortest = 1 - tight * (1 - too_short);
        mean_quality_ = -1;
        record.splits = split_long(mesh_, longest);
        record.collapses = collapse_short(mesh_, firm_, shortest, too_long);
        mesh_.compact(few_gaps);
        record.flips = flip_edges(mesh_, loose_);
        const bool is_finish = is_finished() || step + finishing > options_.iterations;
        const Towards goal = is_finish ? Towards::equilateral : Towards::centres;
        if (is_finish || !(tight < 1))
            smooth(mesh_, loose_, goal);  // half of it has been split or collapsed: once suffices
        record.largest_move = smooth(mesh_, loose_, goal);
        if (goal == Towards::equilateral) {
            polish(mesh_, loose_, worth_polishing);
            if (step == options_.iterations) {
                flip_edges(mesh_, firm_);
                polish(mesh_, loose_, worth_polishing);
                approach(mesh_, loose_, worth_approaching, 0.9 * options_.angle_deg * radians);
                restore_folds(mesh_, loose_, options_.angle_deg * radians);
            }
        }
        record.triangles = mesh_.num_alive();
        record.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
        result_.records.push_back(record);
        if (progress_ && !progress_(record)) result_.cancelled = true;
    }

    /// Shrinks the range of tolerated lengths. Evenly stretched meshes lie within it and would stay unchanged; a
    /// finished mesh may exceed it.
    double tightness(int iteration) {
        if (is_finished()) return input_ == Input::graded ? 2 : 1.3;
        if (iteration > 7 || !is_quiet()) return 1;
        const double mean = mean_quality_inside();
        return mean >= evenly_shaped ? 1 : iteration == 7 && mean < 0.968 ? 0.3 : 0.5;
    }

    Lengths lengths() const {
        Lengths result;
        int all = 0;
        for (int h = 0; h < static_cast<int>(mesh_.corner.size()); ++h) {
            if (mesh_.corner[h] < 0 || mesh_.twin[h] > h) continue;
            const double wanted = mesh_.wanted(mesh_.from(h), mesh_.to(h)),
                         share = std::sqrt(mesh_.length2(h)) / wanted;
            result.longer += share > too_long;
            result.shorter += share < too_short;
            result.shortest = std::min(result.shortest, share);
            ++all;
            if (wanted < 0.98 * sizing_.longest) continue;
            ++result.unlimited;
            result.mean += share;
        }
        result.mean /= std::max(result.unlimited, 1.0);
        result.longer /= all, result.shorter /= all, result.unlimited /= all;
        return result;
    }
    /// Nearly all edges of the input have the target length; some may be shorter where the shape needs it.
    bool has_wanted_lengths() const {
        const Lengths found = lengths();
        return found.longer < 0.01 && found.shorter < 0.15;
    }
    double mean_edge_at(int v) const {
        double sum = 0;
        mesh_.neighbours(v, [&](int u) { sum += (mesh_.pos[u] - mesh_.pos[v]).norm(); });
        return sum / mesh_.valence[v];
    }
    /// A finished surface keeps its lengths; its vertices move only near changes.
    void accept_lengths() {
        for (int v = 0; v < mesh_.num_vertices(); ++v) {
            if (mesh_.half[v] < 0) continue;
            const double mean = mean_edge_at(v);
            if (mean < 0.9 * mesh_.size[v]) mesh_.limit[v] = std::max(sizing_.shortest, 1.05 * mean);
        }
        update_sizes(mesh_, sizing_);
        if (input_ == Input::graded)  // its short edges shorten no others
            for (int v = 0; v < mesh_.num_vertices(); ++v)
                if (mesh_.half[v] >= 0) mesh_.size[v] = std::max(mesh_.size[v], mean_edge_at(v));
        mesh_.settled.assign(mesh_.settled.size(), 1);
    }
    /// Whether very few edges were split or collapsed.
    bool is_quiet() const {
        if (result_.records.empty()) return false;
        const RemeshRecord& last = result_.records.back();
        return last.splits + last.collapses < 0.08 * last.triangles;
    }
    /// Whether only the finish remains.
    bool has_converged() {
        const RemeshRecord& last = result_.records.back();
        return last.splits + last.collapses < 0.02 * last.triangles && mean_quality_inside() >= evenly_shaped;
    }
    /// Of the triangles away from features, as the last iteration left them.
    double mean_quality_inside() {
        if (mean_quality_ < 0) mean_quality_ = find_mean_quality_inside();
        return mean_quality_;
    }
    double find_mean_quality_inside() const {
        double sum = 0;
        int count = 0;
        for (int t = 0; t < mesh_.num_triangles(); ++t) {
            if (!mesh_.is_alive(t)) continue;
            bool is_inside = true;
            for (int h = 3 * t; h < 3 * t + 3; ++h)
                is_inside = is_inside && mesh_.role[mesh_.corner[h]] == VertexRole::free;
            if (!is_inside) continue;
            sum += mesh_.quality(t);
            ++count;
        }
        return count > 0 ? sum / count : 1;
    }

    /// Shorter edges where the shape needs them; after the first iterations have settled, and early enough for
    /// iterations to follow.
    void note_limits(int i) {
        if (!takes_limits_) return;
        int count = 0;
        std::vector<double> before = mesh_.limit;
        const bool is_much = mesh_.num_triangles() > 12 * max_expected_;  // thin places everywhere: would never end
        if (!is_much && i >= 4 && i + 2 <= options_.iterations) count += note_thin_places(mesh_, sizing_, i >= 6);
        if (!is_much && i % 3 == 1 && i > 1 && i + 2 <= options_.iterations) {
            const double far = std::max(5e-4 * base_.diagonal, 0.1 * sizing_.longest);
            count += note_far_edges(mesh_, sizing_, far, firm_.threads);
        }
        if (count > 0 || !sizing_.on_base.empty()) update_sizes(mesh_, sizing_);
        constexpr double takes_seconds = 1e5;
        if (count == 0 || expected_triangles() < std::max(6 * max_expected_, takes_seconds)) return;
        // Wires, thin all over, would become surfaces of a hundred thousand triangles and still be thin.
        mesh_.limit = std::move(before);
        takes_limits_ = false;
        update_sizes(mesh_, sizing_);
    }
    /// Expected number of triangles at the target lengths.
    double expected_triangles() const {
        double sum = 0;
        for (int t = 0; t < mesh_.num_triangles(); ++t) {
            if (!mesh_.is_alive(t)) continue;
            double longest = 0, wanted = 0;
            for (int h = 3 * t; h < 3 * t + 3; ++h) {
                longest = std::max(longest, std::sqrt(mesh_.length2(h)));
                wanted += mesh_.size[mesh_.corner[h]] / 3;
            }
            const double height = longest > 0 ? mesh_.area_vector2(t).norm() / longest : 0;
            sum += std::max(1.0, longest / wanted) * std::max(1.0, height / wanted);
        }
        return sum;
    }

    /// Shortens edges at new self-intersections while that helps. Where in the end there are twice as many as there
    /// were the sheets are nearer to each other than any edge there.
    void disentangle() {
        WorkingMesh best;
        result_.new_intersections = std::numeric_limits<int>::max();
        for (int round = 0, in_vain = 0; !result_.cancelled; ++round) {
            mesh_.compact();
            const std::vector<std::array<int, 2>> pairs = crossings_.fresh(mesh_);
            const int count = static_cast<int>(pairs.size());
            if (count == 0) {
                result_.new_intersections = 0;
                return;
            }
            in_vain = count > 0.75 * result_.new_intersections ? in_vain + 1 : 0;
            if (count < result_.new_intersections) {
                result_.new_intersections = count;
                best = mesh_;
            }
            const bool is_hopeless = count > 0.05 * mesh_.num_triangles();  // wires, and sheets that lie on each other
            are_of_shape_ = count > doubled * result_.new_intersections;
            if (round == 4 || in_vain == 2 || is_hopeless) break;
            for (const auto& pair : pairs) shorten(pair);
            update_sizes(mesh_, sizing_);
            for (int k = 0; k < 2 && !result_.cancelled; ++k) iterate();
        }
        if (!result_.cancelled) mesh_ = std::move(best);
    }
    void shorten(const std::array<int, 2>& pair) {
        for (const int t : pair)
            for (int h = 3 * t; h < 3 * t + 3; ++h) {
                const int v = mesh_.corner[h];
                const double limit = std::max(0.3 * sizing_.shortest, 0.5 * mesh_.size[v]);
                mesh_.limit[v] = std::min(mesh_.limit[v], limit);
            }
    }

    void count() {
        for (const FeatureEdge& edge : mesh_.features) {
            if (edge.curve < 0) continue;
            if (edge.kind == FeatureKind::crease || edge.kind == FeatureKind::held_crease) ++result_.crease_edges;
            if (edge.kind == FeatureKind::boundary) ++result_.boundary_edges;
            if (edge.kind == FeatureKind::border) ++result_.border_edges;
            if (edge.kind == FeatureKind::kept) ++result_.kept_edges;
        }
        for (const VertexRole role : mesh_.role) result_.corners += role == VertexRole::fixed;
    }

    const TriMesh& given_;
    const RemeshOptions& options_;
    const RemeshProgress& progress_;
    const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    const BaseSurface base_;
    Sizing sizing_;
    bool takes_limits_ = true;  ///< thin places may still request shorter edges
    Input input_ = Input::raw;
    StepGuard firm_, loose_;  ///< of collapses; of flips and smoothing
    WorkingMesh mesh_;
    double mean_quality_ = -1;   ///< once it is known
    int skipped_ = 0;            ///< iterations, as there was nothing left to do but the finish
    double max_expected_ = 0;    ///< triangles, of the input or at the wanted length
    bool are_of_shape_ = false;  ///< intersections that are left
    Crossings crossings_{base_};
    RemeshResult result_;
};

/// Of edges, where most of the area is; 0: hardly longer than their mean, or the triangles are not well shaped.
double typical_edge_length(const TriMesh& mesh) {
    const int m = mesh.num_triangles();
    if (m == 0 || mesh.triangles.minCoeff() < 0 || mesh.triangles.maxCoeff() >= mesh.num_vertices()) return 0;
    const auto length = [&](int t, int k) {
        return (mesh.vertices.row(mesh.triangles(t, (k + 1) % 3)) - mesh.vertices.row(mesh.triangles(t, k))).norm();
    };
    double quality = 0, mean = 0;
    for (int t = 0; t < m; ++t) {
        quality += shape_quality(mesh.vertices.row(mesh.triangles(t, 0)), mesh.vertices.row(mesh.triangles(t, 1)),
                                 mesh.vertices.row(mesh.triangles(t, 2)));
        for (int k = 0; k < 3; ++k) mean += length(t, k) / (3.0 * m);
    }
    if (!(quality > 0.93 * m && mean > 0 && std::isfinite(mean))) return 0;
    constexpr int bins = 80, width = 7;  // of 5 %; of edges around the wanted length
    std::array<double, bins> area{}, sum{};
    for (int t = 0; t < m; ++t)
        for (int k = 0; k < 3; ++k) {
            const double l = length(t, k);
            const int i = static_cast<int>(std::clamp(20 * std::log(l / mean) + bins / 2, 0.0, bins - 1.0));
            area[i] += l * l;
            sum[i] += l * l * l;
        }
    double most = 0, common = 0;
    for (int i = 0; i + width <= bins; ++i) {
        const double all = std::accumulate(&area[i], &area[i] + width, 0.0);
        if (!(all > most)) continue;
        most = all;
        common = std::accumulate(&sum[i], &sum[i] + width, 0.0) / all;
    }
    return common > 1.035 * mean ? common : 0;
}

/// The mean of its edges; what has been remeshed at a length already, with shorter edges where the shape asks for
/// them, has that one.
double automatic_length(const TriMesh& given, const RemeshOptions& options, const RemeshProgress& progress) {
    RemeshOptions tried = options;
    tried.edge_length = typical_edge_length(given);
    if (!(tried.edge_length > 0) || options.shortest_edge > 0.98 * tried.edge_length) return 0;
    tried.max_triangles = std::numeric_limits<int>::max();
    return Remesher(given, tried, progress, {}).is_input_as_wanted() ? tried.edge_length : 0;
}

}  // namespace

void validate(const RemeshOptions& o) {
    check(o.edge_length >= 0 && std::isfinite(o.edge_length), "edge_length", o.edge_length, "> 0, or 0 for automatic");
    check(o.angle_deg > 0 && o.angle_deg <= 90, "angle_deg", o.angle_deg, "in (0, 90]");
    check(o.iterations >= 1 && o.iterations <= 1000, "iterations", o.iterations, "in [1, 1000]");
    check(o.chord_error >= 0 && std::isfinite(o.chord_error), "chord_error", o.chord_error, "> 0, or 0 for uniform");
    check(o.shortest_edge >= 0 && std::isfinite(o.shortest_edge), "shortest_edge", o.shortest_edge,
          "> 0, or 0 for automatic");
    check(o.gradation > 0 && o.gradation <= 1, "gradation", o.gradation, "in (0, 1]");
    check(o.turn_deg > 0 && o.turn_deg <= 90, "turn_deg", o.turn_deg, "in (0, 90]");
    check(o.max_triangles >= 4, "max_triangles", o.max_triangles, ">= 4");
    check(o.threads >= 0, "threads", o.threads, ">= 0");
}

std::string short_edge_words(const RemeshResult& result) {
    constexpr double far_more = 3;  // as many triangles; bends and thin places may double them
    const int made = result.mesh.num_triangles();
    if (!result.features_are_dense && !(made > far_more * std::max(result.expected_triangles, 100.0))) return "";
    std::string what, remedy;
    const auto add = [](std::string& list, const char* words, const char* between) {
        list += text(list.empty() ? "" : between, words);
    };
    if (result.boundary_edges > 0) {
        add(what, "open boundaries", " and ");
        add(remedy, "close the holes (strake repair --holes)", ", or ");
    }
    if (result.crease_edges > 0) {
        add(what, "creases", " and ");
        add(remedy, "raise the crease angle (--angle)", ", or ");
    }
    if (result.border_edges > 0) add(what, "borders between parts", " and ");
    if (what.empty()) what = "bends and narrow strips";
    return text(what, " keep edges shorter than ", result.edge_length, ": ", made,
                " triangles, where that length alone makes about ", std::round(result.expected_triangles),
                remedy.empty() ? "" : "; ", remedy);
}

RemeshResult remesh(const TriMesh& given, const RemeshOptions& options, const RemeshProgress& progress) {
    validate(options);
    // A few intersections at one length rarely occur at another; where they always do, or are many, which has a cause
    // in the shape, the input stays unchanged.
    constexpr std::array<double, 2> other_lengths{0.98, 1.02};
    constexpr int few = 20;
    RemeshOptions tried = options;
    if (options.edge_length == 0) tried.edge_length = automatic_length(given, options, progress);
    RemeshResult best;
    std::vector<char> tangled, frozen;
    for (std::size_t attempt = 0, count = 0; attempt < 4 + other_lengths.size(); ++attempt) {
        Remesher remesher(given, tried, progress, frozen);
        RemeshResult result = remesher.run();
        result.frozen_triangles = frozen.empty() ? 0 : static_cast<int>(count);
        const int left = result.new_intersections;
        if (attempt > 0) result.edge_length = best.edge_length;
        if (attempt == 0 || left < best.new_intersections || result.cancelled) best = std::move(result);
        if (left == 0 || best.cancelled) break;
        const bool is_as_wanted = attempt == 0 || attempt > other_lengths.size();
        if (is_as_wanted) count = static_cast<std::size_t>(remesher.freeze(tangled));
        const bool is_local = static_cast<double>(count) <= 0.05 * given.num_triangles();
        if (!is_local) break;  // not here and there
        if (attempt == 0 && (left > few || remesher.are_of_shape())) attempt = other_lengths.size();
        const bool tries_length = attempt < other_lengths.size();
        tried.edge_length = (tries_length ? other_lengths[attempt] : 1) * best.edge_length;
        tried.max_triangles = std::numeric_limits<int>::max();
        if (!tries_length) frozen = tangled;
    }
    return best;
}

}  // namespace strake
