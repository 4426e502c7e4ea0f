#include "stacking/record.hpp"

#include "stacking/arrangement.hpp"

namespace stonestack::stacking {

bool Recorder::is_news(const Event& event) {
  if (const auto* seen = std::get_if<StoneUncertain>(&event)) return uncertain_.insert(seen->stone).second;
  if (const auto* unfit = std::get_if<StonesUnfit>(&event)) return !unfit->stones.empty();
  if (const auto* held = std::get_if<StonesNotHeld>(&event)) {
    const std::string stones = to_text(event, *models_.catalogue);
    const bool news = stones != not_held_ && !held->stones.empty();
    not_held_ = stones;
    return news;
  }
  return true;
}

void Recorder::go_on_from(const ResumePoint& before) {
  result_.seconds = before.seconds;
  if (!before.state) return;
  result_.world = before.state->world;
  result_.placements = before.state->memory.records;
  result_.events.emplace_back(Observed{result_.world});  // so that the page shows the stones from the start
  result_.timeline.event_time.push_back(clock_.now());
}

void Recorder::hear(const Event& event) {
  if (!is_news(event)) return;
  if (const auto* seen = std::get_if<Observed>(&event)) {
    result_.world = seen->world;
    // A wall's stones touch others: all that stand count.
    result_.height = models_.wall ? static_cast<int>(seen->world.stack.size())
                                  : clean_height(models_.shapes, at_rest(seen->world));
  } else if (const auto* measured = std::get_if<WallMeasured>(&event)) {
    result_.wall = measured->wall;
  } else if (const auto* judged = std::get_if<PlacementJudged>(&event)) {
    result_.placements.push_back(judged->record);
  } else if (const auto* ended = std::get_if<RunEnded>(&event)) {
    result_.end = ended->end;
    result_.ended = ended->reason;
  }
  result_.events.push_back(event);
  result_.timeline.event_time.push_back(clock_.now());
  record(hooks_.journal, event, *models_.catalogue);
  if (hooks_.listener) hooks_.listener(event);
}

void record(Journal* journal, const Event& event, const Catalogue& catalogue) {
  if (journal == nullptr) return;
  const auto* step = std::get_if<StepBegun>(&event);
  if (step != nullptr) journal->begin_step(step->name);
  const auto [kind, data] = to_record(event, catalogue);
  if (!kind.empty()) journal->record(kind, data, step != nullptr ? journal->arm() : std::string());
}

}  // namespace stonestack::stacking
