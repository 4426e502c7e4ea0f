#pragma once
#include <CLI/CLI.hpp>

#include "rooms.hpp"

namespace stonestack::apps {

/// Parses the command line and runs the callback of the subcommand that it names. `help COMMAND` is
/// `COMMAND --help`.
/// @return the exit code: 0, or 2 when CLI11 has reported what is wrong.
/// @throws InvalidArgument for a subcommand or option that does not exist, with what may have been meant; and
/// whatever the callback throws.
[[nodiscard]] int run_command_line(CLI::App& app, int argc, const char* const* argv);

}  // namespace stonestack::apps
