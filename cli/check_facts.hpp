#pragma once
#include "casefile/build/build_problem.hpp"
#include "core/repair/checkup.hpp"
#include "optimize/check/border_turn.hpp"
#include "optimize/check/capability.hpp"
#include "optimize/check/start_check.hpp"
#include "optimize/space/space_facts.hpp"

#include <nlohmann/json.hpp>

/// What `strake check` finds out beyond the case itself: the quality of the surface, what holds each part, the
/// variables of a level, the constraints at the start, and the cost of a run.
namespace strake::cli {

struct HeldPart {
    int triangles = 0, held = 0;  ///< in the part; fixed or moved as prescribed
    std::vector<std::string> by;  ///< names of the regions that hold it
};

struct RunCost {
    int evaluations = 0;                ///< maximum
    double seconds_each = 0;            ///< of Strake itself, estimated
    std::vector<std::string> programs;  ///< their time is not included
    double memory_bytes = 0;            ///< of Strake itself, estimated
};

/// How normals turn beside what is held.
struct BorderFacts {
    double move = 0.1;                     ///< diagonals
    double by_fields = 0, by_patches = 0;  ///< turn of normals beside what is held, degrees
    std::string variable;                  ///< that turns them most
    bool is_smooth = false;                ///< `parameters.keep: smooth_border`
    bool is_kept = false;                  ///< by it designs keep to `Parameters::max_border_turn`
};

struct CheckFacts {
    Checkup health;
    std::vector<HeldPart> parts;
    std::optional<SpaceFacts> space;     ///< none: no shape variables, or not requested
    std::optional<Capability> can_make;  ///< the same
    std::optional<BorderFacts> border;   ///< none: nothing is held, or no variables
    std::optional<StartAnswer> start;    ///< without the quantities of programs
    std::vector<std::string> unknown;    ///< constraints on program values, not known yet
    std::optional<RunCost> cost;
};

struct CheckWishes {
    bool quick = false;  ///< skip what needs a factorization
    int level = 1;       ///< whose variables are examined
    std::string modes;   ///< VTP file with the displacement by each variable; empty: none
    std::string wrap;    ///< VTP file with the wrap and its patches; empty: none
};

/// @throws InvalidInput: no such level; and whatever the run itself would throw at its start.
CheckFacts check_facts(const BuiltProblem& built, const CheckWishes& wishes);

void print_facts(const CheckFacts& facts);
void add_facts(nlohmann::ordered_json& json, const CheckFacts& facts);

/// "3 min 20 s", "1.4 s", "2 h 5 min", "3.1 days".
std::string duration_words(double seconds);

}  // namespace strake::cli
