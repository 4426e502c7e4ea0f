#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ranks.hpp"

namespace stonestack::mpi {

/// Performs the task of that number, whose files are in `folder`; called in a thread of its own.
/// @return the text that rank 0 takes
using Perform = std::function<std::string(const std::string& folder, int number)>;
/// Takes what tasks have returned, in the order in which they ended.
using TakeTexts = std::function<void(const std::vector<std::string>&)>;

/// Rank 0, which deals tasks to all ranks and performs some itself. Its end ends the other ranks.
class Dealer {
 public:
  explicit Dealer(const Ranks& ranks) : ranks_(ranks) {}
  /// Breaks off what the others still do, and hears them until they are gone: one that still sends would wait
  /// for ever.
  ~Dealer();
  Dealer(const Dealer&) = delete;
  Dealer& operator=(const Dealer&) = delete;

  /// Deals the tasks one by one, since their times differ by ten, until none is left or the user interrupts.
  /// @throws Error what a task threw, after what has ended was taken; and what `take` throws
  void deal(const std::string& folder, const std::vector<int>& numbers, const Perform& perform,
            const TakeTexts& take);

 private:
  struct Deal;
  std::optional<std::string> answer(Message message, const std::string& folder, Deal& deal);

  const Ranks& ranks_;
  int gone_ = 0;  ///< others that have left
};

/// Performs the tasks that rank 0 deals to this rank, until there are none.
void perform_dealt(const Ranks& ranks, const Perform& perform);

}  // namespace stonestack::mpi
