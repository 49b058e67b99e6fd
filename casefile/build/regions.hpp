#pragma once
#include "casefile/model/case.hpp"
#include "core/mesh/adjacency.hpp"

#include <map>
#include <memory>

/// Which triangles the regions of a case hold.
namespace strake {

/// The start surface, and what is known about it.
struct StartSurface {
    TriMesh mesh;
    Adjacency adjacent;
    Eigen::VectorXd area;  ///< m
    double diagonal = 0;
    int file_triangles = 0;            ///< of the surface file
    bool is_remeshed = false;          ///< numbers in the file mean nothing any more
    std::vector<int> source_triangle;  ///< number in the file, -1: new; empty: as in the file
};

/// What regions of wings need.
struct WingSetup {
    const std::vector<WingEntry>& entries;
    BodyAxes axes;
    std::optional<SymmetryPlane> symmetry;
};

/// The triangles of declared regions. Regions may be made of others, wherever these are declared.
class RegionSets {
public:
    /// Keeps references. @param tree may be empty unless `needs_patches`. @param wings null: none are declared.
    RegionSets(const std::vector<Region>& regions, const StartSurface& start, const PatchHierarchy& tree,
               const WingSetup* wings = nullptr)
        : regions_(regions), start_(start), tree_(tree), wings_(wings), known_(regions.size()) {}

    /// Triangles of region k, ascending, never empty. Box, sphere and half space hold the triangles whose three
    /// vertices (or any point, where the region says so) lie inside, borders included (1e-9 of the diagonal).
    /// @throws InvalidInput: nothing inside, unknown solid, component, patch or name, wrong triangle file, a region
    /// made of itself (with its path).
    const std::vector<int>& triangles(int k);

    /// What a text of names and signs holds, of which a single name is the simplest.
    std::vector<char> marks_of(const std::string& formula);

    /// A declared wing, measured once. @throws InvalidInput: not declared, as `Wing`, as `marks_of`.
    std::shared_ptr<const Wing> wing(const std::string& name);

private:
    struct Evaluate;
    struct Known {
        std::vector<int> triangles;
        enum class State { unknown, open, known, refused } state = State::unknown;
    };
    std::vector<char> marks_named(const std::string& name);
    [[noreturn]] void refuse_circle(int k) const;
    std::string emptiness_words(const Region& region) const;

    const std::vector<Region>& regions_;
    const StartSurface& start_;
    const PatchHierarchy& tree_;
    const WingSetup* wings_;
    std::vector<Known> known_;
    std::vector<int> path_;                                        ///< regions that are being evaluated
    std::map<std::string, std::shared_ptr<const Wing>> measured_;  ///< null: refused
};

/// Marked triangles and those whose three vertices are no farther from them along edges than `by`; negative: the marks
/// shrink, by growing the rest. What `grow` does.
std::vector<char> grown_marks(const StartSurface& start, const std::vector<char>& marks, double by);

/// Some region, wing or body names a patch: the tree is needed before them.
bool needs_patches(const Case& the_case, const TriMesh& mesh);

}  // namespace strake
