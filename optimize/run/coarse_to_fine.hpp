#pragma once
#include "optimize/run/run_records.hpp"

/// The optimization driver: level by level down the patch tree, each starting from exactly the shape that the one
/// before ended with (docs/theory-optimize.md).
namespace strake {

class Journal;

/// Minimizes (or maximizes) the problem's objective under its constraints and bounds on levels 1, 2, ... of the tree.
/// A level ends when its optimizer converges, when progress slackens, or with its share of the budget: what is left,
/// divided by the levels left, at least what moves it. Then a finer one comes where that is expected to pay. The result
/// is the best feasible design seen (while none is, the least violation).
/// @param journal that every evaluation is written to. Where it holds some, the run is replayed against it and then
/// continues; it must be that of the same problem, whose limits may be larger.
/// @throws ReplayMismatch; InvalidInput: no objective, unknown names, contradicting limits, no variable that moves
/// anything, a variable kind or method that cannot serve; UnheldPart.
RunResult optimize(const Problem& problem, const RunEvents& events = {}, Journal* journal = nullptr);

}  // namespace strake
