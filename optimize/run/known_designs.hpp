#pragma once
#include "optimize/run/design_table.hpp"
#include "optimize/run/stored_design.hpp"

/// Designs that an earlier run, or a sample, has paid for: what the folder of `start_from` knows beside its best one.
/// Internal.
namespace strake {

struct KnownDesigns {
    std::shared_ptr<const DesignTable> table;  ///< null: the folder tells nothing that the problem can use
    std::string why;                           ///< with a remedy; empty: there is nothing to say
};

/// The designs of the level of the folder's best one, that one first, with the values of the problem; as they stand in
/// the folder's journal. Variables without their offsets: differences are physical.
/// @pre `start_from(problem, ...)`. @throws InputError where what is there cannot be read.
KnownDesigns known_designs(const Problem& problem, const std::filesystem::path& folder);

/// By this name the journal of a run keeps a hash of what its `start_from` knew when it began.
inline constexpr const char* known_designs_key = "optimize.start_from: designs";
/// Empty: nothing is known there.
std::string known_designs_hash(const std::filesystem::path& folder);

/// Programs of the problem answer for the start what is known of it; they are not called. @pre `problem.table`
void answer_start(Problem& problem);

}  // namespace strake
