#include "cli/errors.hpp"

#include "casefile/yaml/diagnostics.hpp"
#include "cli/commands.hpp"
#include "core/primo/shell.hpp"

#include <gtest/gtest.h>

#include <new>

namespace strake::cli {
namespace {

template <class Error>
ProgramEnd end_after(const Error& error) {
    return end_of(std::make_exception_ptr(error));
}

void expect(const ProgramEnd& end, int status, const std::string& message) {
    EXPECT_EQ(end.status, status) << end.message;
    EXPECT_EQ(end.message, message);
}

TEST(Errors, EachTypeHasItsStatusAndItsWords) {
    expect(end_after(ExitStatus{external_failed}), 5, "");
    expect(end_after(CaseError("c.yaml", {{{2, 3}, "bad", "a: b"}})), 2, "c.yaml:2:3: bad\n  2 | a: b");
    expect(end_after(InvalidInput("h = -1 must be > 0")), 2, "strake: h = -1 must be > 0");
    expect(end_after(InputError("s.obj:2: cut")), 3, "strake: s.obj:2: cut");
    expect(end_after(OutputError("o.obj: Permission denied")), 4, "strake: o.obj: Permission denied");
    expect(end_after(UnheldPart("a part moves freely")), 1, "strake: a part moves freely");
    expect(end_after(SolverError("not positive definite")), 1, "strake: not positive definite");
}

TEST(Errors, TheLibrarysOwnAreTranslated) {
    expect(end_after(std::bad_alloc()), 1, "strake: out of memory");
    expect(end_after(std::out_of_range("map::at")), 1, "strake: internal error: map::at");
    expect(end_after(std::invalid_argument("stoi")), 1, "strake: internal error: stoi");
    expect(end_after(42), 1, "strake: internal error of unknown kind");
    const std::error_code denied = std::make_error_code(std::errc::permission_denied);
    expect(end_after(std::filesystem::filesystem_error("cannot", "/x/y", denied)), 4,
           "strake: /x/y: Permission denied");
}

}  // namespace
}  // namespace strake::cli
