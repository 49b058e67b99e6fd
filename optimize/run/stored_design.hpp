#pragma once
#include "optimize/run/run_records.hpp"

#include <filesystem>

/// The best design of a run as it is kept in the run's folder (levels/best.design), exact to the last bit: what
/// `start_from` begins with. Demands on the shell are kept as degrees of freedom of patches: the run that goes
/// on may have other variables.
namespace strake {

class ShapeEvaluator;

/// Enough of a surface to know it again.
struct SurfaceMark {
    int vertices = 0, triangles = 0;
    double diagonal = 0;
    std::string positions, connectivity;  ///< hashes
};
SurfaceMark surface_mark(const TriMesh& surface);

struct StoredDesign {
    int evaluation = 0, level = 0;
    double objective = 0;
    SurfaceMark surface;
    PatchHierarchy tree;
    std::vector<std::pair<int, int>> front;  ///< per patch: level and id in the tree, the finest on which it is whole
    Eigen::VectorXd dofs;                    ///< of the patches, in the order of `front`
    std::vector<std::pair<std::string, double>> given;  ///< values of the user variables (`Parameters::user_variables`)
    std::vector<int> core;                    ///< m: patch in whose strain core the triangle is, else -1; empty: none
    std::vector<RigidMotion> carried_motion;  ///< per patch, or empty
    Points carried_traction;                  ///< m x 3, or empty
    Eigen::VectorXd carried_log_height;       ///< m, or empty
    Poses poses;                              ///< empty: there was no shell
    Points vertices;                          ///< n x 3, of the design
    std::vector<std::pair<std::string, double>> parameters;  ///< values of the parameters
    std::vector<std::pair<std::string, double>> at_rest;     ///< what relative limits are multiples of, by value name
};

StoredDesign stored_design(const AcceptedDesign& design);

/// One line that names the format, one of JSON, then binary arrays in the byte order of the machine.
std::string design_bytes(const StoredDesign& design);

/// @throws InputError with the path: unreadable, not such a file, damaged.
StoredDesign read_design(const std::filesystem::path& file);

/// Lets a run of `problem` begin at the design: its tree (the problem's own where that has the same levels and maybe
/// more), its values of parameters, and by `optimize` and `fit` its shape.
/// @throws InvalidInput where that cannot be: another surface (what differs), strains in only one of the two, a
/// variable out of its bounds.
void start_from(Problem& problem, std::shared_ptr<const StoredDesign> design);
void check_surface(const StoredDesign& design, const TriMesh& surface);
/// @throws InvalidInput: the shell of the design did not have so many triangles, a wrap has changed.
void check_elastic(const StoredDesign& design, int triangles);  ///< the first of these checks
bool has_levels_of(const PatchHierarchy& tree, const StoredDesign& design);

/// The design in the space of its patches, with a variable for each degree of freedom in use. @pre `start_from`.
struct StartSpace {
    DesignSpace space;
    Eigen::VectorXd x;
    Front front;  ///< to refine to: the same patches, each its own parent
};
StartSpace start_space(std::shared_ptr<const RestFacts> rest, const StoredDesign& design);

/// What a level or a run begins with is the shape that it inherits, to this share of the diagonal.
constexpr double inheritance_tolerance = 1e-10;

/// Enters the space that the problem's variables have on the design's patches, at the design's equilibrium: x and space
/// to begin with. @throws InvalidInput where the design's loads do not give its shape. @pre `start_from`.
InheritedSpace enter_stored(ShapeEvaluator& evaluator, std::shared_ptr<const RestFacts> rest,
                            const StoredDesign& design);

}  // namespace strake
