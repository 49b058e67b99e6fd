#include "cases/schema.hpp"
#include "cli/commands.hpp"

#include <fmt/core.h>

namespace strake::cli {

void add_schema(CLI::App& app) {
    CLI::App* command = app.add_subcommand("schema", "every key of a case file, as a page of Markdown");
    command->callback([] { fmt::print("{}", schema_reference()); });
}

}  // namespace strake::cli
