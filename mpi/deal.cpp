#include "deal.hpp"

#include <chrono>
#include <deque>
#include <exception>
#include <future>
#include <sstream>
#include <thread>
#include <utility>

#include "stonestack/core/error.hpp"

namespace stonestack::mpi {
namespace {

constexpr auto kPause = std::chrono::milliseconds(5);  // between two looks for messages; a task takes seconds

/// A task that this rank performs in a thread of its own, while it hears the others.
class TaskUnderWay {
 public:
  explicit TaskUnderWay(const Perform& perform) : perform_(perform) {}
  /// Ends the task at its next safe point.
  ~TaskUnderWay() {
    if (task_.valid()) note_interrupt();
  }
  TaskUnderWay(const TaskUnderWay&) = delete;
  TaskUnderWay& operator=(const TaskUnderWay&) = delete;

  void begin(const std::string& folder, int number) {
    task_ = std::async(std::launch::async, [this, folder, number] { return perform_(folder, number); });
  }
  [[nodiscard]] bool idle() const { return !task_.valid(); }
  [[nodiscard]] bool has_ended() const {
    return task_.valid() && task_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
  /// Text of the task that has ended; throws what ended it.
  [[nodiscard]] std::string take() { return task_.get(); }

 private:
  const Perform& perform_;
  std::future<std::string> task_;
};

/// Takes what tasks have given, in a thread of its own: a record of many runs takes seconds to write, for
/// which no rank need wait.
class Taker {
 public:
  explicit Taker(const TakeTexts& take) : take_(take) {}
  void add(std::string text) { waiting_.push_back(std::move(text)); }
  /// Begins to take what waits, if nothing is being taken. Throws what the last call of `take` threw.
  void go_on() {
    if (taking_.valid()) {
      if (taking_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
      taking_.get();
    }
    if (waiting_.empty()) return;
    taking_ = std::async(std::launch::async, [this, texts = std::exchange(waiting_, {})] { take_(texts); });
  }
  /// Takes all that waits.
  void finish() {
    while (!waiting_.empty() || taking_.valid()) {
      if (taking_.valid()) taking_.wait();
      go_on();
    }
  }

 private:
  const TakeTexts& take_;
  std::vector<std::string> waiting_;
  std::future<void> taking_;
};

}  // namespace

/// Tasks that no rank has yet, and the other ranks.
struct Dealer::Deal {
  std::deque<int> left;
  int under_way = 0;    ///< tasks that others perform
  std::string failure;  ///< why no more are dealt; empty: they are

  int next() {
    const int number = left.front();
    left.pop_front();
    return number;
  }
};

/// Answers one message of another rank.
/// @return what it has performed; empty: it says something else
std::optional<std::string> Dealer::answer(Message message, const std::string& folder, Deal& deal) {
  if (message.word == Word::kFailed || message.word == Word::kGone) {
    deal.failure = message.text;
    gone_ += message.word == Word::kGone ? 1 : 0;
    return std::nullopt;
  }
  if (message.word == Word::kEnded) --deal.under_way;
  if (!deal.left.empty()) {
    ranks_.send(message.from, Word::kPerform, concat(deal.next(), ' ', folder));
    ++deal.under_way;
  }
  if (message.word == Word::kEnded) return std::move(message.text);
  return std::nullopt;
}

void Dealer::deal(const std::string& folder, const std::vector<int>& numbers, const Perform& perform,
                  const TakeTexts& take) {
  Deal deal;
  deal.left.assign(numbers.begin(), numbers.end());
  Taker taker(take);
  TaskUnderWay own(perform);
  while (!interrupt_noted() && deal.failure.empty() &&
         (!deal.left.empty() || deal.under_way > 0 || !own.idle())) {
    while (auto message = ranks_.receive())
      if (auto text = answer(std::move(*message), folder, deal)) taker.add(std::move(*text));
    if (own.has_ended()) {
      try {
        taker.add(own.take());
      } catch (const Interrupted&) {  // noted
      } catch (const Error& error) {
        deal.failure = error.what();
      }
    }
    if (own.idle() && !deal.left.empty()) own.begin(folder, deal.next());
    taker.go_on();
    std::this_thread::sleep_for(kPause);
  }
  taker.finish();
  if (!deal.failure.empty() && !interrupt_noted()) throw Error(deal.failure, ExitCode::kUnreadable);
}

Dealer::~Dealer() {
  for (int other = 1; other < ranks_.size(); ++other) ranks_.send(other, Word::kEnd);
  for (int here = ranks_.size() - 1 - gone_; here > 0;) {
    const auto message = ranks_.receive();
    if (message && message->word == Word::kGone) --here;
    if (!message) std::this_thread::sleep_for(kPause);
  }
}

void perform_dealt(const Ranks& ranks, const Perform& perform) {
  {
    TaskUnderWay own(perform);
    ranks.send(0, Word::kReady);
    for (;;) {
      if (const auto message = ranks.receive()) {
        if (message->word == Word::kEnd) break;
        std::istringstream words(message->text);
        int number = 0;
        std::string folder;
        std::getline(words >> number >> std::ws, folder);
        own.begin(folder, number);
      }
      if (own.has_ended()) {
        try {
          ranks.send(0, Word::kEnded, own.take());
        } catch (const std::exception& error) {
          ranks.send(0, Word::kFailed,
                     concat("rank ", ranks.rank(), " on ", ranks.host(), ": ", error.what()));
        }
      }
      std::this_thread::sleep_for(kPause);
    }
  }
  ranks.send(0, Word::kGone);
}

}  // namespace stonestack::mpi
