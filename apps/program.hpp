#pragma once
#include <CLI/CLI.hpp>
#include <functional>

namespace stonestack::apps {

/// Runs a program of subcommands that `set_up` names and fills: the first signal ends it at the next safe
/// point and the second at once, an error becomes one line on stderr, and so does an output that did not
/// reach stdout.
/// @return the exit code.
[[nodiscard]] int run_program(int argc, char** argv, const std::function<void(CLI::App& app)>& set_up);

}  // namespace stonestack::apps
