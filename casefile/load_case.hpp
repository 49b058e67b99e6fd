#pragma once
#include "casefile/model/case.hpp"

namespace strake {

/// Reads and checks a case file without reading the surface. @throws CaseError with all that is wrong.
Case load_case(const std::filesystem::path& file, Purpose purpose = Purpose::any);
/// The same with keys set by the command line: KEY=VALUE (`apply_settings`), checked as those of the file are. Paths in
/// values are relative to the case file.
Case load_case(const std::filesystem::path& file, Purpose purpose, const std::vector<std::string>& settings);
/// The same of a run that began with the case `begun`, as its folder has it: where the file says nothing of its
/// variables they are those of the run, whatever the file's own default is by now.
Case load_case(const std::filesystem::path& file, Purpose purpose, const std::vector<std::string>& settings,
               const std::string& begun);
/// The same, where {case_dir} of commands stays another folder than the file's: a run that continues; without notes
/// about old names, which its user did not write.
Case load_case(const std::filesystem::path& file, Purpose purpose, const std::filesystem::path& command_dir);
/// The same of a text that does not stand in `file` yet: of an editor. Paths in it are relative to the file's folder.
Case load_case_text(const std::string& yaml, const std::filesystem::path& file, Purpose purpose = Purpose::any);

}  // namespace strake
