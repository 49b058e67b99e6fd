#pragma once
#include "casefile/build/build_problem.hpp"
#include "report/run_report.hpp"

namespace strake {

/// What the case asks for, in words. @param built the problem if available: its surface and patches.
ReportSubject report_subject(const Case& the_case, const BuiltProblem* built);

/// Writes `out` from the run in `folder`. @throws as `report_html`, and OutputError.
void write_report(const std::filesystem::path& folder, const ReportSubject& subject, const std::filesystem::path& out);

}  // namespace strake
