#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <iostream>

#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack::report {
namespace {

constexpr int kTurn = 50;               // ms between questions for Ctrl-C
constexpr std::size_t kLongest = 1024;  // characters of a line: more is nobody's answer

}  // namespace

std::optional<std::string> ask_person(const std::string& question) {
  clear_progress();
  std::cerr << question << std::flush;
  std::string line;
  for (;;) {
    throw_if_interrupted();
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (::poll(&input, 1, kTurn) <= 0) continue;
    char letter = 0;  // one by one: what follows the line is the next answer
    const ssize_t got = ::read(STDIN_FILENO, &letter, 1);
    if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (got <= 0 || line.size() > kLongest) {
      std::cerr << std::endl;
      return std::nullopt;
    }
    if (letter == '\n') {
      if (::isatty(STDIN_FILENO) == 0) std::cerr << std::endl;  // nobody's Enter has ended the line
      return line;
    }
    if (letter != '\r') line += letter;
  }
}

}  // namespace stonestack::report
