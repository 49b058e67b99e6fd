#pragma once
#include "bench/shell_cases.hpp"
#include "objectives/fit/target_shape.hpp"
#include "objectives/geometry/measures.hpp"
#include "optimize/evaluate/validity.hpp"
#include "optimize/journal/journal.hpp"

#include <unistd.h>

#include <functional>

/// One inner iteration of an optimization: warm deformation, guard, volume, area and distance from a wanted shape with
/// their gradients by the loads, and the journal's line.
namespace strake {

struct InnerIteration {
    Equilibrium end;
    double deformation = 0, guard = 0, quantities = 0, gradients = 0, journal = 0;  ///< CPU seconds
    double total() const { return deformation + guard + quantities + gradients + journal; }
};

class InnerLoop {
public:
    /// @param wanted the shape whose distance is measured
    InnerLoop(const TriMesh& rest, const Points& wanted)
        : rest_(rest), guard_(rest, adjacency(rest)), folder_(new_folder()) {
        std::optional<SymmetryPlane> plane;
        if (is_open(rest)) plane = SymmetryPlane{{0, 1, 0}, 0};
        quantities_ = {volume(rest, plane), area(),
                       target_shape_closest("distance", rest, with_vertices(rest, wanted))};
        JournalFacts facts;
        facts.case_dir = folder_;
        facts.values = {"volume", "area", "distance"};
        journal_ = Journal::create(folder_ / "journal.sqlite", facts, {0, 1000, 0});
    }
    ~InnerLoop() {
        journal_.reset();
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }
    InnerLoop(const InnerLoop&) = delete;
    InnerLoop& operator=(const InnerLoop&) = delete;

    InnerIteration run(PrimoShell& shell, const Loads& loads, const SolveOptions& options) {
        InnerIteration result;
        const auto timed = [](double& seconds, const std::function<void()>& work) {
            const double before = cpu();
            work();
            seconds += cpu() - before;
        };
        TriMesh shape = rest_;
        timed(result.deformation, [&] {
            result.end = shell.solve(loads, {}, options);
            shape.vertices = shell.vertices();
        });
        timed(result.guard, [&] {
            if (const std::string defect = guard_.defect(shape.vertices, shell.poses()); !defect.empty())
                throw InvalidInput(defect);
        });
        JournalEvaluation line;
        std::vector<Points> dJ_dv;
        timed(result.quantities, [&] {
            for (const Quantity& quantity : quantities_) {
                QuantityResult found = quantity.evaluate({shape, true, ++number_, 1, {}});
                if (found.failure) throw InvalidInput(found.failure->message);
                line.values.push_back(found.values[0]);
                dJ_dv.push_back(std::move(found.dJ_dv[0]));
            }
        });
        timed(result.gradients, [&] {
            AdjointOptions adjoint;
            adjoint.tolerance = 1e-8;  // as ShapeEvaluator::differentiate
            adjoint.prism_height = false;
            line.x.resize(3);
            const auto all = shell.adjoint(dJ_dv, adjoint);
            for (int c = 0; c < 3; ++c) line.x[c] = all[c].force.cwiseProduct(loads.force).sum();
        });
        timed(result.journal, [&] {
            line.number = ++lines_, line.level = 1;
            line.status = "ok";
            line.surface = content_hash(shape);
            journal_->add(line);
        });
        return result;
    }

private:
    static bool is_open(const TriMesh& mesh) {
        const Adjacency adjacent = adjacency(mesh);
        for (int e = 0; e < adjacent.num_edges(); ++e)
            if (adjacent.edge_triangles[e].size() == 1) return true;
        return false;
    }
    static std::filesystem::path new_folder() {
        const auto folder = std::filesystem::temp_directory_path() / text("shell_table.", getpid());
        std::filesystem::create_directories(folder);
        return folder;
    }

    TriMesh rest_;
    ValidityGuard guard_;
    std::filesystem::path folder_;
    std::vector<Quantity> quantities_;
    std::unique_ptr<Journal> journal_;
    int number_ = 0, lines_ = 0;
};

}  // namespace strake
