#pragma once
#include <optional>
#include <string>

/// stonestack-mpi: experiments and benchmarks on many processes, by MPI. The library knows nothing of it.
namespace stonestack::mpi {

/// Meaning of a message from rank to rank.
enum class Word {
  kReady,    ///< to rank 0: asks for a task
  kEnded,    ///< to rank 0: text of a task that ended
  kFailed,   ///< to rank 0: why there will be none
  kGone,     ///< to rank 0: the last word, with the reason where nothing ended it
  kPerform,  ///< from rank 0: number of a task, a blank, its folder
  kEnd,      ///< from rank 0: there is nothing more to do
};

/// A message as it arrived.
struct Message {
  Word word = Word::kEnd;
  int from = 0;
  std::string text;
};

/// The processes that mpirun has started, all of them alike. One object lives as long as the program works;
/// only the thread that made it calls it.
class Ranks {
 public:
  Ranks(int& argc, char**& argv);
  /// Waits for the other ranks.
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  [[nodiscard]] int rank() const { return rank_; }
  [[nodiscard]] int size() const { return size_; }
  /// Name of the machine.
  [[nodiscard]] std::string host() const;
  /// Sends a message to another rank; returns before that rank asks for it only if the message is short.
  void send(int to, Word word, const std::string& text = {}) const;
  /// Takes a message that has arrived; empty: none has.
  [[nodiscard]] std::optional<Message> receive() const;

 private:
  int rank_ = 0;
  int size_ = 1;
};

}  // namespace stonestack::mpi
