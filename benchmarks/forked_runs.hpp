#pragma once
#include <sys/types.h>

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "rooms.hpp"

namespace stonestack::bench {

/// Copies of this process, each of which goes on by itself and returns one text. Work that many runs
/// share is done once: the process is copied where they part. POSIX fork(2) copies the calling thread only,
/// so that there must be no other.
class ForkedRuns {
 public:
  /// At most `at_once` copies live at a time; each is killed after `deadline` seconds.
  ForkedRuns(int at_once, double deadline);
  ~ForkedRuns();
  ForkedRuns(const ForkedRuns&) = delete;
  ForkedRuns& operator=(const ForkedRuns&) = delete;

  /// Whether this process has one thread.
  [[nodiscard]] static bool is_possible();
  /// Copies the process, once fewer than `at_once` copies live. True in the copy, which is to call `finish`.
  /// @throws InvalidArgument if the process cannot be copied, or has other threads; Interrupted on Ctrl-C
  [[nodiscard]] bool start(std::size_t run);
  /// Ends the copy; destructors of what lives are not called.
  [[noreturn]] void finish(const std::string& text);

  /// Ends the copy without a text.
  [[noreturn]] static void fail();

  /// How a copy ended.
  struct Result {
    std::string text;     ///< what it returned
    std::string problem;  ///< why there is no such text; empty: there is
  };
  /// Results of all copies by their numbers, once all have ended.
  [[nodiscard]] std::map<std::size_t, Result> wait();

 private:
  struct Child {
    std::size_t run = 0;
    pid_t process = 0;
    int pipe = -1;
    double end = 0.0;  ///< [s] of the steady clock
    std::string text;
  };
  void wait_until_fewer_than(std::size_t count);
  void read_from(Child& child);
  void collect(std::size_t k);

  std::size_t at_once_;
  double deadline_;
  int to_parent_ = -1;  ///< of a copy
  std::vector<Child> children_;
  std::map<std::size_t, Result> results_;
};

}  // namespace stonestack::bench
