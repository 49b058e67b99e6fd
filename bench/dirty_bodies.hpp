#pragma once
#include "cases/geometry/dirty_body.hpp"
#include "core/formats/io.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

namespace strake {

/// The main program of a table over bodies: `row(name, mesh)` for each argument, a kind of `example::dirty_body` or a
/// surface file, or for each of `usual` without arguments. A body that fails has its reason in place of its row.
/// @return exit status: 1 if one failed
template <class Row>
int table_of_bodies(int argc, char** argv, std::vector<std::string> usual, const Row& row) {
    const std::vector<std::string> bodies =
        argc > 1 ? std::vector<std::string>(argv + 1, argv + argc) : std::move(usual);
    const std::vector<std::string>& kinds = example::dirty_body_kinds();
    int failed = 0;
    for (const std::string& body : bodies) try {
            const bool is_kind = std::ranges::find(kinds, body) != kinds.end();
            row(body.substr(body.rfind('/') + 1), is_kind ? example::dirty_body(body) : read_surface(body).mesh);
        } catch (const std::exception& error) {
            std::printf("%-28s %s\n", body.c_str(), error.what());
            ++failed;
        }
    return failed > 0 ? 1 : 0;
}

}  // namespace strake
