#include "deal_runs.hpp"

#include <chrono>
#include <deque>
#include <exception>
#include <future>
#include <sstream>
#include <thread>
#include <utility>
#include <vector>

#include "stonestack/core/error.hpp"

namespace stonestack::mpi {
namespace {

constexpr auto kPause = std::chrono::milliseconds(5);  // between two looks for messages; a run takes seconds

/// A run that this rank performs in a thread of its own, while it hears the others.
class RunUnderWay {
 public:
  RunUnderWay(const ExperimentOrder& order, const Catalogue& catalogue)
      : order_(order), catalogue_(catalogue) {}
  /// Ends the run at its next safe point.
  ~RunUnderWay() {
    if (run_.valid()) note_interrupt();
  }
  RunUnderWay(const RunUnderWay&) = delete;
  RunUnderWay& operator=(const RunUnderWay&) = delete;

  void begin(const std::string& folder, int number) {
    run_ = std::async(std::launch::async, [this, folder, number] {
      return perform_experiment_run(order_, catalogue_, folder, number);
    });
  }
  [[nodiscard]] bool idle() const { return !run_.valid(); }
  [[nodiscard]] bool has_ended() const {
    return run_.valid() && run_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
  /// Text of the run that has ended; throws what ended it.
  [[nodiscard]] std::string take() { return run_.get(); }

 private:
  const ExperimentOrder& order_;
  const Catalogue& catalogue_;
  std::future<std::string> run_;
};

/// Runs that no rank has yet, and the other ranks.
struct Deal {
  std::deque<int> left;
  int under_way = 0;    ///< runs that others perform
  int gone = 0;         ///< others that have left
  std::string failure;  ///< why no more are dealt; empty: they are
};

/// Next run to perform.
int next_of(Deal& deal) {
  const int number = deal.left.front();
  deal.left.pop_front();
  return number;
}

/// Adds the runs that have ended to the record, in a thread of its own: a record of many runs takes seconds
/// to write, for which no rank need wait.
class RecordWriter {
 public:
  explicit RecordWriter(std::function<void(const std::vector<std::string>&)> write)
      : write_(std::move(write)) {}
  void add(std::string run) { waiting_.push_back(std::move(run)); }
  /// Begins to write what waits, if nothing is being written. Throws FileError of what was.
  void go_on() {
    if (writing_.valid()) {
      if (writing_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
      writing_.get();
    }
    if (waiting_.empty()) return;
    writing_ = std::async(std::launch::async, [this, runs = std::exchange(waiting_, {})] { write_(runs); });
  }
  [[nodiscard]] bool idle() const { return waiting_.empty() && !writing_.valid(); }
  /// Writes all that waits.
  void finish() {
    while (!idle()) {
      if (writing_.valid()) writing_.wait();
      go_on();
    }
  }

 private:
  std::function<void(const std::vector<std::string>&)> write_;
  std::vector<std::string> waiting_;
  std::future<void> writing_;
};

/// Answers one message of another rank.
void answer(const Ranks& ranks, Message message, const std::string& folder, Deal& deal,
            RecordWriter& writer) {
  if (message.word == Word::kFailed || message.word == Word::kGone) {
    deal.failure = message.text;
    deal.gone += message.word == Word::kGone ? 1 : 0;
    return;
  }
  if (message.word == Word::kRun) {
    --deal.under_way;
    writer.add(std::move(message.text));
  }
  if (deal.left.empty()) return;
  ranks.send(message.from, Word::kPerform, concat(next_of(deal), ' ', folder));
  ++deal.under_way;
}

/// Performs what rank 0 deals until it sends kEnd, which breaks off a run under way.
void serve(const Ranks& ranks, const ExperimentOrder& order, const Catalogue& catalogue) {
  RunUnderWay own(order, catalogue);
  ranks.send(0, Word::kReady);
  for (;;) {
    if (const auto message = ranks.receive()) {
      if (message->word == Word::kEnd) return;
      std::istringstream words(message->text);
      int number = 0;
      std::string folder;
      std::getline(words >> number >> std::ws, folder);
      own.begin(folder, number);
    }
    if (own.has_ended()) {
      try {
        ranks.send(0, Word::kRun, own.take());
      } catch (const std::exception& error) {
        ranks.send(0, Word::kFailed, concat("rank ", ranks.rank(), " on ", ranks.host(), ": ", error.what()));
      }
    }
    std::this_thread::sleep_for(kPause);
  }
}

/// Ends the other ranks and hears them until they are gone: one that still sends would wait for ever.
void dismiss(const Ranks& ranks, int gone) {
  for (int other = 1; other < ranks.size(); ++other) ranks.send(other, Word::kEnd);
  for (int here = ranks.size() - 1 - gone; here > 0;) {
    const auto message = ranks.receive();
    if (message && message->word == Word::kGone) --here;
    if (!message) std::this_thread::sleep_for(kPause);
  }
}

}  // namespace

RecordedExperiment deal_runs(const Ranks& ranks, ExperimentOrder order, const Catalogue& catalogue,
                             const std::function<void(const std::string& lines)>& listener) {
  const ExperimentOrder of_a_run = order;
  Deal deal;
  order.perform_elsewhere = [&](const std::string& folder, const std::vector<int>& numbers,
                                const TakeRuns& take) {
    deal.left.assign(numbers.begin(), numbers.end());
    RecordWriter writer([&](const std::vector<std::string>& runs) { listener(take(runs)); });
    RunUnderWay own(of_a_run, catalogue);
    while (!interrupt_noted() && deal.failure.empty() &&
           (!deal.left.empty() || deal.under_way > 0 || !own.idle())) {
      while (auto message = ranks.receive()) answer(ranks, std::move(*message), folder, deal, writer);
      if (own.has_ended()) {
        try {
          writer.add(own.take());
        } catch (const Interrupted&) {  // noted
        } catch (const Error& error) {
          deal.failure = error.what();
        }
      }
      if (own.idle() && !deal.left.empty()) own.begin(folder, next_of(deal));
      writer.go_on();
      std::this_thread::sleep_for(kPause);
    }
    writer.finish();
    if (!deal.failure.empty() && !interrupt_noted()) throw Error(deal.failure, ExitCode::kUnreadable);
  };
  try {
    RecordedExperiment done = record_experiment(order, catalogue);
    dismiss(ranks, deal.gone);
    return done;
  } catch (...) {
    dismiss(ranks, deal.gone);
    throw;
  }
}

void perform_dealt_runs(const Ranks& ranks, const ExperimentOrder& order, const Catalogue& catalogue) {
  serve(ranks, order, catalogue);
  ranks.send(0, Word::kGone);
}

}  // namespace stonestack::mpi
