#include <signal.h>

#include <exception>
#include <iostream>

#include "commands.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace {

using stonestack::ExitCode;

/// First signal: finish what must be finished. Second: the default action, at once.
void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = [](int) { stonestack::note_interrupt(); };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

int run(int argc, char** argv) {
  CLI::App app("stonestack: finds scanned stones, plans stable towers, builds them with a robot arm.",
               "stonestack");
  app.set_version_flag("--version", STONESTACK_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Examples:\n"
      "  stonestack run --robot ur10                build a tower in the simulated cell\n"
      "  stonestack search --stones limestone_1,limestone_2 --levels 2\n"
      "  stonestack COMMAND --help                  what a command takes, with examples\n"
      "Exit codes: 0 done, 2 usage, 3 unreadable input, 4 nothing detected, 5 no stable pose,\n"
      "            6 planning or execution failed, 7 safety stop, 130 interrupted");
  const std::initializer_list<void (*)(CLI::App&)> commands{
      // one line a subcommand, in the order of the help
  };
  for (const auto add : commands) add(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& problem) {
    return app.exit(problem, std::cout, std::cerr) == 0 ? 0 : static_cast<int>(ExitCode::kUsage);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  install_signal_handlers();
  try {
    return run(argc, argv);
  } catch (const stonestack::Error& error) {
    stonestack::log_error(error.what());
    return static_cast<int>(error.exit_code());
  } catch (const std::exception& error) {
    stonestack::log_error(std::string("internal error: ") + error.what() +
                          "; please report it with the command line");
    return static_cast<int>(ExitCode::kInternal);
  }
}
