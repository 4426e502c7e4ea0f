#include "standard_streams.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "stonestack/core/error.hpp"

namespace stonestack::apps {

void replace_closed_streams() {
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(standard, F_GETFD) >= 0) continue;
    // The lowest free number is this one. Writing to what is open for reading alone fails, as it should for
    // stdout; messages to a closed stderr are meant to be lost.
    (void)::open("/dev/null", standard == STDERR_FILENO ? O_WRONLY : O_RDONLY);
  }
}

void check_stdout() {
  errno = 0;
  const bool whole = std::cout.flush().good();
  const bool flushed = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  const int copy = ::dup(STDOUT_FILENO);  // some file systems say only on closing that a write failed
  const bool closed = copy >= 0 && ::close(copy) == 0;
  if (whole && flushed && closed) return;
  throw FileError("stdout",
                  concat("cannot be written: ", errno == 0 ? "a write failed" : std::strerror(errno)),
                  "what was printed is not complete; give it a place to go");
}

}  // namespace stonestack::apps
