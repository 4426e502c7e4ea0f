#include "forked_runs.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <thread>
#include <utility>

#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::bench {
namespace {

constexpr int kTurnsToWait = 1000;      // of a millisecond
constexpr int kPollMilliseconds = 200;  // between two looks at deadlines and Ctrl-C

}  // namespace

ForkedRuns::ForkedRuns(int at_once, double deadline)
    : at_once_(at_once > 0 ? static_cast<std::size_t>(at_once)
                           : std::max<std::size_t>(1, std::thread::hardware_concurrency())),
      deadline_(deadline) {}

ForkedRuns::~ForkedRuns() {
  for (const Child& child : children_) {
    ::kill(child.process, SIGKILL);
    ::waitpid(child.process, nullptr, 0);
    ::close(child.pipe);
  }
}

bool ForkedRuns::is_possible() {
  const std::filesystem::directory_iterator threads("/proc/self/task");
  return std::distance(begin(threads), end(threads)) == 1;
}

bool ForkedRuns::start(std::size_t run) {
  wait_until_fewer_than(at_once_);
  // The system lists a thread for a moment after it was joined.
  for (int turn = 0; turn < kTurnsToWait && !is_possible(); ++turn)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  require(is_possible(), "a process with several threads cannot be copied");
  int ends[2];
  require(::pipe2(ends, O_CLOEXEC) == 0, "no pipe for a copy of the process: ", std::strerror(errno));
  const pid_t process = ::fork();
  if (process < 0) {
    const int why = errno;
    ::close(ends[0]), ::close(ends[1]);
    require(false, "the process cannot be copied: ", std::strerror(why), "; try fewer --threads");
  }
  if (process > 0) {
    ::close(ends[1]);
    children_.push_back({run, process, ends[0], host_seconds() + deadline_, {}});
    return false;
  }
  ::close(ends[0]);
  for (const Child& other : children_) ::close(other.pipe);
  children_.clear();
  to_parent_ = ends[1];
  return true;
}

void ForkedRuns::finish(const std::string& text) {
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t n = ::write(to_parent_, text.data() + sent, text.size() - sent);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) ::_exit(1);
    sent += static_cast<std::size_t>(n);
  }
  ::_exit(0);  // buffered output is the parent's
}

void ForkedRuns::fail() {
  ::_exit(1);
}

std::map<std::size_t, ForkedRuns::Result> ForkedRuns::wait() {
  wait_until_fewer_than(1);
  return std::exchange(results_, {});
}

void ForkedRuns::wait_until_fewer_than(std::size_t count) {
  while (children_.size() >= count) {
    throw_if_interrupted();
    std::vector<pollfd> pipes;
    for (const Child& child : children_) pipes.push_back({child.pipe, POLLIN, 0});
    if (::poll(pipes.data(), pipes.size(), kPollMilliseconds) < 0)
      require(errno == EINTR, "waiting for a copy of the process failed: ", std::strerror(errno));
    else
      for (std::size_t k = children_.size(); k-- > 0;)
        if (pipes[k].revents != 0) read_from(children_[k]);
    for (std::size_t k = children_.size(); k-- > 0;)
      if (children_[k].pipe < 0 || host_seconds() > children_[k].end) collect(k);
  }
}

void ForkedRuns::read_from(Child& child) {
  char buffer[4096];
  const ssize_t n = ::read(child.pipe, buffer, sizeof buffer);
  if (n > 0) child.text.append(buffer, static_cast<std::size_t>(n));
  if (n == 0 || (n < 0 && errno != EINTR)) {
    ::close(child.pipe);
    child.pipe = -1;
  }
}

void ForkedRuns::collect(std::size_t k) {
  Child child = std::move(children_[k]);
  children_.erase(children_.begin() + static_cast<std::ptrdiff_t>(k));
  const bool late = child.pipe >= 0;
  if (late) {
    ::kill(child.process, SIGKILL);
    ::close(child.pipe);
  }
  int status = 0;
  while (::waitpid(child.process, &status, 0) < 0 && errno == EINTR) {
  }
  Result result{std::move(child.text), {}};
  if (late)
    result.problem = concat("no end within ", deadline_, " s");
  else if (WIFSIGNALED(status))
    result.problem = concat("ended by signal ", WTERMSIG(status), " (", ::strsignal(WTERMSIG(status)), ")");
  else if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    result.problem = concat("ended with exit code ", WEXITSTATUS(status));
  results_[child.run] = std::move(result);
}

}  // namespace stonestack::bench
