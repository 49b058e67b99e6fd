#pragma once
#include "optimize/problem/problem.hpp"

/// The design problems of the evidence suite: surface, held part, patches, variables, objective, constraints. Twelve
/// with targets and limits by formula, six physical ones whose optimum nobody has drawn. Everything that is random
/// comes from the seed; another seed makes another set.
namespace strake::evidence {

/// What is held: triangles whose centroid has its coordinate `axis` below `low` or above `high`.
struct HeldEnds {
    int axis = 0;
    std::optional<double> low, high;
};

struct EvidenceProblem {
    std::string name;
    std::string what;      ///< one line for the tables
    bool outside = false;  ///< its target was made by a formula on the vertices, not by the shell
    HeldEnds ends;
    Problem problem;                ///< tree: the three levels that the variants with levels share
    Method second = Method::lbfgs;  ///< the method beside sqp
    bool has_gradients = true;
};
/// Those that it is solved with.
std::vector<Method> methods_of(const EvidenceProblem& evidence);

/// In the order of the tables.
const std::vector<std::string>& problem_names();   ///< the twelve
const std::vector<std::string>& physical_names();  ///< the six

/// @param triangles about; wings have at least 1 000, lifting bodies 1 500. @throws InvalidInput for an unknown name.
EvidenceProblem make_problem(const std::string& name, int triangles, unsigned seed);

/// The same as a solver without gradients sees it: quantities give values only, sqp takes differences.
EvidenceProblem without_gradients(EvidenceProblem evidence);

/// As a run with a program without gradients: what no program tells keeps its gradients.
EvidenceProblem with_programs_by_values(const EvidenceProblem& evidence);
/// Neither a program tells it nor a formula.
bool is_built_in(const Quantity& quantity);

/// The same where only the objective comes from a program, as that of a flow solver: values of the shape that are
/// limited are known, with gradients.
EvidenceProblem with_objective_by_program(EvidenceProblem evidence);

/// The same with `parameters.fields: auto`.
EvidenceProblem with_automatic_fields(const EvidenceProblem& evidence);
/// The same with displacement fields, so many on successive levels (`Parameters::field_steps`).
EvidenceProblem with_displacement_fields(EvidenceProblem evidence, std::vector<int> steps);

/// The tree whose level 1 is the last level of `tree`.
PatchHierarchy finest_only(const PatchHierarchy& tree);

}  // namespace strake::evidence
