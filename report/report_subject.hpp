#pragma once
#include "cases/build_problem.hpp"
#include "report/run_report.hpp"

namespace strake {

/// What the case asks, in words. @param built the problem, where it is at hand: its surface and its patches.
ReportSubject report_subject(const Case& the_case, const BuiltProblem* built);

/// Makes `out` from the run in `folder`. @throws as `report_html`, and OutputError.
void write_report(const std::filesystem::path& folder, const ReportSubject& subject, const std::filesystem::path& out);

}  // namespace strake
