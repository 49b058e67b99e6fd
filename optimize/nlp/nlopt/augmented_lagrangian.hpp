#pragma once
#include "optimize/nlp/nlopt/restarts.hpp"

/// Constraints for methods that take none. Internal.
namespace strake {

/// True: the method cannot take some of the program's constraints itself.
bool needs_lagrangian(const MethodFacts& method, const NonlinearProgram& program);

/// Augmented Lagrangian (Powell, Hestenes, Rockafellar; the updates of Birgin & Martinez 2008): minimizes
/// objective / scale + Lagrangian::value by the method, moves the multipliers, and raises the penalty where the
/// violation has not been halved. Inner searches start where the last one ended and get stricter. Constraints that the
/// method takes itself stay with it. Starts at the guard's best point. A global method gets three searches, a third of
/// the evaluations each.
SearchEnd minimize_augmented(Guard& guard, const MethodFacts& method);

}  // namespace strake
