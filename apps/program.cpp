#include "program.hpp"

#include <signal.h>

#include <exception>
#include <string>

#include "command_line.hpp"
#include "standard_streams.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "version.hpp"

namespace stonestack::apps {
namespace {

using core::ExitCode;

/// First signal: finish what must be finished. Second: the default action, at once.
void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = [](int) { core::note_interrupt(); };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
  struct sigaction nothing {};      // a file that may not grow is an error of its write, like a full disk;
  nothing.sa_handler = [](int) {};  // not SIG_IGN, which programs started from here would inherit
  sigaction(SIGXFSZ, &nothing, nullptr);
}

int run(int argc, char** argv, void (*set_up)(CLI::App& app)) {
  CLI::App app;
  app.set_version_flag("--version", program_version());
  app.require_subcommand(1);
  set_up(app);
  return run_command_line(app, argc, argv);
}

/// The exit code of `work`; what it throws is logged.
template <class Work>
int guarded(const Work& work) {
  try {
    return work();
  } catch (const core::Error& error) {
    core::log_error(error.what());
    return static_cast<int>(error.exit_code());
  } catch (const std::exception& error) {
    core::log_error(std::string("internal error: ") + error.what() +
                    "; please report it with the command line");
    return static_cast<int>(ExitCode::kInternal);
  }
}

}  // namespace

int run_program(int argc, char** argv, void (*set_up)(CLI::App& app)) {
  replace_closed_streams();
  install_signal_handlers();
  const int code = guarded([&] { return run(argc, argv, set_up); });
  core::clear_progress();
  const int printed = guarded([] {
    check_stdout();
    return 0;
  });
  return code != 0 ? code : printed;
}

}  // namespace stonestack::apps
