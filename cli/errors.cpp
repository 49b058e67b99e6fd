#include "cli/errors.hpp"

#include "casefile/yaml/diagnostics.hpp"
#include "cli/commands.hpp"
#include "core/primo/shell.hpp"
#include "optimize/journal/journal.hpp"

#include <filesystem>
#include <new>

namespace strake::cli {
namespace {

std::string said(const std::exception& e) { return std::string("strake: ") + e.what(); }

std::string file_words(const std::filesystem::filesystem_error& e) {
    const std::string path = printable(e.path1().string(), 400);
    return "strake: " + (path.empty() ? "" : path + ": ") + e.code().message();
}

}  // namespace

ProgramEnd end_of(const std::exception_ptr& thrown) {
    try {
        std::rethrow_exception(thrown);
    } catch (const ExitStatus& end) {
        return {end.status, ""};
    } catch (const CaseError& e) {
        return {usage, e.quoted()};
    } catch (const ReplayMismatch& e) {
        return {run_failed, said(e)};
    } catch (const InvalidInput& e) {
        return {usage, said(e)};
    } catch (const InputError& e) {
        return {surface_file, said(e)};
    } catch (const OutputError& e) {
        return {output_failed, said(e)};
    } catch (const Interrupted&) {
        return {interrupted, "strake: interrupted; nothing was begun that could be continued"};
    } catch (const UnheldPart& e) {
        return {run_failed, said(e)};
    } catch (const SolverError& e) {
        return {run_failed, said(e)};
    } catch (const std::filesystem::filesystem_error& e) {
        return {output_failed, file_words(e)};
    } catch (const std::bad_alloc&) {
        return {run_failed, "strake: out of memory"};
    } catch (const std::exception& e) {
        return {run_failed, std::string("strake: internal error: ") + e.what()};
    } catch (...) {
        return {run_failed, "strake: internal error of unknown kind"};
    }
}

}  // namespace strake::cli
