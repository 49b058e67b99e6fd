#include "casefile/build/problem_builder.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/wrap/wrap_map.hpp"
#include "optimize/space/mirror.hpp"

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>

/// `wrap`: what is elastic in the place of the body, and what the case says of the body carried over to it.
namespace strake {
namespace {

constexpr int held_rings = 3;           ///< edges by which the wrap is held beyond what of the body is
constexpr double stated_seconds = 600;  ///< for a wrap of stated fineness; the automatic one has its own limit
constexpr double worth_saying = 0.01;   ///< share of the area that is thinner than alpha

std::string seventeen(double value) {
    std::ostringstream out;
    out.imbue(std::locale::classic());
    out.precision(17);
    out << value;
    return out.str();
}

/// Marks grow by one ring: triangles that share a vertex with those marked.
std::vector<char> grown(const TriMesh& mesh, const std::vector<char>& marks) {
    std::vector<char> at(static_cast<std::size_t>(mesh.num_vertices()), 0), more = marks;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (marks[static_cast<std::size_t>(t)])
            for (int k = 0; k < 3; ++k) at[static_cast<std::size_t>(mesh.triangles(t, k))] = 1;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k)
            more[static_cast<std::size_t>(t)] |= at[static_cast<std::size_t>(mesh.triangles(t, k))];
    return more;
}

double percent(double share) { return std::round(1000 * share) / 10; }

}  // namespace

void ProblemBuilder::make_wrap() {
    if (!case_.wrap || !case_.has_shell) return;
    const WrapEntry& entry = *case_.wrap;
    const double diagonal = start_.diagonal;
    WrapOptions options;
    if (entry.alpha) {
        options.alpha = entry.alpha->in(diagonal);
        options.max_attempts = 1;
        options.max_seconds = stated_seconds;
    }
    if (entry.offset) options.offset = entry.offset->in(diagonal);
    if (entry.edge_length) options.edge_length = entry.edge_length->in(diagonal);
    options.plane = case_.symmetry;
    options.is_half = case_.symmetry.has_value();
    if (!options.plane && case_.parameters.mirror) options.plane = start_plane();
    at(entry.place, "", [&] {
        Wrap wrap = wrap_around(start_.mesh, options);
        wrap_.emplace();
        wrap_->mesh = wrap.mesh;
        wrap_->adjacent = adjacency(wrap.mesh);
        wrap_->area = triangle_areas(wrap.mesh);
        wrap_->diagonal = diagonal;
        wrap_triangle_ = nearest_triangles(start_.mesh, wrap.mesh);
        note_wrap(wrap);
    });
    errors_.throw_if_any();
}

void ProblemBuilder::note_wrap(const Wrap& wrap) {
    out_.wrap = text("{alpha: ", seventeen(wrap.alpha), ", offset: ", seventeen(wrap.offset),
                     ", edge_length: ", seventeen(wrap.edge_length), "}");
    const ClosestPointTree closest(start_.mesh);
    double farthest = 0, sum = 0;
    for (int v = 0; v < wrap.mesh.num_vertices(); ++v) {
        const double away = closest.find(wrap.mesh.vertices.row(v).transpose()).distance;
        farthest = std::max(farthest, away);
        sum += away;
    }
    const double diagonal = start_.diagonal;
    const auto share = [&](double length) { return text(percent(length / diagonal), " %"); };
    out_.notes.push_back(text("wrap: ", wrap.mesh.num_triangles(), " triangles around ", start_.mesh.num_triangles(),
                              ", alpha ", share(wrap.alpha), ", offset ", share(wrap.offset), ", edges ",
                              share(wrap.edge_length), " of the diagonal; ", share(sum / wrap.mesh.num_vertices()),
                              " away from the body in the mean, ", share(farthest), " at most; ", wrap.genus,
                              " handles, ", wrap.capped_holes, " open borders closed for it alone"));
    for (const std::string& words : wrap.notes) out_.notes.push_back(text("wrap: ", words, "; coarser ones followed"));
    const ThinPlaces thin = thinner_than(start_.mesh, wrap.mesh, wrap.alpha);
    if (thin.share > worth_saying)
        out_.warnings.push_back(text("wrap: ", percent(thin.share), " % of the body's area is thinner than alpha = ",
                                     wrap.alpha, ", for example at (", thin.at[0], ", ", thin.at[1], ", ", thin.at[2],
                                     "): patches move both sides there as one, and its thickness hardly changes; "
                                     "thickness is for fields (parameters: {fields: auto})"));
}

/// What is held on the body is still to the bit; the wrap is held some edges beyond.
void ProblemBuilder::hold_wrap() {
    Problem& problem = out_.problem;
    std::vector<char> marks(static_cast<std::size_t>(wrap_->mesh.num_triangles()), 0);
    for (const int w : problem.wrap->carried(problem.fixed)) marks[static_cast<std::size_t>(w)] = 1;
    for (int ring = 0; ring < held_rings; ++ring) {
        std::vector<char> more = grown(wrap_->mesh, marks);
        if (std::ranges::count(more, 0) == 0) break;
        marks = std::move(more);
    }
    for (std::size_t w = 0; w < marks.size(); ++w)
        if (marks[w]) problem.supports.push_back(static_cast<int>(w));
}

void ProblemBuilder::set_wrap() {
    if (!wrap_) return;
    Problem& problem = out_.problem;
    std::vector<char> marks(static_cast<std::size_t>(start_.mesh.num_triangles()), 0);
    for (const Reference& region : case_.fixed)
        for (const int t : triangles(region)) marks[static_cast<std::size_t>(t)] = 1;
    WrapMapOptions options;
    options.held.assign(static_cast<std::size_t>(start_.mesh.num_vertices()), 0);
    for (int t = 0; t < start_.mesh.num_triangles(); ++t) {
        if (!marks[static_cast<std::size_t>(t)]) continue;
        problem.fixed.push_back(t);
        for (int k = 0; k < 3; ++k) options.held[static_cast<std::size_t>(start_.mesh.triangles(t, k))] = 1;
    }
    options.plane = case_.symmetry;
    options.is_half = case_.symmetry.has_value();
    options.sums = case_.wrap->sums;
    options.max_centers = case_.wrap->max_centers;
    if (!options.plane && case_.parameters.mirror) options.plane = start_plane();
    at(case_.wrap->place, "",
       [&] { problem.wrap = std::make_shared<const WrapMap>(wrap_->mesh, start_.mesh, options); });
    if (problem.wrap && !problem.fixed.empty()) hold_wrap();
}

std::vector<int> ProblemBuilder::elastic_triangles(const Reference& region) const {
    return out_.problem.wrap ? out_.problem.wrap->carried(triangles(region)) : triangles(region);
}

const std::vector<int>& ProblemBuilder::held_triangles() const {
    return wrap_ ? out_.problem.supports : out_.problem.fixed;
}

void ProblemBuilder::leave_frozen() {
    if (!wrap_) return;
    for (const Reference& name : case_.parameters.frozen)
        leave_to_motion(region_or_patch_on_surface("parameters.frozen", name));
}

void ProblemBuilder::leave_to_motion(const std::vector<int>& where) {
    if (wrap_) out_.problem.still.insert(out_.problem.still.end(), where.begin(), where.end());
}

}  // namespace strake
