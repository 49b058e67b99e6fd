#pragma once
#include "cases/build_problem.hpp"
#include "core/repair/checkup.hpp"
#include "optimize/space_facts.hpp"
#include "optimize/start_check.hpp"

#include <nlohmann/json.hpp>

/// What `strake check` finds out beyond the case itself: the surface's health, what holds each part, the variables of a
/// level, the constraints at the start, and what a run would cost.
namespace strake::cli {

struct HeldPart {
    int triangles = 0, held = 0;  ///< of the part; fixed or moved as prescribed
    std::vector<std::string> by;  ///< names of regions, and of what else holds it
};

struct RunCost {
    int evaluations = 0;                ///< at most
    double seconds_each = 0;            ///< of Strake itself, estimated
    std::vector<std::string> programs;  ///< whose time comes on top
    double memory_bytes = 0;            ///< of Strake itself, estimated
};

struct CheckFacts {
    Checkup health;
    std::vector<HeldPart> parts;
    std::optional<SpaceFacts> space;   ///< none: no shape variables, or not asked for
    std::optional<StartAnswer> start;  ///< of what needs no program
    std::vector<std::string> unknown;  ///< constraints on programs, not known yet
    std::optional<RunCost> cost;
};

struct CheckWishes {
    bool quick = false;  ///< nothing that needs a factorization
    int level = 1;       ///< whose variables are looked at
    std::string modes;   ///< VTP file with the displacement by each variable; empty: none
};

/// @throws InvalidInput: no such level; and as the run itself would at its start.
CheckFacts check_facts(const BuiltProblem& built, const CheckWishes& wishes);

void print_facts(const CheckFacts& facts);
void add_facts(nlohmann::ordered_json& json, const CheckFacts& facts);

/// "3 min 20 s", "1.4 s", "2 h 5 min", "3.1 days".
std::string duration_words(double seconds);

}  // namespace strake::cli
