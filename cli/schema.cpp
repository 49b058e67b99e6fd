#include "casefile/schema/schema.hpp"

#include "cli/commands.hpp"

#include <fmt/core.h>
#include <memory>

namespace strake::cli {

void add_schema(CLI::App& app) {
    auto json = std::make_shared<bool>(false);
    CLI::App* command = app.add_subcommand("schema", "print every key of a case file as a Markdown page");
    command->add_flag("--json", *json, "print a JSON Schema, for completion in editors");
    command->callback([json] { fmt::print("{}", *json ? schema_json() : schema_reference()); });
}

}  // namespace strake::cli
