#pragma once
#include <set>
#include <string>

#include "stacking/resume_point.hpp"
#include "stonestack/stacking/build_tower.hpp"

/// Private to stacking/: what is made of the events of a run.
namespace stonestack::stacking {

/// Keeps the result, writes the journal, and passes events on; a repeated statement is dropped.
class Recorder {
 public:
  Recorder(const Models& models, const BuildHooks& hooks, const Clock& clock)
      : models_(models), hooks_(hooks), clock_(clock) {}

  /// Starts from what a run that goes on has done already.
  void go_on_from(const ResumePoint& before);
  void hear(const Event& event);
  [[nodiscard]] RunResult& result() { return result_; }

 private:
  [[nodiscard]] bool is_news(const Event& event);

  const Models& models_;
  const BuildHooks& hooks_;
  const Clock& clock_;
  RunResult result_;
  std::set<StoneIndex> uncertain_;
  std::string not_held_;
};

/// Writes an event to a journal; null: to none.
void record(Journal* journal, const Event& event, const Catalogue& catalogue = {});

}  // namespace stonestack::stacking
