#include <signal.h>

#include <exception>
#include <iostream>

#include "commands.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "version.hpp"

namespace {

using stonestack::core::ExitCode;

/// An unknown command gets its own answer: CLI11 would only say that one is missing.
void check_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::string known;
  for (const auto* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == argv[1]) return;
    known += (known.empty() ? "" : ", ") + command->get_name();
  }
  throw stonestack::core::InvalidArgument("unknown command '" + std::string(argv[1]) +
                                          "'; commands: " + known);
}

/// First signal: finish what must be finished. Second: the default action, at once.
void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = [](int) { stonestack::core::note_interrupt(); };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

int run(int argc, char** argv) {
  CLI::App app("stonestack: finds scanned stones, plans stable towers, builds them with a robot arm.",
               "stonestack");
  app.set_version_flag("--version", stonestack::apps::program_version());
  app.require_subcommand(1);
  app.footer(
      "Examples:\n"
      "  stonestack run --robot ur10                build a tower in the simulated cell\n"
      "  stonestack search --stones limestone_1,limestone_2 --levels 2\n"
      "  stonestack COMMAND --help                  what a command takes, with examples\n"
      "Exit codes: 0 done, 2 usage, 3 unreadable input, 4 nothing detected, 5 no stable pose,\n"
      "            6 planning or execution failed, 7 safety stop, 130 interrupted");
  const std::initializer_list<void (*)(CLI::App&)> commands{
      // in the order of the help
      stonestack::apps::add_scan,       stonestack::apps::add_render,   stonestack::apps::add_detect,
      stonestack::apps::add_track,      stonestack::apps::add_search,   stonestack::apps::add_check,
      stonestack::apps::add_plan,       stonestack::apps::add_run,      stonestack::apps::add_decide,
      stonestack::apps::add_experiment, stonestack::apps::add_simulate, stonestack::apps::add_doctor,
      stonestack::apps::add_calibrate,  stonestack::apps::add_config,   stonestack::apps::add_bench,
  };
  for (const auto add : commands) add(app);
  check_command(app, argc, argv);
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
  } catch (const stonestack::core::Error& error) {
    stonestack::core::log_error(error.what());
    return static_cast<int>(error.exit_code());
  } catch (const std::exception& error) {
    stonestack::core::log_error(std::string("internal error: ") + error.what() +
                                "; please report it with the command line");
    return static_cast<int>(ExitCode::kInternal);
  }
}
