#include "program.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <iostream>
#include <string>
#include <thread>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "command_line.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "version.hpp"

namespace stonestack::apps {
namespace {

using core::ExitCode;

/// Gives a standard file that the caller has closed (`>&-`) a stand-in, so that no other file gets
/// the number of stdout. What is printed to a stand-in for stdout counts as lost.
void replace_closed_streams() {
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(standard, F_GETFD) >= 0) continue;
    // The lowest free number is this one. Writing to what is open for reading alone fails, as it should for
    // stdout; messages to a closed stderr are meant to be lost.
    (void)::open("/dev/null", standard == STDERR_FILENO ? O_WRONLY : O_RDONLY);
  }
}

/// True for a pipe whose reader has ended, as `head` does.
bool reader_has_gone() {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&out, 1, 0) == 1 && (out.revents & POLLERR) != 0;
}

/// Throws FileError if a part of what was printed did not reach stdout (a full disk, a closed stdout). A
/// command that is `done` ends by SIGPIPE, as shells expect, where the reader wanted no more.
void check_stdout(bool done) {
  errno = 0;
  const bool whole = std::cout.flush().good();
  const bool flushed = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  const int copy = ::dup(STDOUT_FILENO);  // some file systems say only on closing that a write failed
  const bool closed = copy >= 0 && ::close(copy) == 0;
  if (whole && flushed && closed) return;
  if (done && reader_has_gone()) {
    ::signal(SIGPIPE, SIG_DFL);
    ::raise(SIGPIPE);
  }
  throw core::FileError(
      "stdout", core::concat("cannot be written: ", errno == 0 ? "a write failed" : std::strerror(errno)),
      "what was printed is not complete; give it a place to go");
}

/// First signal: finish what must be finished. Second: the default action, at once.
void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = [](int) { core::note_interrupt(); };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
  struct sigaction nothing {};      // a file that may not grow is an error of its write, like a full disk;
  nothing.sa_handler = [](int) {};  // not SIG_IGN, which programs started from here would inherit
  sigaction(SIGXFSZ, &nothing, nullptr);
  sigaction(SIGPIPE, &nothing, nullptr);  // likewise: an arm that moves is not left for who reads messages
}

/// One heap for each processor, where glibc would open eight: a program of many short threads holds what is
/// free in every one of them. The user's MALLOC_ARENA_MAX stands.
void bound_heaps_of_threads() {
#ifdef __GLIBC__
  if (std::getenv("MALLOC_ARENA_MAX") == nullptr)
    mallopt(M_ARENA_MAX, static_cast<int>(std::max(2u, std::thread::hardware_concurrency())));
#endif
}

int run(int argc, char** argv, const std::function<void(CLI::App& app)>& set_up) {
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

int run_program(int argc, char** argv, const std::function<void(CLI::App& app)>& set_up) {
  bound_heaps_of_threads();
  replace_closed_streams();
  install_signal_handlers();
  const int code = guarded([&] { return run(argc, argv, set_up); });
  core::clear_progress();
  const int printed = guarded([&] {
    check_stdout(code == 0);
    return 0;
  });
  return code != 0 ? code : printed;
}

}  // namespace stonestack::apps
