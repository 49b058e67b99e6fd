#include "cases/schema.hpp"

#include "cli/commands.hpp"

#include <fmt/core.h>
#include <memory>

namespace strake::cli {

void add_schema(CLI::App& app) {
    auto json = std::make_shared<bool>(false);
    CLI::App* command = app.add_subcommand("schema", "every key of a case file, as a page of Markdown");
    command->add_flag("--json", *json, "as JSON Schema, for the completion of editors");
    command->callback([json] { fmt::print("{}", *json ? schema_json() : schema_reference()); });
}

}  // namespace strake::cli
