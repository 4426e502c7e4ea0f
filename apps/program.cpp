#include "program.hpp"

#include <signal.h>

#include <exception>
#include <iostream>

#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "version.hpp"

namespace stonestack::apps {
namespace {

using core::ExitCode;

/// An unknown command gets its own answer: CLI11 would only say that one is missing.
void check_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::string known;
  for (const auto* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == argv[1]) return;
    known += (known.empty() ? "" : ", ") + command->get_name();
  }
  throw core::InvalidArgument("unknown command '" + std::string(argv[1]) + "'; commands: " + known);
}

/// First signal: finish what must be finished. Second: the default action, at once.
void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = [](int) { core::note_interrupt(); };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

int run(int argc, char** argv, void (*set_up)(CLI::App& app)) {
  CLI::App app;
  app.set_version_flag("--version", program_version());
  app.require_subcommand(1);
  set_up(app);
  check_command(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& problem) {
    return app.exit(problem, std::cout, std::cerr) == 0 ? 0 : static_cast<int>(ExitCode::kUsage);
  }
  return 0;
}

}  // namespace

int run_program(int argc, char** argv, void (*set_up)(CLI::App& app)) {
  install_signal_handlers();
  try {
    return run(argc, argv, set_up);
  } catch (const core::Error& error) {
    core::log_error(error.what());
    return static_cast<int>(error.exit_code());
  } catch (const std::exception& error) {
    core::log_error(std::string("internal error: ") + error.what() +
                    "; please report it with the command line");
    return static_cast<int>(ExitCode::kInternal);
  }
}

}  // namespace stonestack::apps
